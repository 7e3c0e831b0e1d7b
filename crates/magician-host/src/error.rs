use std::fmt;
use std::io;

use magician_motion::{Breach, FencePart, MotionError, Unreachable};
use magician_protocol::{Alarm, AlarmSet, DecodeError, EncodeError, visible_lines};

/// What the driver returns.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Whose problem an [`Error`] is. The names are stable; C return codes, Python exceptions and exit
/// statuses are made from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The request makes no sense: a NaN, a wrong name, a queue that belongs to another program.
    InvalidInput,
    /// The arm cannot get there.
    Unreachable,
    /// The port is not there, not allowed, in use, or gone.
    Port,
    /// No answer by the deadline.
    Timeout,
    /// The peer answered what it should not.
    Unexpected,
    /// This build or this peer cannot do it.
    Unsupported,
    /// The controller's queue has no room, or too many calls wait for the line: nothing was done, try again.
    QueueFull,
    /// An alarm stands that holds the queue.
    Alarm,
    /// A command may or may not have been taken.
    Uncertain,
    /// The connection has been closed, or a stop came first.
    Closed,
}

impl ErrorKind {
    /// The name in kebab case, as in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InvalidInput => "invalid-input",
            Self::Unreachable => "unreachable",
            Self::Port => "port",
            Self::Timeout => "timeout",
            Self::Unexpected => "unexpected",
            Self::Unsupported => "unsupported",
            Self::QueueFull => "queue-full",
            Self::Alarm => "alarm",
            Self::Uncertain => "uncertain",
            Self::Closed => "closed",
        }
    }

    /// Whether a pen is lifted from its paper after a run that failed so, once the arm has been stopped: not when the line is
    /// gone, when an alarm holds the arm, and when somebody else has stopped it or it was reset.
    #[must_use]
    pub const fn lifts(self) -> bool {
        !matches!(self, Self::Port | Self::Alarm | Self::Closed)
    }
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why something could not be done: a sentence for people, and the parts of it for programs.
///
/// ```
/// use magician_host::{ErrorKind, words};
///
/// let error = words::tool_named("hammer").unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::InvalidInput);
/// assert!(error.to_string().contains("suction"));
/// ```
pub struct Error(Box<Details>);

struct Details {
    kind: ErrorKind,
    message: String,
    command: Option<String>,
    value: Option<f64>,
    limit: Option<f64>,
    unit: Option<&'static str>,
    from: Option<u64>,
    to: Option<u64>,
    alarms: Option<AlarmSet>,
    /// It is refused because the laser was not allowed to burn.
    wants_laser: bool,
    /// What of the arm's fence it would break.
    breach: Option<Breach>,
    /// The check of a program that has refused it.
    guard: Option<&'static str>,
    source: Option<io::Error>,
}

/// The parts.
impl Error {
    /// Whose problem it is.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
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

    /// The check of a program that has refused it, by its name in [`Guards`](crate::words::Guards), if it is one that can be
    /// switched off.
    ///
    /// ```
    /// use magician_host::words::{self, Preflight};
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let mut start = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let error = start.program(&[words::laser(true)]).unwrap_err();
    /// assert_eq!(error.guard(), Some("laser"));
    /// ```
    #[must_use]
    pub fn guard(&self) -> Option<&'static str> {
        self.0.guard
    }

    /// What of the arm's fence it would break.
    #[must_use]
    pub fn breach(&self) -> Option<&Breach> {
        self.0.breach.as_ref()
    }

    /// Whether it was refused because the laser would or could burn, and nobody had allowed that
    /// (`Options::allow_laser`).
    #[must_use]
    pub fn wants_laser(&self) -> bool {
        self.0.wants_laser
    }
}

/// Making one.
impl Error {
    /// An error of this kind with this sentence.
    #[must_use]
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self(Box::new(Details {
            kind,
            message: message.into(),
            command: None,
            value: None,
            limit: None,
            unit: None,
            from: None,
            to: None,
            alarms: None,
            wants_laser: false,
            breach: None,
            guard: None,
            source: None,
        }))
    }

    /// A request that makes no sense.
    #[must_use]
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::InvalidInput, message)
    }

    /// Names the command, in the message too.
    #[must_use]
    pub fn with_command(mut self, name: impl Into<String>) -> Self {
        let name = name.into();
        self.0.message = format!("{name}: {}", self.0.message);
        self.0.command = Some(name);
        self
    }

    /// Adds the value and the limit it breaks.
    #[must_use]
    pub fn with_limit(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.0.value = Some(value);
        self.0.limit = Some(limit);
        self.0.unit = Some(unit);
        self
    }

    /// Adds a value that breaks a rule without a number.
    #[must_use]
    pub fn with_value(mut self, value: f64, unit: &'static str) -> Self {
        self.0.value = Some(value);
        self.0.unit = Some(unit);
        self
    }

    /// The end would be reachable, but not the way there.
    pub fn on_the_way(mut self, percent: f64) -> Self {
        self.0.message = format!("{:.0} % of the way there: {}", percent, self.0.message);
        self
    }

    /// With the error of the system that caused it.
    #[must_use]
    pub fn with_source(mut self, source: io::Error) -> Self {
        self.0.source = Some(source);
        self
    }

    /// Refused by the guard of this name.
    pub fn guarded(guard: &'static str, message: String) -> Self {
        let mut error = Self::invalid(message);
        error.0.guard = Some(guard);
        error
    }

    /// What a fence does not let pass.
    #[must_use]
    pub fn fenced(breach: Breach) -> Self {
        let kind = match breach.part {
            FencePart::TopSpeed | FencePart::Laser => ErrorKind::InvalidInput,
            _ => ErrorKind::Unreachable,
        };
        let error = Self::new(kind, breach.to_string());
        let mut error = error.with_limit(breach.value, breach.limit, breach.part.unit());
        error.0.breach = Some(breach);
        error
    }

    /// What was not sent because the laser would or could burn.
    pub fn burning(message: impl Into<String>) -> Self {
        let mut error = Self::invalid(message);
        error.0.wants_laser = true;
        error
    }

    /// A command that may or may not have been taken.
    pub fn uncertain(from: Option<u64>, to: Option<u64>) -> Self {
        let which = match (from, to) {
            (Some(from), Some(to)) => span(from, to),
            _ => String::new(),
        };
        let message = format!(
            "the answer was lost, and it cannot be told whether the arm took the command{which}; \
             look at the arm before you repeat it"
        );
        let mut error = Self::new(ErrorKind::Uncertain, message);
        error.0.from = from;
        error.0.to = to;
        error
    }

    /// The queue indices that it is about, as far as they are known.
    pub fn between(mut self, from: Option<u64>, to: Option<u64>) -> Self {
        (self.0.from, self.0.to) = (from, to);
        self
    }

    /// Alarms that hold the queue; `tool_unknown` is whether they may come from a tool that the arm was never told of.
    pub fn alarm(alarms: AlarmSet, tool_unknown: bool) -> Self {
        let mut message = String::from("the arm stopped with an alarm");
        for code in alarms.codes().filter(|code| Alarm::blocks(*code)) {
            match Alarm::with_code(code) {
                Some(alarm) => {
                    message += &format!(
                        "; {code:#04x} {}: {} ({})",
                        alarm.name, alarm.cause, alarm.cure
                    )
                }
                None => message += &format!("; {code:#04x}: unknown to this program"),
            }
        }
        if tool_unknown {
            message += "; ";
            message += Alarm::TOOL_UNKNOWN;
        }
        message += "; `magician alarms --clear` lets the queue go on";
        let mut error = Self::new(ErrorKind::Alarm, message);
        error.0.alarms = Some(alarms);
        error
    }

    /// The queue stands although no alarm does.
    pub fn held() -> Self {
        let message = "the arm stands still with commands in its queue, and no alarm stands now. Most \
                       often an alarm that has gone by itself still holds it: `magician alarms \
                       --clear` lets it go on. If another program has stopped the queue, `magician \
                       queue start` does";
        let mut error = Self::new(ErrorKind::Alarm, message);
        error.0.alarms = Some(AlarmSet::new());
        error
    }

    /// The arm forgot its queue.
    pub fn reset(gone: Option<(u64, u64)>) -> Self {
        let (which, from, to) = match gone {
            Some((from, u64::MAX)) => (format!(" (from queue index {from} on)"), Some(from), None),
            Some((from, to)) => (span(from, to), Some(from), Some(to)),
            None => (String::new(), None, None),
        };
        let message = format!(
            "the arm was switched off and on, or reset: what was in its queue is gone{which}, and it cannot be told how \
             far it came; home the arm before you go on"
        );
        let mut error = Self::new(ErrorKind::Uncertain, message);
        (error.0.from, error.0.to) = (from, to);
        error
    }

    /// More was queued than this program sent.
    pub fn unaccounted(from: u64, to: u64) -> Self {
        let message = format!(
            "the arm has taken more commands than this program sent (up to queue index {to}): the network \
             doubled one, or another program uses the arm; look at the arm before you go on"
        );
        let mut error = Self::new(ErrorKind::Uncertain, message);
        (error.0.from, error.0.to) = (Some(from), Some(to));
        error
    }

    /// The connection has ended.
    #[must_use]
    pub fn closed() -> Self {
        Self::new(ErrorKind::Closed, "the connection is closed")
    }

    /// The task that owns the line takes no wishes.
    pub fn stuck() -> Self {
        Self::new(ErrorKind::Timeout, "the connection is stuck")
    }

    /// The line failed while in use.
    pub fn gone(name: &str, source: io::Error) -> Self {
        let message = format!(
            "the connection to {name} broke off: {source}; look at the cable and at the arm's power, \
             then connect again"
        );
        Self::new(ErrorKind::Port, message).with_source(source)
    }
}

/// An interval of queue indices, in brackets behind what they belong to.
fn span(from: u64, to: u64) -> String {
    match from == to {
        true => format!(" (queue index {from})"),
        false => format!(" (queue indices {from} to {to})"),
    }
}

/// What a `main` that returns the error prints: the sentence, not the parts.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self} ({})", self.kind())
    }
}

/// A sentence may quote an arm, a file or a port; a terminal obeys nothing of that.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

impl From<DecodeError> for Error {
    fn from(error: DecodeError) -> Self {
        Self::new(
            ErrorKind::Unexpected,
            format!("an answer that cannot be read: {error}"),
        )
    }
}

impl From<MotionError> for Error {
    fn from(error: MotionError) -> Self {
        let message = error.to_string();
        match error {
            MotionError::Limit { value, limit, .. } => {
                Self::new(ErrorKind::Unreachable, message).with_limit(value, limit, "deg")
            }
            MotionError::Unreachable(
                Unreachable::TooFar { distance, limit } | Unreachable::TooNear { distance, limit },
            ) => Self::new(ErrorKind::Unreachable, message).with_limit(distance, limit, "mm"),
            MotionError::Unreachable(_) => Self::invalid(message),
            _ => Self::invalid(message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_names_cause_cure_and_the_command_that_clears() {
        let error = Error::alarm([0x00, 0x12].into_iter().collect(), false);
        let message = error.to_string();
        assert!(message.contains("0x12 PlanInvLimit"), "{message}");
        assert!(
            !message.contains("0x00"),
            "0x00 does not hold the queue: {message}"
        );
        assert!(message.contains("magician alarms --clear"));
        assert!(error.alarms().is_some_and(|alarms| alarms.contains(0x12)));
    }

    #[test]
    fn a_terminal_obeys_nothing_that_a_message_quotes() {
        let error = Error::invalid("no arm `\x1b[2J\u{202e}`").with_command("Get\x07");
        let message = r"Get\u{7}: no arm `\u{1b}[2J\u{202e}`";
        assert_eq!(error.to_string(), message);
        assert_eq!(format!("{error:?}"), format!("{message} (invalid-input)"));
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
}
