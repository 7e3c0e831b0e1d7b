//! Validation of the scripted events: inputs, hands, keys and faults.

use std::time::Duration;

use magician_motion::JointAngles;

use super::file::{self, FaultKind, HandKind};
use super::rules::{Checked, SectionPath};
use crate::profile::PINS;
use crate::scenario::{Action, Script};
use crate::world::ExternalEvent;
use crate::{ArmInstant, Micros};

/// Highest value of an analog input (model section 13).
const ANALOG: i64 = 4095;

pub(super) fn inputs(inputs: &[file::Input], script: &mut Script) -> Checked<()> {
    for (nth, input) in inputs.iter().enumerate() {
        let at = SectionPath::entry("input", nth);
        let address = address(&at, input.address)?;
        let action = match (input.level, input.value) {
            (Some(level @ 0..=1), None) => Action::Digital {
                address,
                level: level == 1,
            },
            (Some(level), None) => {
                return at.diagnostic("level", format!("level is {level}, it must be 0 or 1"));
            }
            (None, Some(value)) => Action::Analog {
                address,
                value: analog(&at, value)?,
            },
            (Some(_), Some(_)) => {
                return at.diagnostic("value", "an input has a level or a value: give one of them");
            }
            (None, None) => {
                let message = "the input has no state: give level = 0 or 1, or value = 0 to 4095";
                return at.diagnostic("", message);
            }
        };
        script
            .timed
            .push((at.time("at", input.at.unwrap_or(0.0))?, action));
    }
    Ok(())
}

fn address(at: &SectionPath, address: i64) -> Checked<u8> {
    match u8::try_from(address) {
        Ok(pin) if (1..=PINS).contains(&usize::from(pin)) => Ok(pin),
        _ => at.diagnostic(
            "address",
            format!("address is {address}, it must be 1 to {PINS}"),
        ),
    }
}

fn analog(at: &SectionPath, value: i64) -> Checked<u16> {
    match u16::try_from(value) {
        Ok(raw) if value <= ANALOG => Ok(raw),
        _ => at.diagnostic(
            "value",
            format!("value is {value}, it must be 0 to {ANALOG}"),
        ),
    }
}

pub(super) fn hands(hands: &[file::Hand], script: &mut Script) -> Checked<()> {
    let mut state = HandState::default();
    for (nth, hand) in hands.iter().enumerate() {
        let at = SectionPath::entry("hand", nth);
        let start = at.time("at", hand.at)?;
        // There is one hand on the arm: two movements at a time would contradict each other.
        if start < state.busy_until {
            let message = "hands must be in order of time, each after the end of the one before";
            return at.diagnostic("at", message);
        }
        state.busy_until = start;
        if hand.kind != HandKind::Guide {
            at.absent(
                "joints",
                hand.joints.is_some(),
                "they are for kind = \"guide\"",
            )?;
            at.absent("over", hand.over.is_some(), "it is for kind = \"guide\"")?;
        }
        let action = match hand.kind {
            HandKind::Unlock | HandKind::Release => state.key(&at, hand.kind)?,
            HandKind::Guide => state.guide(&at, hand)?,
        };
        script.timed.push((start, action));
    }
    Ok(())
}

/// State of the hand on the forearm so far.
#[derive(Default)]
struct HandState {
    unlocked: bool,
    last: Option<JointAngles>,
    busy_until: ArmInstant,
}

impl HandState {
    fn key(&mut self, at: &SectionPath, kind: HandKind) -> Checked<Action> {
        let unlock = kind == HandKind::Unlock;
        if unlock == self.unlocked {
            let message = if unlock {
                "the unlock key is held already: release it first"
            } else {
                "the unlock key is not held: unlock first"
            };
            return at.diagnostic("kind", message);
        }
        // A new press forgets where the last guide ended: the arm may have moved meanwhile.
        (self.unlocked, self.last) = (unlock, None);
        Ok(Action::Do(ExternalEvent::Unlock(unlock)))
    }

    fn guide(&mut self, at: &SectionPath, hand: &file::Hand) -> Checked<Action> {
        if !self.unlocked {
            return at.diagnostic("kind", "a hand cannot move a locked arm: unlock first");
        }
        let joints = at.needed(
            "joints",
            hand.joints,
            "a hand guides the arm to joints = [j1, j2, j3, j4]",
        )?;
        at.numbers("joints", &joints, -360.0..=360.0, "deg")?;
        let to = JointAngles::from(joints);
        let from = self.last.replace(to);
        let Some(seconds) = hand.over else {
            return Ok(Action::Do(ExternalEvent::Guide(to)));
        };
        let over = at.span("over", seconds)?;
        let Some(from) = from else {
            let message = "the guide has no start: a guide with over needs one without over \
                before it";
            return at.diagnostic("over", message);
        };
        self.busy_until = self.busy_until.after_micros(over);
        Ok(Action::Guide { from, to, over })
    }
}

pub(super) fn keys(keys: &[file::Key], script: &mut Script) -> Checked<()> {
    for (nth, key) in keys.iter().enumerate() {
        let at = SectionPath::entry("key", nth).time("at", key.at)?;
        script
            .timed
            .push((at, Action::Do(ExternalEvent::Key(key.press))));
    }
    Ok(())
}

/// Time of a fault.
enum Moment {
    At(ArmInstant),
    Index(u64),
}

impl Moment {
    fn of(at: &SectionPath, fault: &file::Fault) -> Checked<Self> {
        match (fault.at, fault.index) {
            (Some(seconds), None) => Ok(Self::At(at.time("at", seconds)?)),
            (None, Some(index)) => match u64::try_from(index) {
                Ok(index) if index > 0 => Ok(Self::Index(index)),
                _ => at.diagnostic(
                    "index",
                    format!("index is {index}, the queue counts from 1"),
                ),
            },
            (Some(_), Some(_)) => at.diagnostic("index", "a fault has one time: give at or index"),
            (None, None) => at.diagnostic(
                "",
                "the fault has no time: give at = seconds, or index = the queued command that it \
                    hits",
            ),
        }
    }

    fn then(&self, delay: Micros, event: ExternalEvent, script: &mut Script) {
        let action = Action::Do(event);
        match self {
            Self::At(at) => script.timed.push((at.after_micros(delay), action)),
            Self::Index(index) => script.at_index.push((*index, delay, action)),
        }
    }
}

pub(super) fn faults(faults: &[file::Fault], script: &mut Script) -> Checked<()> {
    for (nth, fault) in faults.iter().enumerate() {
        let at = SectionPath::entry("fault", nth);
        check_foreign_keys(&at, fault)?;
        let moment = Moment::of(&at, fault)?;
        match fault.kind {
            FaultKind::Slip => moment.then(0, slip(&at, fault)?, script),
            FaultKind::Reset => moment.then(0, ExternalEvent::Reset, script),
            FaultKind::Alarm => moment.then(0, ExternalEvent::Alarm(alarm(&at, fault)?), script),
            FaultKind::Cable => {
                let lasting = lasting(&at, fault)?;
                moment.then(0, ExternalEvent::Cable { plugged: false }, script);
                // The end of a fault is scripted along with its start.
                moment.then(lasting, ExternalEvent::Cable { plugged: true }, script);
            }
            FaultKind::Slow => {
                let lasting = lasting(&at, fault)?;
                let delay = at.needed(
                    "delay",
                    fault.delay,
                    "by how many seconds each answer is late",
                )?;
                let delay = at.span("delay", delay)?;
                moment.then(
                    0,
                    ExternalEvent::Delay(Duration::from_micros(delay)),
                    script,
                );
                moment.then(lasting, ExternalEvent::Delay(Duration::ZERO), script);
            }
        }
    }
    Ok(())
}

/// Refuses values that belong to another kind of fault.
fn check_foreign_keys(at: &SectionPath, fault: &file::Fault) -> Checked<()> {
    use FaultKind::{Alarm, Cable, Slip, Slow};
    let owned: [(&'static str, bool, &[FaultKind], &str); 5] = [
        (
            "joint",
            fault.joint.is_some(),
            &[Slip],
            "it is for kind = \"slip\"",
        ),
        (
            "degrees",
            fault.degrees.is_some(),
            &[Slip],
            "they are for kind = \"slip\"",
        ),
        (
            "for",
            fault.lasting.is_some(),
            &[Cable, Slow],
            "it is for kind = \"cable\" and \"slow\"",
        ),
        (
            "delay",
            fault.delay.is_some(),
            &[Slow],
            "it is for kind = \"slow\"",
        ),
        (
            "alarm",
            fault.alarm.is_some(),
            &[Alarm],
            "it is for kind = \"alarm\"",
        ),
    ];
    owned.into_iter().try_for_each(|(name, there, kinds, why)| {
        at.absent(name, there && !kinds.contains(&fault.kind), why)
    })
}

fn lasting(at: &SectionPath, fault: &file::Fault) -> Checked<Micros> {
    at.span(
        "for",
        at.needed("for", fault.lasting, "how many seconds it lasts")?,
    )
}

fn slip(at: &SectionPath, fault: &file::Fault) -> Checked<ExternalEvent> {
    let joint = at.needed("joint", fault.joint, "which joint slips, 1 to 4")?;
    let degrees = at.needed("degrees", fault.degrees, "by how much the joint slips")?;
    let joint = match u8::try_from(joint) {
        Ok(joint @ 1..=4) => joint,
        _ => return at.diagnostic("joint", format!("joint is {joint}, it must be 1 to 4")),
    };
    at.number("degrees", degrees, -360.0..=360.0, "deg")?;
    Ok(ExternalEvent::Slip { joint, degrees })
}

fn alarm(at: &SectionPath, fault: &file::Fault) -> Checked<u8> {
    use magician_protocol::Alarm;
    match at.needed(
        "alarm",
        fault.alarm.as_ref(),
        "its code, as 0x40, or its name",
    )? {
        file::Alarm::Code(code) => match u8::try_from(*code) {
            Ok(code) if Alarm::with_code(code).is_some() => Ok(code),
            _ => at.diagnostic(
                "alarm",
                format!("unknown alarm {code:#04x}; docs/reference/ALARMS.md lists them"),
            ),
        },
        file::Alarm::Name(name) => {
            match Alarm::TABLE
                .iter()
                .find(|alarm| alarm.name.eq_ignore_ascii_case(name))
            {
                Some(alarm) => Ok(alarm.code),
                None => at.diagnostic(
                    "alarm",
                    format!("unknown alarm '{name}'; docs/reference/ALARMS.md lists them"),
                ),
            }
        }
    }
}
