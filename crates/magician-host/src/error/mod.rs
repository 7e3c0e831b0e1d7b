//! Errors as data: code, location, values and remedies, with the fact as a sentence.
//!
//! The sentence names no flag, verb or call, because front ends differ in these; what to do is a
//! [`Remedy`], which each front end words by its [`Voice`](crate::Voice).

mod causes;
mod code;
mod motion;
mod range;

use std::fmt;
use std::io;

use magician_motion::{Breach, FencePart};
use magician_protocol::{Alarm, AlarmSet, visible_lines};

use self::causes::span;
pub use self::code::{ErrorCode, ErrorKind};
pub(crate) use self::motion::of_motion;
use crate::remedy::{Act, Remedy, Setting, SettingValue};
use crate::{Message, message};

/// Result of the driver's operations.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Error of the driver: a sentence for people, and its parts for programs.
///
/// ```
/// use magician_host::{ErrorKind, build};
///
/// let error = build::tool_named("hammer").unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::InvalidInput);
/// assert!(error.to_string().contains("suction"));
/// ```
pub struct Error(Box<Details>);

struct Details {
    code: ErrorCode,
    message: Message,
    /// The fact in joint angles or distances from the shoulder, if the message names a position.
    detail: Option<Message>,
    /// Part of a path that lies before the point where it leaves the reach, percent.
    progress: Option<f64>,
    step: Option<usize>,
    command: Option<String>,
    value: Option<f64>,
    limit: Option<f64>,
    unit: Option<&'static str>,
    from: Option<u64>,
    to: Option<u64>,
    alarms: Option<AlarmSet>,
    remedies: Vec<Remedy>,
    /// Breach of the arm's fence.
    breach: Option<Breach>,
    /// Guard that refused the program.
    guard: Option<&'static str>,
    /// Address of the station on this machine that uses the port.
    station: Option<String>,
    source: Option<io::Error>,
}

/// Parts of an error.
impl Error {
    /// Code of the error.
    ///
    /// ```
    /// use magician_host::{ErrorCode, build};
    ///
    /// let error = build::with_rail(build::suction(true), 600.0).unwrap_err();
    /// assert_eq!(error.code(), ErrorCode::WrongCommand);
    /// ```
    #[must_use]
    pub fn code(&self) -> ErrorCode {
        self.0.code
    }

    /// Category of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        self.0.code.kind()
    }

    /// The fact, without the command and its position in a list.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// The fact as a translatable sentence.
    #[must_use]
    pub fn sentence(&self) -> &Message {
        &self.0.message
    }

    /// The fact as a translatable sentence with the text of `Display`, which may name the command.
    #[must_use]
    pub fn in_words(&self) -> Message {
        let sentence = &self.0.message;
        match sentence.template() {
            Some(template) => Message::from_parts(
                self.to_string(),
                template.into_owned(),
                sentence.values().to_vec(),
            ),
            None => self.to_string().into(),
        }
    }

    /// The fact in the terms of the arm (joints, distances from its shoulder). `None` unless the
    /// message describes it by a position.
    #[must_use]
    pub fn detail(&self) -> Option<&str> {
        self.0.detail.as_deref()
    }

    /// Remedies, the best first.
    #[must_use]
    pub fn remedies(&self) -> &[Remedy] {
        &self.0.remedies
    }

    /// Position of the command in its list, from 0. `None` for a single command.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        self.0.step
    }

    /// Vendor's name of the failed command (`GetPose`, `SetPTPCmd`), or its id.
    #[must_use]
    pub fn command(&self) -> Option<&str> {
        self.0.command.as_deref()
    }

    /// Value requested or found, in [`unit`](Self::unit).
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.0.value
    }

    /// Limit that the value exceeds, in [`unit`](Self::unit).
    #[must_use]
    pub fn limit(&self) -> Option<f64> {
        self.0.limit
    }

    /// Unit of value and limit.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        self.0.unit
    }

    /// For [`ErrorKind::Uncertain`]: first uncertain queue index. `None` if unknown.
    #[must_use]
    pub fn from_index(&self) -> Option<u64> {
        self.0.from
    }

    /// For [`ErrorKind::Uncertain`]: last uncertain queue index. `None` if unknown.
    #[must_use]
    pub fn to_index(&self) -> Option<u64> {
        self.0.to
    }

    /// For [`ErrorKind::Alarm`]: active alarms. Empty if the queue is still held by an alarm that
    /// is gone.
    #[must_use]
    pub fn alarms(&self) -> Option<&AlarmSet> {
        self.0.alarms.as_ref()
    }

    /// Guard that refused the program, by its name in [`Guards`](crate::preflight::Guards). `None`
    /// if it was not a guard.
    ///
    /// ```
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let start = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let error = start.program(&[build::laser(true)]).unwrap_err();
    /// assert_eq!(error.guard(), Some("laser"));
    /// ```
    #[must_use]
    pub fn guard(&self) -> Option<&'static str> {
        self.0.guard
    }

    /// Address of the station on this machine that uses the port, with the name of the arm if the
    /// station has several. The arm can be used through it. `None` if no station uses the port.
    ///
    /// ```
    /// use magician_host::{Error, ErrorCode};
    ///
    /// let busy = Error::new(ErrorCode::PortBusy, "/dev/ttyUSB0 is in use");
    /// let busy = busy.at_station("http://127.0.0.1:8910/", "uses the arm there");
    /// assert_eq!(busy.station(), Some("http://127.0.0.1:8910/"));
    /// assert_eq!(busy.remedies()[0].effect, "uses the arm there");
    /// ```
    #[must_use]
    pub fn station(&self) -> Option<&str> {
        self.0.station.as_deref()
    }

    /// Breach of the arm's fence. `None` for other errors.
    #[must_use]
    pub fn breach(&self) -> Option<&Breach> {
        self.0.breach.as_ref()
    }
}

/// Constructors and builders.
impl Error {
    /// Creates an error with this fact as its sentence.
    #[must_use]
    pub fn new(code: ErrorCode, message: impl Into<Message>) -> Self {
        Self(Box::new(Details {
            code,
            message: message.into(),
            detail: None,
            progress: None,
            step: None,
            command: None,
            value: None,
            limit: None,
            unit: None,
            from: None,
            to: None,
            alarms: None,
            remedies: Vec::new(),
            breach: None,
            guard: None,
            station: None,
            source: None,
        }))
    }

    /// Creates an error for an invalid value or name.
    #[must_use]
    pub fn invalid(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::InvalidValue, message)
    }

    /// Creates an error for a port, a network or a part of the operating system that failed.
    #[must_use]
    pub fn port(message: impl Into<Message>, source: io::Error) -> Self {
        Self::new(ErrorCode::PortFailed, message).with_source(source)
    }

    /// Names the command.
    #[must_use]
    pub fn with_command(mut self, name: impl Into<String>) -> Self {
        self.0.command = Some(name.into());
        self
    }

    /// Adds the position of the command in its list, from 0.
    #[must_use]
    pub fn at_step(mut self, step: usize) -> Self {
        self.0.step = Some(step);
        self
    }

    /// Adds a remedy with its effect.
    #[must_use]
    pub fn remedy(
        mut self,
        act: impl Into<Act>,
        effect: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Self {
        self.0.remedies.push(Remedy::new(act, effect));
        self
    }

    /// Adds that the station at this address uses the port, and the effect of using the station.
    #[must_use]
    pub fn at_station(
        mut self,
        url: impl Into<String>,
        effect: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Self {
        let url = url.into();
        self.0.station = Some(url.clone());
        self.remedy(Act::UseStation(url.into()), effect)
    }

    /// Adds the value and the limit that it exceeds.
    #[must_use]
    pub fn with_limit(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.0.value = Some(value);
        self.0.limit = Some(limit);
        self.0.unit = Some(unit);
        self
    }

    /// Part of a path that lies before the point where it leaves the reach, percent. `None` for
    /// other errors.
    pub(crate) fn progress(&self) -> Option<f64> {
        self.0.progress
    }

    /// Replaces the message by one about a position; the previous one becomes the detail.
    pub(crate) fn in_place(mut self, message: Message) -> Self {
        self.0.detail = Some(std::mem::replace(&mut self.0.message, message));
        self
    }

    /// Adds that the path leaves the reach after `percent` of it; its end may be in reach.
    pub fn on_the_way(mut self, percent: f64) -> Self {
        let cause = &self.0.message;
        self.0.message = message!("{percent:.0} % of the way there: {cause}", percent, cause);
        self.0.progress = Some(percent);
        self
    }

    /// Adds the error of the operating system that caused it.
    #[must_use]
    pub fn with_source(mut self, source: io::Error) -> Self {
        self.0.source = Some(source);
        self
    }

    /// Creates an error for a refusal by a guard.
    pub fn guarded(guard: &'static str, message: impl Into<Message>) -> Self {
        let mut error = Self::new(ErrorCode::Guarded, message);
        error.0.guard = Some(guard);
        error
    }

    /// Creates an error for a breach of the fence.
    #[must_use]
    pub fn fenced(breach: Breach) -> Self {
        let code = match breach.part {
            // Excess speed or power is an invalid value; leaving the space is an error of reach.
            FencePart::TopSpeed | FencePart::Laser => ErrorCode::FenceLimit,
            _ => ErrorCode::Fenced,
        };
        let error = Self::new(code, motion::of_breach(&breach));
        let mut error = error.with_limit(breach.value, breach.limit, breach.part.unit());
        error.0.breach = Some(breach);
        error
    }

    /// Creates an error for a command that was not sent because the laser would or could burn.
    pub fn burning(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::LaserNotAllowed, message)
            .remedy((Setting::AllowLaser, SettingValue::On), "allows it")
    }

    /// Creates an error for a command that the arm may or may not have accepted.
    pub fn uncertain(from: Option<u64>, to: Option<u64>) -> Self {
        let message = match (from, to) {
            (Some(from), Some(to)) => {
                let which = span(from, to);
                message!(
                    "the reply was lost, and the arm may or may not have the command ({which}); \
                        look at the arm before you repeat it",
                    which
                )
            }
            _ => message!(
                "the reply was lost, and the arm may or may not have the command; look at the arm \
                    before you repeat it"
            ),
        };
        let mut error = Self::new(ErrorCode::Uncertain, message);
        error.0.from = from;
        error.0.to = to;
        error
    }

    /// Adds the hint that the tool bias is 0: the real tool may reach the target. Errors other than
    /// [`ErrorCode::OutOfReach`] are unchanged.
    #[must_use]
    pub(crate) fn of_unknown_tool(mut self) -> Self {
        if self.0.code != ErrorCode::OutOfReach {
            return self;
        }
        let (cause, tool) = (&self.0.message, Message::word(Alarm::TOOL_UNKNOWN));
        self.0.message = message!("{cause}; {tool}", cause, tool);
        self.remedy(
            (Setting::Tool, SettingValue::Any("NAME")),
            "tells the arm its tool",
        )
    }

    /// Copies the error for another waiting caller, without the error of the operating system.
    #[must_use]
    pub fn copy(&self) -> Self {
        Self(Box::new(Details {
            // `io::Error` cannot be cloned.
            source: None,
            message: self.0.message.clone(),
            detail: self.0.detail.clone(),
            command: self.0.command.clone(),
            alarms: self.0.alarms,
            remedies: self.0.remedies.clone(),
            station: self.0.station.clone(),
            ..*self.0
        }))
    }

    /// Copies the error with another sentence and without the command's name, which the sentence
    /// includes if needed.
    #[must_use]
    pub fn reworded(&self, message: impl Into<Message>) -> Self {
        let mut error = self.copy();
        error.0.message = message.into();
        error.0.command = None;
        error
    }

    /// Adds the queue indices concerned, as far as they are known.
    pub fn between(mut self, from: Option<u64>, to: Option<u64>) -> Self {
        (self.0.from, self.0.to) = (from, to);
        self
    }
}

/// Output of a `main` that returns the error: sentence, code and remedies.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(step) = self.0.step {
            write!(f, "command {}: ", step.saturating_add(1))?;
        }
        write!(f, "{self} ({})", self.code())?;
        for Remedy { act, effect } in self.remedies() {
            write!(f, "; {act} {effect}")?;
        }
        Ok(())
    }
}

/// The sentence may quote an arm, a file or a port, so control characters are escaped.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // For a position out of reach the command's name does not help a person.
        let is_of_a_place = matches!(self.0.code, ErrorCode::OutOfReach | ErrorCode::Fenced);
        if let Some(command) = self.0.command.as_ref().filter(|_| !is_of_a_place) {
            write!(f, "{}: ", visible_lines(command))?;
        }
        visible_lines(&self.0.message).fmt(f)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        let source = self.0.source.as_ref()?;
        Some(source)
    }
}

#[cfg(test)]
mod tests;
