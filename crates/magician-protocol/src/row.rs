//! Rows of the command table: what is known of a command, and how it is found by id or name.

use core::fmt;

use crate::commands::TABLE;
use crate::text::until_nul;
use crate::{AlarmSet, Ctrl, FieldType, LayoutInfo};

/// Area of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Chapter {
    /// The device itself: name, version, clock (1.3).
    Info,
    /// Position of the arm (1.4).
    Pose,
    /// Alarms (1.5).
    Alarm,
    /// Homing (1.6).
    Home,
    /// Teaching by hand (1.7).
    Teach,
    /// Tool and end effector (1.8).
    Tool,
    /// Jogging: motion while a key is held (1.9).
    Jog,
    /// Point-to-point moves (1.10).
    Ptp,
    /// Continuous path (1.11).
    Cp,
    /// Arcs and circles (1.12).
    Arc,
    /// Waiting in the queue (1.13).
    Wait,
    /// Waiting for an input (1.14).
    Trigger,
    /// Pins, steppers and sensors (1.15).
    Io,
    /// Corrections kept without power (1.16).
    Calibration,
    /// The wireless network (1.17).
    Wifi,
    /// Detection of lost steps (1.18).
    LostStep,
    /// Control of the queue (1.19).
    Queue,
}

/// Source of a command's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Source {
    /// The vendor's document V1.1.3.
    Document,
    /// The vendor's document V1.1.5.
    Addition,
    /// Vendor headers only.
    Header,
}

/// Confidence in a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Confidence {
    /// Several independent sources agree.
    High,
    /// A single good source, or several that leave something open.
    Medium,
    /// A single source, and no record of the command in use.
    Low,
}

/// Effect of a command, as far as it matters to the sender.
///
/// ```
/// use magician_protocol::{Effect, Row};
///
/// assert_eq!(Row::find("PTPCmd").unwrap().effect, Effect::Motion);
/// assert_eq!(Row::find("GetPose").unwrap().effect, Effect::Look);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Effect {
    /// Reports a value and changes nothing.
    Look,
    /// Reports a value and clears it (errata, open question 11).
    Consume,
    /// Sets a value, which is kept until it is set again or the arm is switched off.
    Setting,
    /// Changes what the arm keeps without power.
    Store,
    /// Moves the arm; finished when the arm stands still.
    Motion,
    /// Moves the arm until another command stops it.
    Jog,
    /// Runs an external motor.
    Motor,
    /// Switches the laser.
    Laser,
    /// Makes the queue wait for a time or an input.
    Wait,
    /// Starts, stops or changes the queue.
    Queue,
}

impl Effect {
    /// Name in JSON and on pages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Look => "look",
            Self::Consume => "consume",
            Self::Setting => "setting",
            Self::Store => "store",
            Self::Motion => "motion",
            Self::Jog => "jog",
            Self::Motor => "motor",
            Self::Laser => "laser",
            Self::Wait => "wait",
            Self::Queue => "queue",
        }
    }

    /// True if the command moves the arm.
    #[must_use]
    pub const fn moves_arm(self) -> bool {
        matches!(self, Self::Motion | Self::Jog)
    }

    /// True if the command moves the arm or an external motor.
    #[must_use]
    pub const fn moves(self) -> bool {
        self.moves_arm() || matches!(self, Self::Motor)
    }
}

/// A command of the protocol, with everything the table says about it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Row {
    /// Id in the frame.
    pub id: u8,
    /// Vendor's name, without Get or Set.
    pub name: &'static str,
    /// Purpose, as a sentence.
    pub doc: &'static str,
    /// Area of the protocol.
    pub chapter: Chapter,
    /// Section of the document; empty if the document does not have the command.
    pub section: &'static str,
    /// Source of the description.
    pub source: Source,
    /// Confidence in the layout.
    pub confidence: Confidence,
    /// Errata that correct the document (docs/reference/ERRATA.md): `E22`, `E18 to E20`; empty if
    /// it is right.
    pub errata: &'static str,
    /// True if a set may be queued.
    pub queueable: bool,
    /// True if an immediate set may be retransmitted when its reply is lost.
    pub resendable: bool,
    /// True if a set may damage what the arm keeps without power; [`danger`](Self::danger) says
    /// how.
    pub dangerous: bool,
    /// Effect; for a row with get and set, the effect of the set.
    pub effect: Effect,
    /// True if a set can switch the laser on, depending on its parameters.
    pub may_burn: bool,
    /// True if the controller acts on a set at once and ignores the queued bit.
    pub(crate) controls_queue: bool,
    /// Name of the get form.
    pub get_name: &'static str,
    /// Name of the set form.
    pub set_name: &'static str,
    /// Parameters of a get. `None` if there is no get.
    pub query: Option<&'static LayoutInfo>,
    /// Parameters of the reply to a get. `None` if there is no get.
    pub value: Option<&'static LayoutInfo>,
    /// Parameters of a set. `None` if there is no set.
    pub set: Option<&'static LayoutInfo>,
}

/// Error of a name or id without a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NameError;

impl fmt::Display for NameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no command of this name or id")
    }
}

impl core::error::Error for NameError {}

// The table has fewer than 255 rows.
const NO_ROW: u8 = u8::MAX;

// Index in TABLE by id, computed at compile time: lookup runs for every frame.
static INDEX: [u8; 256] = {
    let mut index = [NO_ROW; 256];
    let mut at = 0;
    while at < TABLE.len() {
        index[TABLE[at].id as usize] = at as u8;
        at += 1;
    }
    index
};

/// Size for a layout that is absent or open-ended; no layout is as large.
const NO_FIXED_SIZE: u8 = u8::MAX;

/// Sizes of each id's query, value and set.
static LAYOUT_SIZES: [[u8; 3]; 256] = {
    let mut sizes = [[NO_FIXED_SIZE; 3]; 256];
    let mut at = 0;
    while at < TABLE.len() {
        let row = &TABLE[at];
        sizes[row.id as usize] = [
            layout_size(row.query),
            layout_size(row.value),
            layout_size(row.set),
        ];
        at += 1;
    }
    sizes
};

const fn layout_size(info: Option<&LayoutInfo>) -> u8 {
    match info {
        Some(info) => match info.size() {
            Some(size) => size as u8,
            None => NO_FIXED_SIZE,
        },
        None => NO_FIXED_SIZE,
    }
}

impl Row {
    /// Danger of a set, as the rest of a sentence that begins with the command's name ("can brick
    /// ..."). `None` if a set is not dangerous.
    #[must_use]
    pub const fn danger(&self) -> Option<&'static str> {
        match (self.dangerous, self.id) {
            (false, _) => None,
            // The key at the base starts a program in the flash, without any host (model section
            // 12).
            (true, 243) => Some(
                "writes the commands that follow to the arm's flash, where the key at the base can run them later",
            ),
            (true, _) => Some("can brick, uncalibrate or unlock the arm"),
        }
    }

    /// True if frames of an id usually have this many parameter bytes: the size of one of its
    /// layouts, or a queue index.
    #[inline]
    pub(crate) fn has_usual_size(id: u8, ctrl: Ctrl, count: usize) -> bool {
        let sizes = &LAYOUT_SIZES[usize::from(id)];
        // Eight bytes are the index in the reply to a queued command.
        sizes.iter().any(|size| usize::from(*size) == count) || count == 8 && ctrl.queued()
    }

    /// True if parameters that contain the bytes of a frame may still belong to a layout without a
    /// fixed size: UTF-8 with only NULs after its NUL, a list of outputs, alarm bits.
    pub(crate) fn may_be_open_ended(&self, params: &[u8]) -> bool {
        let layouts = [self.query, self.value, self.set];
        layouts.into_iter().flatten().any(|info| {
            let last = info.fields.last().map(|field| field.ty);
            last.is_some_and(|ty| fits_open_ended(info, ty, params))
        })
    }
}

fn fits_open_ended(info: &LayoutInfo, last: FieldType, params: &[u8]) -> bool {
    match last {
        FieldType::Text => {
            let text = until_nul(params);
            let rest = params.get(text.len()..).unwrap_or_default();
            rest.iter().all(|byte| *byte == 0) && core::str::from_utf8(text).is_ok()
        }
        // Every bit may be an alarm, so only the size is a criterion.
        FieldType::Alarms => params.len() <= AlarmSet::CAPACITY,
        FieldType::Outputs => info.values(params).is_ok(),
        // Fixed sizes are covered by `has_usual_size`; plain bytes prove nothing.
        _ => false,
    }
}

impl Row {
    /// Row of an id. `None` if the Magician does not have the command.
    #[must_use]
    pub fn with_id(id: u8) -> Option<&'static Self> {
        TABLE.get(usize::from(INDEX[usize::from(id)]))
    }

    /// Row of an id that is in the table, for constants. An unknown id does not compile.
    pub(crate) const fn of(id: u8) -> &'static Self {
        let mut at = 0;
        while TABLE[at].id != id {
            at += 1;
        }
        &TABLE[at]
    }

    /// Finds a command with a get; see [`find`](Self::find).
    ///
    /// # Errors
    /// [`NameError`] if no readable command has that name.
    pub fn find_readable(name: &str) -> Result<&'static Self, NameError> {
        Self::search(name, |row| row.value.is_some())
    }

    /// Finds a command with a set; see [`find`](Self::find).
    ///
    /// # Errors
    /// [`NameError`] if no writable command has that name.
    pub fn find_writable(name: &str) -> Result<&'static Self, NameError> {
        Self::search(name, |row| row.set.is_some())
    }

    /// Finds a command by vendor name, Rust name or id (decimal, or hex after `0x`).
    ///
    /// Case, `-` and `_` are ignored, and Get or Set may be left out.
    ///
    /// `ClearAllAlarmsState` is id 20, which is what hosts send (errata E19); id 21 is found only
    /// by its id.
    ///
    /// # Errors
    /// [`NameError`] if no command has that name or id.
    pub fn find(name: &str) -> Result<&'static Self, NameError> {
        Self::search(name, |_| true)
    }

    fn search(name: &str, wanted: impl Fn(&Row) -> bool) -> Result<&'static Self, NameError> {
        if let Some(id) = parse_id(name) {
            return Self::with_id(id).filter(|row| wanted(row)).ok_or(NameError);
        }
        let mut rows = TABLE.iter().filter(|row| wanted(row));
        rows.find(|row| row.is_named(name)).ok_or(NameError)
    }

    fn is_named(&self, name: &str) -> bool {
        let is = |candidate: &str| same_name(candidate, name);
        let layouts = [self.query, self.value, self.set];
        is(self.name)
            || self.value.is_some() && is(self.get_name)
            || self.set.is_some() && (is(self.set_name) || equals_prefixed("set", self.name, name))
            || layouts.into_iter().flatten().any(|info| is(info.name))
    }

    /// True if a frame with this Ctrl is a set of this command: rw is 1, or it is queued (errata
    /// E07).
    #[must_use]
    pub const fn sets(&self, ctrl: Ctrl) -> bool {
        self.set.is_some() && (ctrl.write() || ctrl.queued() && !self.steers_queue())
    }

    /// Vendor's name for a frame with this Ctrl: the set name if the frame is a set or there is no
    /// get, else the get name.
    #[must_use]
    pub const fn form_name(&self, ctrl: Ctrl) -> &'static str {
        if self.sets(ctrl) || self.value.is_none() {
            self.set_name
        } else {
            self.get_name
        }
    }

    /// True if a frame with this Ctrl is a plain read: it changes nothing, and one reply may be
    /// shared by several hosts.
    ///
    /// False for gets that clear what they report ([`Effect::Consume`]).
    #[must_use]
    pub const fn only_looks(&self, ctrl: Ctrl) -> bool {
        let consumes = matches!(self.effect, Effect::Consume);
        self.value.is_some() && !self.sets(ctrl) && ctrl.destination() == 0 && !consumes
    }

    /// True if repeating a set leaves the value unchanged.
    #[must_use]
    pub const fn is_idempotent(&self) -> bool {
        matches!(self.effect, Effect::Setting) && self.resendable
    }

    /// True if the command controls the queue (`queue ignored` in the table): it acts at once and
    /// is never queued itself.
    #[must_use]
    pub const fn steers_queue(&self) -> bool {
        self.controls_queue
    }
}

fn parse_id(name: &str) -> Option<u8> {
    let (digits, radix) = match name.strip_prefix("0x").or(name.strip_prefix("0X")) {
        Some(hex) => (hex, 16),
        None => (name, 10),
    };
    // from_str_radix accepts a sign; "+5" is not an id.
    if digits.starts_with('+') {
        return None;
    }
    u8::from_str_radix(digits, radix).ok()
}

fn normalised_name(name: &str) -> impl Iterator<Item = u8> + '_ {
    name.bytes()
        .filter(|byte| !matches!(byte, b'-' | b'_'))
        .map(|byte| byte.to_ascii_lowercase())
}

/// True if two names are equal, ignoring case, `-` and `_`.
pub(crate) fn same_name(a: &str, b: &str) -> bool {
    normalised_name(a).eq(normalised_name(b))
}

fn equals_prefixed(prefix: &str, candidate: &str, name: &str) -> bool {
    normalised_name(prefix)
        .chain(normalised_name(candidate))
        .eq(normalised_name(name))
}
