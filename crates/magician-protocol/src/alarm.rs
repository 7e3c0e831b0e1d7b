//! The controller's alarms: one table with names, causes and remedies, and the bit set that
//! `GetAlarmsState` returns.
//!
//! The table also has alarms that only the Magician's siblings are known to raise; `magician` is
//! false for those. The texts of `cause` and `remedy` are shown to users.

use core::fmt;

use crate::{DecodeError, FieldType, Reader, Wire, Writer};

/// Family of an alarm: the high nibble of its code, sixteen codes each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AlarmGroup {
    /// 0x00: the controller itself.
    Common,
    /// 0x10: found while planning, before the arm moves.
    Plan,
    /// 0x20: found while moving.
    Move,
    /// 0x30: a joint too fast.
    Overspeed,
    /// 0x40: a joint at its limit.
    Limit,
    /// 0x50: a joint lost steps.
    LostStep,
    /// 0x60: motor drivers.
    Other,
}

/// An alarm of the controller (document 1.5.1; names as the vendor's alarm list has them).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// Bit in the alarm state, 0x00 to 0x6B.
    pub code: u8,
    /// Name.
    pub name: &'static str,
    /// Family.
    pub group: AlarmGroup,
    /// Cause, as a clause without a full stop.
    pub cause: &'static str,
    /// Remedy, as an instruction to the user.
    pub remedy: &'static str,
    /// True if the controller clears the alarm by itself once its cause is gone.
    pub clears_itself: bool,
    /// True if the Magician is known to raise the alarm; otherwise only its siblings' lists have
    /// it.
    pub magician: bool,
}

const CLEAR: &str = "clear the alarms";
const HOME: &str = "home the arm";
const OTHER_TARGET: &str = "choose another target, then clear the alarms";
const SLOWER: &str = "lower the speed ratio, then clear the alarms";
const JOG_BACK: &str = "jog the joint back into its range, which clears this alarm; then clear the alarms to \
        release the queue";
const REHOME: &str = "remove the obstacle, home the arm, then clear the alarms";
const POWER: &str = "switch the arm off and on";

macro_rules! alarms {
    ($( $code:literal $name:ident $group:ident $cause:literal $remedy:expr, $itself:ident $magician:ident; )+) => {
        impl Alarm {
            $(
                #[doc = concat!("Alarm ", $code, ": ", $cause, ".")]
                #[allow(non_upper_case_globals)]
                pub const $name: u8 = $code;
            )+

            /// All named alarms, ordered by code.
            pub const TABLE: &'static [Self] = &[ $( Self {
                code: $code,
                name: stringify!($name),
                group: AlarmGroup::$group,
                cause: $cause,
                remedy: $remedy,
                clears_itself: alarms!(@ $itself),
                magician: alarms!(@ $magician),
            }, )+ ];
        }
    };
    (@ itself) => { true };
    (@ stays) => { false };
    (@ magician) => { true };
    (@ sibling) => { false };
}

alarms! {
    0x00 ResetOccurred Common "the controller was reset or switched on" HOME, stays magician;
    0x01 UndefinedInstruction Common "the controller received a command that it does not know" CLEAR, stays magician;
    0x02 FileSystemError Common "the controller's flash memory did not open" POWER, itself magician;
    0x03 McuFpgaCommError Common "the processor and the motor logic (FPGA) could not communicate at start-up" POWER, itself magician;
    0x04 AngleSensorError Common "an angle sensor reads an impossible value" POWER, stays magician;
    0x10 PlanInvSingularity Plan "the target is a singular pose" OTHER_TARGET, stays magician;
    0x11 PlanInvCalc Plan "the target is out of reach" OTHER_TARGET, stays magician;
    0x12 PlanInvLimit Plan "the target would take a joint beyond its limit" OTHER_TARGET, stays magician;
    0x13 PlanPushDataRepeat Plan "two points of an arc coincide" OTHER_TARGET, stays magician;
    0x14 PlanArcInputParam Plan "the three points of an arc are collinear" OTHER_TARGET, stays magician;
    0x15 PlanJumpParam Plan "the jump heights contradict each other" "set other jump heights, then clear the alarms", stays magician;
    0x16 PlanLineHand Plan "a straight line would change the elbow side" CLEAR, stays sibling;
    0x17 PlanLineOutSpace Plan "a straight line would leave the workspace" CLEAR, stays sibling;
    0x18 PlanArcOutSpace Plan "an arc would leave the workspace" CLEAR, stays sibling;
    0x19 PlanMotionType Plan "the kind of motion is unknown" CLEAR, stays sibling;
    0x1A PlanSpeedInputParam Plan "a speed or acceleration is zero, negative or not a number" "set the speeds, then clear the alarms", stays sibling;
    0x1B PlanCpCalc Plan "the continuous path could not be calculated" CLEAR, stays sibling;
    0x20 MoveInvSingularity Move "the path reached a singular pose" "jog away joint by joint, then clear the alarms", stays magician;
    0x21 MoveInvCalc Move "the path left the workspace" "move back inside the workspace, then clear the alarms", stays magician;
    0x22 MoveInvLimit Move "the path took a joint to its limit" "move back inside the workspace, then clear the alarms", stays magician;
    0x30 OverspeedAxis1 Overspeed "J1 is too fast" SLOWER, stays magician;
    0x31 OverspeedAxis2 Overspeed "J2 is too fast" SLOWER, stays magician;
    0x32 OverspeedAxis3 Overspeed "J3 is too fast" SLOWER, stays magician;
    0x33 OverspeedAxis4 Overspeed "J4 is too fast" SLOWER, stays magician;
    0x40 LimitAxis1Pos Limit "J1 is at its upper limit" JOG_BACK, itself magician;
    0x41 LimitAxis1Neg Limit "J1 is at its lower limit" JOG_BACK, itself magician;
    0x42 LimitAxis2Pos Limit "J2 is at its upper limit" JOG_BACK, itself magician;
    0x43 LimitAxis2Neg Limit "J2 is at its lower limit" JOG_BACK, itself magician;
    0x44 LimitAxis3Pos Limit "J3 is at its upper limit" JOG_BACK, itself magician;
    0x45 LimitAxis3Neg Limit "J3 is at its lower limit" JOG_BACK, itself magician;
    0x46 LimitAxis4Pos Limit "J4 is at its upper limit" JOG_BACK, itself magician;
    0x47 LimitAxis4Neg Limit "J4 is at its lower limit" JOG_BACK, itself magician;
    0x48 LimitAxis23Pos Limit "the parallelogram of J2 and J3 is stretched to its limit" JOG_BACK, itself magician;
    0x49 LimitAxis23Neg Limit "the parallelogram of J2 and J3 is folded to its limit" JOG_BACK, itself magician;
    0x50 LoseStepAxis1 LostStep "J1 lost steps" REHOME, stays magician;
    0x51 LoseStepAxis2 LostStep "J2 lost steps" REHOME, stays magician;
    0x52 LoseStepAxis3 LostStep "J3 lost steps" REHOME, stays magician;
    0x53 LoseStepAxis4 LostStep "J4 lost steps" REHOME, stays magician;
    0x60 OtherAxis1DrvAlarm Other "the motor driver of axis 1 reports a fault" POWER, stays sibling;
    0x61 OtherAxis1Overflow Other "the position counter of axis 1 overflowed" POWER, stays sibling;
    0x62 OtherAxis1Follow Other "axis 1 does not follow its set point" CLEAR, stays sibling;
    0x63 OtherAxis2DrvAlarm Other "the motor driver of axis 2 reports a fault" POWER, stays sibling;
    0x64 OtherAxis2Overflow Other "the position counter of axis 2 overflowed" POWER, stays sibling;
    0x65 OtherAxis2Follow Other "axis 2 does not follow its set point" CLEAR, stays sibling;
    0x66 OtherAxis3DrvAlarm Other "the motor driver of axis 3 reports a fault" POWER, stays sibling;
    0x67 OtherAxis3Overflow Other "the position counter of axis 3 overflowed" POWER, stays sibling;
    0x68 OtherAxis3Follow Other "axis 3 does not follow its set point" CLEAR, stays sibling;
    0x69 OtherAxis4DrvAlarm Other "the motor driver of axis 4 reports a fault" POWER, stays sibling;
    0x6A OtherAxis4Overflow Other "the position counter of axis 4 overflowed" POWER, stays sibling;
    0x6B OtherAxis4Follow Other "axis 4 does not follow its set point" CLEAR, stays sibling;
}

impl Alarm {
    /// Returns the alarm with a code. `None` if the code has no name.
    #[must_use]
    pub fn with_code(code: u8) -> Option<&'static Self> {
        Self::TABLE.iter().find(|alarm| alarm.code == code)
    }

    /// Hint for a [kinematic](Self::is_kinematic) alarm of an arm whose tool bias is 0.
    pub const TOOL_UNKNOWN: &str = "the tool is unknown to the arm: its bias is 0,0,0, so x, y and z are those of the \
        wrist; if a tool is mounted, set its bias (EndEffectorParams, 59.7,0,0 for the suction \
        cup)";

    /// True if the alarm reports a pose out of reach or beyond a joint limit.
    ///
    /// These are 0x10 to 0x12 (raised before a motion) and 0x20 to 0x22 (raised during one). A
    /// wrong tool bias is a common cause of both.
    #[must_use]
    pub const fn is_kinematic(code: u8) -> bool {
        matches!(code, 0x10..=0x12 | 0x20..=0x22)
    }

    /// True if an alarm with this code holds the queue: all but 0x00 to 0x07 (model section 4).
    #[must_use]
    pub const fn blocks(code: u8) -> bool {
        code > 7
    }
}

/// Set of active alarms: bit n % 8 of byte n / 8 is alarm n (errata E20).
///
/// The Magician sends 16 bytes, its siblings up to 32; the length received is kept, so that a set
/// writes back the same bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct AlarmSet {
    bytes: [u8; Self::CAPACITY],
    len: u8,
}

impl AlarmSet {
    /// Largest alarm state, bytes.
    pub const CAPACITY: usize = 32;

    /// Creates an empty set of 16 bytes, the Magician's length.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; Self::CAPACITY],
            len: 16,
        }
    }

    /// Creates a set from an alarm state. `None` unless it has 1 to 32 bytes.
    #[must_use]
    pub fn from_bytes(from: &[u8]) -> Option<Self> {
        let mut bytes = [0; Self::CAPACITY];
        bytes.get_mut(..from.len())?.copy_from_slice(from);
        (!from.is_empty()).then_some(Self {
            bytes,
            len: from.len() as u8,
        })
    }

    /// Alarm state as on the wire.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// True if the alarm is active.
    #[must_use]
    pub fn contains(&self, code: u8) -> bool {
        self.bytes[usize::from(code / 8)] & (1 << (code % 8)) != 0
    }

    /// Raises an alarm. A code beyond the current length makes the state longer.
    pub fn insert(&mut self, code: u8) {
        self.bytes[usize::from(code / 8)] |= 1 << (code % 8);
        self.len = self.len.max(code / 8 + 1);
    }

    /// Clears an alarm.
    pub fn remove(&mut self, code: u8) {
        self.bytes[usize::from(code / 8)] &= !(1 << (code % 8));
    }

    /// True if no alarm is active.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bytes.iter().all(|byte| *byte == 0)
    }

    /// Active codes in ascending order.
    pub fn codes(&self) -> impl Iterator<Item = u8> + '_ {
        (0..=u8::MAX).filter(|code| self.contains(*code))
    }

    /// True if an active alarm holds the queue.
    #[must_use]
    pub fn blocking(&self) -> bool {
        // The first byte has codes 0x00 to 0x07, which do not hold it (see `Alarm::blocks`).
        self.bytes[1..].iter().any(|byte| *byte != 0)
    }
}

impl Default for AlarmSet {
    fn default() -> Self {
        Self::new()
    }
}

impl FromIterator<u8> for AlarmSet {
    fn from_iter<I: IntoIterator<Item = u8>>(codes: I) -> Self {
        let mut set = Self::new();
        codes.into_iter().for_each(|code| set.insert(code));
        set
    }
}

impl Wire for AlarmSet {
    const TYPE: FieldType = FieldType::Alarms;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let bytes = reader.rest();
        // Bytes beyond 32 carry no code (a code is one byte): ignored, as surplus is elsewhere
        // (E11).
        let known = bytes.get(..Self::CAPACITY).unwrap_or(bytes);
        Self::from_bytes(known).ok_or(DecodeError::Length {
            expected: 1,
            found: 0,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        writer.put(self.as_bytes());
    }
}

impl fmt::Display for AlarmSet {
    /// Writes `0x12 PlanInvLimit, 0x41 LimitAxis1Neg`, or `none` if the set is empty.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        for (at, code) in self.codes().enumerate() {
            let comma = if at == 0 { "" } else { ", " };
            let name = Alarm::with_code(code).map_or("unknown", |alarm| alarm.name);
            write!(f, "{comma}{code:#04x} {name}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for AlarmSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "AlarmSet({self})")
    }
}
