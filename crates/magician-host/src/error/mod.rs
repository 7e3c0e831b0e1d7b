//! What goes wrong, as data: a code, where, the values, and what to do about it; and the fact as a sentence, which names no flag
//! and no call.

mod code;
mod motion;

use std::fmt;
use std::io;

use magician_motion::{Breach, FencePart, MotionError, Unreachable};
use magician_protocol::{
    Alarm, AlarmSet, DecodeError, EncodeError, Number, RangeError, visible_lines,
};

pub use self::code::{ErrorCode, ErrorKind};
pub(crate) use self::motion::of_motion;
use crate::remedy::{Act, Action, Given, Remedy, Setting};
use crate::{Message, message};

/// What the driver returns.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something could not be done: a sentence for people, and the parts of it for programs.
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
    /// The same in the terms of the arm, where the message is in those of the caller.
    detail: Option<Message>,
    /// How far a motion would come that leaves the reach on its way, percent.
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
    /// What of the arm's fence it would break.
    breach: Option<Breach>,
    /// The check of a program that has refused it.
    guard: Option<&'static str>,
    /// Address of the station of this machine that has the port.
    station: Option<String>,
    source: Option<io::Error>,
}

/// The parts.
impl Error {
    /// Which error it is.
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

    /// Whose problem it is.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        self.0.code.kind()
    }

    /// The fact, without the command and its place in a list.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// The fact as a sentence that can be said in another language.
    #[must_use]
    pub fn sentence(&self) -> &Message {
        &self.0.message
    }

    /// The same with the text that `Display` prints, which names the command.
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

    /// The fact in the terms of the arm (joints, distances from its shoulder), where the message tells it by a place.
    #[must_use]
    pub fn detail(&self) -> Option<&str> {
        self.0.detail.as_deref()
    }

    /// What to do about it, the best first.
    #[must_use]
    pub fn remedies(&self) -> &[Remedy] {
        &self.0.remedies
    }

    /// The place of the command in the list that it came in, from 0.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        self.0.step
    }

    /// The vendor's name of the command that failed (`GetPose`, `SetPTPCmd`), or its id.
    #[must_use]
    pub fn command(&self) -> Option<&str> {
        self.0.command.as_deref()
    }

    /// The value that was asked for or found, in [`unit`](Self::unit).
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.0.value
    }

    /// The limit it breaks, in [`unit`](Self::unit).
    #[must_use]
    pub fn limit(&self) -> Option<f64> {
        self.0.limit
    }

    /// Unit of value and limit.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        self.0.unit
    }

    /// For [`ErrorKind::Uncertain`]: first queue index in doubt, when it is known.
    #[must_use]
    pub fn from_index(&self) -> Option<u64> {
        self.0.from
    }

    /// For [`ErrorKind::Uncertain`]: last queue index in doubt, when it is known.
    #[must_use]
    pub fn to_index(&self) -> Option<u64> {
        self.0.to
    }

    /// For [`ErrorKind::Alarm`]: the alarms that stand. Empty when only the hold that an alarm left
    /// behind stands.
    #[must_use]
    pub fn alarms(&self) -> Option<&AlarmSet> {
        self.0.alarms.as_ref()
    }

    /// The check of a program that has refused it, by its name in [`Guards`](crate::preflight::Guards), if it is one that can be
    /// switched off.
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

    /// Address of the station of this machine that has the port, with the name of the arm there where it has several: the arm
    /// can be used through it. `None` where no station has it.
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

    /// What of the arm's fence it would break.
    #[must_use]
    pub fn breach(&self) -> Option<&Breach> {
        self.0.breach.as_ref()
    }
}

/// Making one.
impl Error {
    /// An error with this fact as its sentence.
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

    /// A value or a name that makes no sense.
    #[must_use]
    pub fn invalid(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::InvalidValue, message)
    }

    /// A port, a network or a part of the system that does not work.
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

    /// Says which command of a list it is, from 0.
    #[must_use]
    pub fn at_step(mut self, step: usize) -> Self {
        self.0.step = Some(step);
        self
    }

    /// Adds something to do about it, and what that does.
    #[must_use]
    pub fn remedy(
        mut self,
        act: impl Into<Act>,
        effect: impl Into<std::borrow::Cow<'static, str>>,
    ) -> Self {
        self.0.remedies.push(Remedy::new(act, effect));
        self
    }

    /// Adds that the station at this address has the port, and what using that does.
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

    /// Adds the value and the limit it breaks.
    #[must_use]
    pub fn with_limit(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.0.value = Some(value);
        self.0.limit = Some(limit);
        self.0.unit = Some(unit);
        self
    }

    /// How far the motion would come, percent, if it leaves the reach on its way.
    pub(crate) fn progress(&self) -> Option<f64> {
        self.0.progress
    }

    /// Tells it by a place; what was said so far is the detail.
    pub(crate) fn in_place(mut self, message: Message) -> Self {
        self.0.detail = Some(std::mem::replace(&mut self.0.message, message));
        self
    }

    /// The end would be reachable, but not the way there.
    pub fn on_the_way(mut self, percent: f64) -> Self {
        let cause = &self.0.message;
        self.0.message = message!("{percent:.0} % of the way there: {cause}", percent, cause);
        self.0.progress = Some(percent);
        self
    }

    /// With the error of the system that caused it.
    #[must_use]
    pub fn with_source(mut self, source: io::Error) -> Self {
        self.0.source = Some(source);
        self
    }

    /// Refused by the guard of this name.
    pub fn guarded(guard: &'static str, message: impl Into<Message>) -> Self {
        let mut error = Self::new(ErrorCode::Guarded, message);
        error.0.guard = Some(guard);
        error
    }

    /// What a fence does not let pass.
    #[must_use]
    pub fn fenced(breach: Breach) -> Self {
        let code = match breach.part {
            FencePart::TopSpeed | FencePart::Laser => ErrorCode::FenceLimit,
            _ => ErrorCode::Fenced,
        };
        let error = Self::new(code, motion::of_breach(&breach));
        let mut error = error.with_limit(breach.value, breach.limit, breach.part.unit());
        error.0.breach = Some(breach);
        error
    }

    /// What was not sent because the laser would or could burn.
    pub fn burning(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::LaserNotAllowed, message)
            .remedy((Setting::AllowLaser, Given::On), "allows it")
    }

    /// A command that may or may not have been taken.
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

    /// The same error, of an arm whose tool bias is 0: what is out of reach may be within reach of its tool. Other errors stay as
    /// they are.
    #[must_use]
    pub(crate) fn of_unknown_tool(mut self) -> Self {
        if self.0.code != ErrorCode::OutOfReach {
            return self;
        }
        let (cause, tool) = (&self.0.message, Message::word(Alarm::TOOL_UNKNOWN));
        self.0.message = message!("{cause}; {tool}", cause, tool);
        self.remedy(
            (Setting::Tool, Given::Any("NAME")),
            "tells the arm its tool",
        )
    }

    /// A copy for another waiting caller, without the system's error.
    #[must_use]
    pub fn copy(&self) -> Self {
        Self(Box::new(Details {
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

    /// The same error with another sentence, which says the command itself if it is to be said.
    #[must_use]
    pub fn retold(&self, message: impl Into<Message>) -> Self {
        let mut told = self.copy();
        told.0.message = message.into();
        told.0.command = None;
        told
    }

    /// The queue indices that it is about, as far as they are known.
    pub fn between(mut self, from: Option<u64>, to: Option<u64>) -> Self {
        (self.0.from, self.0.to) = (from, to);
        self
    }

    /// Alarms that hold the queue; `tool_unknown` is whether they may come from a tool that the arm was never told of.
    pub fn alarm(alarms: AlarmSet, tool_unknown: bool) -> Self {
        let mut message = message!("the arm stopped with an alarm");
        for code in alarms.codes().filter(|code| Alarm::blocks(*code)) {
            let (before, number) = (&message, format!("{code:#04x}"));
            message = match Alarm::with_code(code) {
                Some(Alarm {
                    name,
                    cause,
                    remedy,
                    ..
                }) => {
                    let (cause, remedy) = (Message::word(cause), Message::word(remedy));
                    message!(
                        "{before}; {number} {name}: {cause} ({remedy})",
                        before,
                        number,
                        name,
                        cause,
                        remedy
                    )
                }
                None => message!(
                    "{before}; {number}: unknown to this program",
                    before,
                    number
                ),
            };
        }
        if tool_unknown {
            let (cause, tool) = (&message, Message::word(Alarm::TOOL_UNKNOWN));
            message = message!("{cause}; {tool}", cause, tool);
        }
        let mut error =
            Self::new(ErrorCode::Alarm, message).remedy(Action::ClearAlarms, "releases the queue");
        error.0.alarms = Some(alarms);
        error
    }

    /// The queue stands although no alarm does.
    pub fn held() -> Self {
        let message =
            message!("the arm is at rest with commands in its queue, and has no alarm now");
        let mut error = Self::new(ErrorCode::Held, message)
            .remedy(
                Action::ClearAlarms,
                "continues if the queue is still held by an alarm that is gone, the usual cause",
            )
            .remedy(
                Action::StartQueue,
                "continues if another program has stopped the queue",
            );
        error.0.alarms = Some(AlarmSet::new());
        error
    }

    /// The arm forgot its queue.
    pub fn reset(gone: Option<(u64, u64)>) -> Self {
        let (message, from, to) = match gone {
            Some((from, u64::MAX)) => {
                let message = message!(
                    "the arm was switched off and on, or reset: its queue is lost (from queue \
                        index {from} on), and its progress is unknown",
                    from
                );
                (message, Some(from), None)
            }
            Some((from, to)) => {
                let which = span(from, to);
                let message = message!(
                    "the arm was switched off and on, or reset: its queue is lost ({which}), and \
                        its progress is unknown",
                    which
                );
                (message, Some(from), Some(to))
            }
            None => {
                let message = message!(
                    "the arm was switched off and on, or reset: its queue is lost, and its \
                        progress is unknown"
                );
                (message, None, None)
            }
        };
        let mut error =
            Self::new(ErrorCode::Reset, message).remedy(Action::Home, "is needed before going on");
        (error.0.from, error.0.to) = (from, to);
        error
    }

    /// More was queued than this program sent.
    pub fn unaccounted(from: u64, to: u64) -> Self {
        let message = message!(
            "the arm has taken more commands than this program sent (up to queue index {to}): the \
                network duplicated one, or another program uses the arm; look at the arm before \
            you go on",
            to
        );
        let mut error = Self::new(ErrorCode::Unaccounted, message);
        (error.0.from, error.0.to) = (Some(from), Some(to));
        error
    }

    /// The connection has ended.
    #[must_use]
    pub fn closed() -> Self {
        Self::new(ErrorCode::Closed, message!("the connection is closed"))
    }

    /// The task that owns the line takes no wishes.
    pub fn stuck() -> Self {
        Self::new(ErrorCode::NotSent, message!("the connection is stuck"))
    }

    /// The line failed while in use, or the program at its other end refused what was asked for
    /// (`PermissionDenied`) or is gone (`ConnectionAborted`, with words of its own).
    pub fn gone(name: &str, source: io::Error) -> Self {
        let message = match source.kind() {
            io::ErrorKind::PermissionDenied => {
                message!("refused: {cause}", cause = source.to_string())
            }
            // The program at the other end, or what stands for it, says in its own words why the
            // line is over: there is no cable to look at. The system's errors of this kind have no
            // words of their own.
            io::ErrorKind::ConnectionAborted if source.get_ref().is_some() => {
                source.to_string().into()
            }
            _ => message!(
                "the connection to {name} broke off: {cause}; look at the cable and at the arm's power, \
                 then connect again",
                name,
                cause = source.to_string()
            ),
        };
        Self::new(ErrorCode::LineLost, message).with_source(source)
    }
}

/// An interval of queue indices.
fn span(from: u64, to: u64) -> Message {
    if from == to {
        message!("queue index {from}", from)
    } else {
        message!("queue indices {from} to {to}", from, to)
    }
}

/// What a `main` that returns the error prints: the sentence, the code, and what to do about it.
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

/// A sentence may quote an arm, a file or a port; a terminal obeys nothing of that.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Where the arm cannot go is a fact about a place: which command would lead there says nothing to a person.
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

impl From<EncodeError> for Error {
    fn from(error: EncodeError) -> Self {
        Self::invalid(error.to_string())
    }
}

impl From<RangeError> for Error {
    fn from(error: RangeError) -> Self {
        let refused = Self::invalid(error.to_string());
        let Some(limit) = error.limit() else {
            return refused;
        };
        // The number as it was given: a program that reads it back finds 0.001, not its nearest `f32`.
        let value = match error.value {
            Number::Float(number) => number.to_string().parse().unwrap_or(f64::from(number)),
            Number::Integer(_) => error.value.to_f64(),
        };
        refused.with_limit(value, limit.into(), error.unit)
    }
}

impl From<DecodeError> for Error {
    fn from(error: DecodeError) -> Self {
        Self::new(
            ErrorCode::BadAnswer,
            message!("invalid reply: {cause}", cause = error.to_string()),
        )
    }
}

impl From<MotionError> for Error {
    fn from(error: MotionError) -> Self {
        let message = motion::of_motion(&error);
        match error {
            MotionError::Limit { value, limit, .. } => {
                Self::new(ErrorCode::OutOfReach, message).with_limit(value, limit, "deg")
            }
            MotionError::Unreachable(
                Unreachable::TooFar { distance, limit } | Unreachable::TooNear { distance, limit },
            ) => Self::new(ErrorCode::OutOfReach, message).with_limit(distance, limit, "mm"),
            MotionError::Unreachable(_) => Self::invalid(message),
            _ => Self::invalid(message),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::ToolBias;
    use crate::build;
    use crate::preflight::Preflight;

    #[test]
    fn an_alarm_names_cause_and_cure_and_what_clears_it() {
        let error = Error::alarm([0x00, 0x12].into_iter().collect(), false);
        let message = error.to_string();
        assert!(message.contains("0x12 PlanInvLimit"), "{message}");
        assert!(
            !message.contains("0x00"),
            "0x00 does not hold the queue: {message}"
        );
        assert_eq!(
            error.remedies(),
            [Remedy::new(Action::ClearAlarms, "releases the queue")]
        );
        assert!(error.alarms().is_some_and(|alarms| alarms.contains(0x12)));
    }

    #[test]
    fn a_terminal_obeys_nothing_that_a_message_quotes() {
        let error = Error::invalid("no arm `\x1b[2J\u{202e}`").with_command("Get\x07");
        let message = r"Get\u{7}: no arm `\u{1b}[2J\u{202e}`";
        assert_eq!(error.to_string(), message);
        assert_eq!(format!("{error:?}"), format!("{message} (invalid-value)"));
    }

    #[test]
    fn a_limit_has_both_values() {
        let limits = magician_motion::ArmModel::MAGICIAN.limits;
        let joints = magician_motion::JointAngles::new(0.0, 91.3, 45.0, 0.0);
        let error = Error::from(limits.check(&joints).unwrap_err());
        assert_eq!(error.kind(), ErrorKind::Unreachable);
        assert_eq!((error.value(), error.limit()), (Some(91.3), Some(90.0)));
        assert_eq!(error.unit(), Some("deg"));
        assert!(error.to_string().contains("91.3") && error.to_string().contains("90.0"));
    }

    #[test]
    fn the_sentence_stands_apart_from_the_command_and_its_place() {
        let error = Error::invalid("x is NaN")
            .with_command("SetPTPCmd")
            .at_step(2);
        assert_eq!(error.message(), "x is NaN");
        assert_eq!(error.to_string(), "SetPTPCmd: x is NaN");
        let whole = "command 3: SetPTPCmd: x is NaN (invalid-value)";
        assert_eq!(format!("{error:?}"), whole);
        let start = Preflight::at(magician_motion::JointAngles::HOME, ToolBias::NONE);
        let program = [
            build::line_by(0.0, 1.0, 0.0, 0.0),
            build::line_to(f32::NAN, 0.0, 0.0, 0.0),
        ];
        let error = start.clone().program(&program).unwrap_err();
        assert_eq!(
            (error.step(), error.command()),
            (Some(1), Some("SetPTPCmd"))
        );
    }

    #[test]
    fn codes_have_names_of_their_own() {
        let names: BTreeSet<_> = ErrorCode::ALL.iter().map(|code| code.name()).collect();
        assert_eq!(names.len(), ErrorCode::ALL.len());
        for name in names {
            let plain = |letter: char| letter.is_ascii_lowercase() || letter == '-';
            assert!(name.chars().all(plain), "{name}");
        }
    }
}
