//! Whose problem an error is, and which one.

use std::fmt;

use crate::remedy::named;

/// Whose problem an [`Error`](crate::Error) is. The names are stable; C return codes, Python exceptions and exit
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
    /// The connection has been closed, or a stop came first ([`ErrorCode::Stopped`]).
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
    /// gone, when an alarm holds the arm, and when another program has stopped it or it was reset.
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

named! {
    /// Which error it is. Programs decide by it, or by its [`kind`](Self::kind), never by the message. The names are
    /// stable.
    ErrorCode {
        /// A value, a name or an argument makes no sense.
        InvalidValue = "invalid-value",
        /// The text names no port.
        InvalidPort = "invalid-port",
        /// The file of settings cannot be read, or says what makes no sense.
        InvalidSettings = "invalid-settings",
        /// A file of a program or a plan cannot be carried out.
        InvalidProgram = "invalid-program",
        /// The command is not of the kind that is wanted: no jog, no point-to-point move, none that can be queued.
        WrongCommand = "wrong-command",
        /// A guard of the check failed: [`Error::guard`](crate::Error::guard).
        Guarded = "guarded",
        /// It breaks the fence of the arm: [`Error::breach`](crate::Error::breach).
        Fenced = "fenced",
        /// It is stronger or faster than the fence of the arm allows: [`Error::breach`](crate::Error::breach).
        FenceLimit = "fence-limit",
        /// The laser would or could burn, and that was not allowed.
        LaserNotAllowed = "laser-not-allowed",
        /// The laser is on, and the arm would burn along its way.
        LaserOn = "laser-on",
        /// The arm was not homed since it was switched on.
        NotHomed = "not-homed",
        /// It is not known where the arm stands.
        PositionUnknown = "position-unknown",
        /// Commands of another program wait in the queue.
        ForeignCommands = "foreign-commands",
        /// Another program or a jog is under way over this connection.
        Busy = "busy",
        /// A blocking call inside an async runtime.
        InsideRuntime = "inside-runtime",
        /// The arm cannot get there: too far, too near, or beyond a limit of a joint.
        OutOfReach = "out-of-reach",
        /// No arm was found.
        NoArm = "no-arm",
        /// Several arms were found, and nothing says which one.
        SeveralArms = "several-arms",
        /// The port is not there.
        NoPort = "no-port",
        /// This user may not use the port.
        PortForbidden = "port-forbidden",
        /// Another program has the port.
        PortBusy = "port-busy",
        /// The port, the network or the system does not work.
        PortFailed = "port-failed",
        /// There is another arm, or none, where the arm was.
        AnotherArm = "another-arm",
        /// The line to the arm broke.
        LineLost = "line-lost",
        /// No answer came.
        NoAnswer = "no-answer",
        /// A jog was not kept up.
        NotKept = "not-kept",
        /// It could not be sent in time.
        NotSent = "not-sent",
        /// The arm did not confirm a stop, or still moves.
        StopUnconfirmed = "stop-unconfirmed",
        /// A command did not finish in time.
        NotFinished = "not-finished",
        /// The queue does not run, so that nothing finishes.
        QueueStopped = "queue-stopped",
        /// The answer cannot be read, or is not what it should be.
        BadAnswer = "bad-answer",
        /// The arm refuses it.
        Refused = "refused",
        /// What answers is no Magician.
        NotAnArm = "not-an-arm",
        /// It was built without the feature that this needs.
        NotBuiltIn = "not-built-in",
        /// This arm or its line cannot do it.
        Unsupported = "unsupported",
        /// The queue has no room.
        QueueFull = "queue-full",
        /// The queue was cleared, and its command under way has not finished.
        QueueDraining = "queue-draining",
        /// Too many requests wait at once.
        TooManyRequests = "too-many-requests",
        /// An alarm holds the queue: [`Error::alarms`](crate::Error::alarms).
        Alarm = "alarm",
        /// The queue is at rest without an active alarm: an alarm that is gone still holds it, or a program has stopped it.
        Held = "held",
        /// It cannot be told whether the arm took the command.
        Uncertain = "uncertain",
        /// The arm was reset, and its queue is gone.
        Reset = "reset",
        /// The arm has taken more commands than were sent.
        Unaccounted = "unaccounted",
        /// A stop came first.
        Stopped = "stopped",
        /// The command was dropped from the queue.
        Dropped = "dropped",
        /// The run or the jog is over, or the arm is not where it was to begin.
        RunOver = "run-over",
        /// An earlier command is uncertain, so this one was not sent.
        AfterUncertain = "after-uncertain",
        /// The connection is closed.
        Closed = "closed",
    }
}

impl ErrorCode {
    /// Whose problem it is.
    #[must_use]
    pub const fn kind(self) -> ErrorKind {
        match self {
            Self::InvalidValue
            | Self::InvalidPort
            | Self::InvalidSettings
            | Self::InvalidProgram
            | Self::WrongCommand
            | Self::Guarded
            | Self::FenceLimit
            | Self::LaserNotAllowed
            | Self::LaserOn
            | Self::NotHomed
            | Self::PositionUnknown
            | Self::ForeignCommands
            | Self::Busy
            | Self::InsideRuntime => ErrorKind::InvalidInput,
            Self::OutOfReach | Self::Fenced => ErrorKind::Unreachable,
            Self::NoArm
            | Self::SeveralArms
            | Self::NoPort
            | Self::PortForbidden
            | Self::PortBusy
            | Self::PortFailed
            | Self::AnotherArm
            | Self::LineLost => ErrorKind::Port,
            Self::NoAnswer
            | Self::NotKept
            | Self::NotSent
            | Self::StopUnconfirmed
            | Self::NotFinished
            | Self::QueueStopped => ErrorKind::Timeout,
            Self::BadAnswer | Self::Refused | Self::NotAnArm => ErrorKind::Unexpected,
            Self::NotBuiltIn | Self::Unsupported => ErrorKind::Unsupported,
            Self::QueueFull | Self::QueueDraining | Self::TooManyRequests => ErrorKind::QueueFull,
            Self::Alarm | Self::Held => ErrorKind::Alarm,
            Self::Uncertain | Self::Reset | Self::Unaccounted => ErrorKind::Uncertain,
            Self::Stopped | Self::Dropped | Self::RunOver | Self::AfterUncertain | Self::Closed => {
                ErrorKind::Closed
            }
        }
    }
}
