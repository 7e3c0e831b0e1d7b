use core::fmt;

use crate::commands::TABLE;
use crate::text::until_nul;
use crate::{AlarmSet, Ctrl, FieldType, LayoutInfo};

/// Area of the protocol a command belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Chapter {
    /// The device itself: name, version, clock (1.3).
    Info,
    /// Where the arm is (1.4).
    Pose,
    /// Alarms (1.5).
    Alarm,
    /// Homing (1.6).
    Home,
    /// Teaching by hand (1.7).
    Teach,
    /// What the arm carries (1.8).
    Tool,
    /// Moving while a key is held (1.9).
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
    /// Corrections that are kept without power (1.16).
    Calibration,
    /// The wireless network (1.17).
    Wifi,
    /// Finding lost steps (1.18).
    LostStep,
    /// Running and emptying the queue (1.19).
    Queue,
}

/// Where a command is described.
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

/// How sure the layout is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Confidence {
    /// Several independent sources agree.
    High,
    /// One good source, or several that leave something open.
    Medium,
    /// One source, never seen at work.
    Low,
}

/// What a command does, as far as it matters to the sender.
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
    /// It reports and changes nothing.
    Look,
    /// It reports and clears what it reports (errata, open question 11).
    Consume,
    /// It sets something to a value, until it is set again or the arm is switched off.
    Setting,
    /// It changes what the arm keeps without power.
    Store,
    /// It moves the arm, and has finished when the arm stands.
    Motion,
    /// It moves the arm until another command stops it.
    Jog,
    /// It runs an external motor.
    Motor,
    /// It switches the laser.
    Laser,
    /// It lets time pass.
    Wait,
    /// It changes whether the queue runs, or what is in it.
    Queue,
}

impl Effect {
    /// Its name, as in JSON and on pages.
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

    /// Whether the arm moves.
    #[must_use]
    pub const fn moves_arm(self) -> bool {
        matches!(self, Self::Motion | Self::Jog)
    }

    /// Whether something moves: the arm or an external motor.
    #[must_use]
    pub const fn moves(self) -> bool {
        self.moves_arm() || matches!(self, Self::Motor)
    }
}

/// A command of the protocol.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Row {
    /// Id in the frame.
    pub id: u8,
    /// The vendor's name, without Get or Set.
    pub name: &'static str,
    /// What it is for.
    pub doc: &'static str,
    /// Area it belongs to.
    pub chapter: Chapter,
    /// Section of the document, empty when the document does not have it.
    pub section: &'static str,
    /// Where it is described.
    pub source: Source,
    /// How sure the layout is.
    pub confidence: Confidence,
    /// Where the document is corrected (docs/reference/ERRATA.md): `E22`, `E18 to E20`, empty where it is right.
    pub errata: &'static str,
    /// Whether a set may be queued.
    pub queueable: bool,
    /// Whether an immediate set may be sent again when its answer is lost.
    pub resendable: bool,
    /// True if a set may harm what the arm keeps without power: [`danger`](Self::danger) says how.
    pub dangerous: bool,
    /// What it does; of a row that can be got and set, what its set does.
    pub effect: Effect,
    /// Whether a set can light the laser, which depends on its parameters.
    pub may_burn: bool,
    /// Whether the controller acts on a set at once, queued or not.
    pub(crate) steers: bool,
    /// Name of the get form.
    pub get_name: &'static str,
    /// Name of the set form.
    pub set_name: &'static str,
    /// What a get carries; `None` when there is no get.
    pub query: Option<&'static LayoutInfo>,
    /// What the answer to a get carries; `None` when there is no get.
    pub value: Option<&'static LayoutInfo>,
    /// What a set carries; `None` when there is no set.
    pub set: Option<&'static LayoutInfo>,
}

/// A name that stands for no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NameError;

impl fmt::Display for NameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no command of this name or id")
    }
}

impl core::error::Error for NameError {}

const NO_ROW: u8 = u8::MAX;

static INDEX: [u8; 256] = {
    let mut index = [NO_ROW; 256];
    let mut at = 0;
    while at < TABLE.len() {
        index[TABLE[at].id as usize] = at as u8;
        at += 1;
    }
    index
};

/// No layout has as many bytes.
const NO_SIZE: u8 = u8::MAX;

/// The sizes of each id's query, value and set.
static SIZES: [[u8; 3]; 256] = {
    let mut sizes = [[NO_SIZE; 3]; 256];
    let mut at = 0;
    while at < TABLE.len() {
        let row = &TABLE[at];
        sizes[row.id as usize] = [size(row.query), size(row.value), size(row.set)];
        at += 1;
    }
    sizes
};

const fn size(info: Option<&LayoutInfo>) -> u8 {
    match info {
        Some(info) => match info.size() {
            Some(size) => size as u8,
            None => NO_SIZE,
        },
        None => NO_SIZE,
    }
}

impl Row {
    /// What a set of a dangerous command does, as a predicate that follows the command's name; `None`
    /// if it is not dangerous.
    #[must_use]
    pub const fn danger(&self) -> Option<&'static str> {
        match (self.dangerous, self.id) {
            (false, _) => None,
            // A program in the flash runs by the key at the base, with no host there (model section 12).
            (true, 243) => Some(
                "has what follows written to the arm's flash, where it runs later by the arm's key",
            ),
            (true, _) => Some("can brick, uncalibrate or unlock the arm"),
        }
    }

    /// Whether frames of an id usually carry this many parameter bytes: exactly those of one of
    /// its layouts, or a queue index.
    #[inline]
    pub(crate) fn usual(id: u8, ctrl: Ctrl, count: usize) -> bool {
        let sizes = &SIZES[usize::from(id)];
        sizes.iter().any(|size| usize::from(*size) == count) || count == 8 && ctrl.queued()
    }

    /// Whether these parameters can be those of a layout without a fixed size, although they look
    /// like frames: UTF-8 with nothing after its NUL, a list of outputs, alarm bits.
    pub(crate) fn takes_open(&self, params: &[u8]) -> bool {
        let layouts = [self.query, self.value, self.set];
        layouts.into_iter().flatten().any(|info| {
            let last = info.fields.last().map(|field| field.ty);
            last.is_some_and(|ty| open_fits(info, ty, params))
        })
    }
}

fn open_fits(info: &LayoutInfo, last: FieldType, params: &[u8]) -> bool {
    match last {
        FieldType::Text => {
            let text = until_nul(params);
            let rest = params.get(text.len()..).unwrap_or_default();
            rest.iter().all(|byte| *byte == 0) && core::str::from_utf8(text).is_ok()
        }
        FieldType::Alarms => params.len() <= AlarmSet::CAPACITY,
        FieldType::Outputs => info.values(params).is_ok(),
        _ => false,
    }
}

impl Row {
    /// The row of an id; `None` when the Magician does not have it.
    #[must_use]
    pub fn with_id(id: u8) -> Option<&'static Self> {
        TABLE.get(usize::from(INDEX[usize::from(id)]))
    }

    /// For the table: the row of an id that is known to stand in it.
    pub(crate) const fn of(id: u8) -> &'static Self {
        let mut at = 0;
        while TABLE[at].id != id {
            at += 1;
        }
        &TABLE[at]
    }

    /// The row of a command that can be got; see [`find`](Self::find).
    ///
    /// # Errors
    /// [`NameError`] when no readable command has that name.
    pub fn find_readable(name: &str) -> Result<&'static Self, NameError> {
        Self::search(name, |row| row.value.is_some())
    }

    /// The row of a command that can be set; see [`find`](Self::find).
    ///
    /// # Errors
    /// [`NameError`] when no writable command has that name.
    pub fn find_writable(name: &str) -> Result<&'static Self, NameError> {
        Self::search(name, |row| row.set.is_some())
    }

    /// The row that a person means: the vendor's name, the Rust name or the id (decimal or hex
    /// after `0x`), without regard to case, `-` and `_`, with or without Get or Set.
    ///
    /// `ClearAllAlarmsState` is id 20, which is what hosts send (errata E19); 21 has only its id.
    ///
    /// # Errors
    /// [`NameError`] when no command has that name.
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
            || self.set.is_some() && (is(self.set_name) || prefixed("set", self.name, name))
            || layouts.into_iter().flatten().any(|info| is(info.name))
    }

    /// Whether a frame with this Ctrl is a set of this command: rw is 1, or it is to be queued
    /// (errata E07).
    #[must_use]
    pub const fn sets(&self, ctrl: Ctrl) -> bool {
        self.set.is_some() && (ctrl.write() || ctrl.queued() && !self.steers_queue())
    }

    /// Name of the form that a frame with this Ctrl is in, as the vendor writes it; the set's for
    /// a command that has no other.
    #[must_use]
    pub const fn form_name(&self, ctrl: Ctrl) -> &'static str {
        if self.sets(ctrl) || self.value.is_none() {
            self.set_name
        } else {
            self.get_name
        }
    }

    /// Whether a frame with this Ctrl only looks: it changes nothing, and one answer will do for
    /// several hosts that ask at the same time. A get that clears what it reports
    /// ([`Effect::Consume`]) does not.
    #[must_use]
    pub const fn only_looks(&self, ctrl: Ctrl) -> bool {
        let consumes = matches!(self.effect, Effect::Consume);
        self.value.is_some() && !self.sets(ctrl) && ctrl.destination() == 0 && !consumes
    }

    /// Whether a set leaves a value that the same set once more does not change.
    #[must_use]
    pub const fn is_idempotent(&self) -> bool {
        matches!(self.effect, Effect::Setting) && self.resendable
    }

    /// Whether it steers the queue (`queue ignored` in the table): it acts at once and is never queued itself.
    #[must_use]
    pub const fn steers_queue(&self) -> bool {
        self.steers
    }
}

fn parse_id(name: &str) -> Option<u8> {
    let (digits, radix) = match name.strip_prefix("0x").or(name.strip_prefix("0X")) {
        Some(hex) => (hex, 16),
        None => (name, 10),
    };
    if digits.starts_with('+') {
        return None;
    }
    u8::from_str_radix(digits, radix).ok()
}

fn letters(name: &str) -> impl Iterator<Item = u8> + '_ {
    name.bytes()
        .filter(|byte| !matches!(byte, b'-' | b'_'))
        .map(|byte| byte.to_ascii_lowercase())
}

/// Whether two names are the same but for case, `-` and `_`.
pub(crate) fn same_name(a: &str, b: &str) -> bool {
    letters(a).eq(letters(b))
}

fn prefixed(prefix: &str, candidate: &str, name: &str) -> bool {
    letters(prefix).chain(letters(candidate)).eq(letters(name))
}
