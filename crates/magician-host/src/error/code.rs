//! Categories and codes of errors.

use std::fmt;

use crate::remedy::named;

/// Category of an [`Error`](crate::Error). The names are stable; C return codes, Python exceptions
/// and exit statuses are derived from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// Invalid request: a NaN, a wrong name, a queue that belongs to another program.
    InvalidInput,
    /// The arm cannot reach the target.
    Unreachable,
    /// The port does not exist, may not be used, is in use, or was lost.
    Port,
    /// No reply by the deadline.
    Timeout,
    /// The peer's reply is not what it should be.
    Unexpected,
    /// This build or this peer does not support the request.
    Unsupported,
    /// The controller's queue is full, or too many calls wait for the line. Nothing was done; try
    /// again.
    QueueFull,
    /// An alarm that holds the queue is active.
    Alarm,
    /// A command may or may not have been taken.
    Uncertain,
    /// The connection is closed, or a stop came first ([`ErrorCode::Stopped`]).
    Closed,
}

impl ErrorKind {
    /// Name in kebab case, as in JSON.
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

    /// True if a pen is lifted from its paper after a run that failed with this error, once the arm
    /// has been stopped.
    ///
    /// False if the line is lost, if an alarm holds the arm, or if a stop came first. A reset
    /// counts as [`Uncertain`](Self::Uncertain), so the caller must exclude it.
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
    /// Code of an error. Programs decide by it or by its [`kind`](Self::kind), never by the
    /// message. The names are stable.
    ErrorCode {
        /// A value, name or argument is invalid.
        InvalidValue = "invalid-value",
        /// The text does not name a port.
        InvalidPort = "invalid-port",
        /// The settings file cannot be read or is invalid.
        InvalidSettings = "invalid-settings",
        /// A file of a program or plan cannot be executed.
        InvalidProgram = "invalid-program",
        /// The command is of the wrong kind: not a jog, not a point-to-point move, or not
        /// queueable.
        WrongCommand = "wrong-command",
        /// A guard of the check failed: [`Error::guard`](crate::Error::guard).
        Guarded = "guarded",
        /// The motion crosses the fence of the arm: [`Error::breach`](crate::Error::breach).
        Fenced = "fenced",
        /// The speed or laser power exceeds the fence of the arm:
        /// [`Error::breach`](crate::Error::breach).
        FenceLimit = "fence-limit",
        /// The laser would or could burn, which was not allowed.
        LaserNotAllowed = "laser-not-allowed",
        /// The laser is on and would burn along the way.
        LaserOn = "laser-on",
        /// The arm was not homed since power-up.
        NotHomed = "not-homed",
        /// The position of the arm is unknown.
        PositionUnknown = "position-unknown",
        /// Commands of another program wait in the queue.
        ForeignCommands = "foreign-commands",
        /// Another program or a jog is running over this connection.
        Busy = "busy",
        /// A blocking call inside an async runtime.
        InsideRuntime = "inside-runtime",
        /// The target is out of reach: too far, too near, or beyond a joint limit.
        OutOfReach = "out-of-reach",
        /// No arm was found.
        NoArm = "no-arm",
        /// Several arms were found, and none was selected.
        SeveralArms = "several-arms",
        /// The port does not exist.
        NoPort = "no-port",
        /// The user may not use the port.
        PortForbidden = "port-forbidden",
        /// The port is in use by another program.
        PortBusy = "port-busy",
        /// The port, the network or the operating system failed.
        PortFailed = "port-failed",
        /// The device at the port is another arm, or not an arm.
        AnotherArm = "another-arm",
        /// The line to the arm broke.
        LineLost = "line-lost",
        /// No reply came.
        NoAnswer = "no-answer",
        /// A jog was stopped because its caller did not renew it in time.
        NotKept = "not-kept",
        /// The request could not be sent in time.
        NotSent = "not-sent",
        /// The arm did not confirm a stop, or still moves.
        StopUnconfirmed = "stop-unconfirmed",
        /// A command did not finish in time.
        NotFinished = "not-finished",
        /// The queue is stopped, so nothing finishes.
        QueueStopped = "queue-stopped",
        /// The reply cannot be decoded or has unexpected content.
        BadAnswer = "bad-answer",
        /// The arm refused the command.
        Refused = "refused",
        /// The device that replies is not a Magician.
        NotAnArm = "not-an-arm",
        /// The required feature was not built in.
        NotBuiltIn = "not-built-in",
        /// The arm or its line does not support the request.
        Unsupported = "unsupported",
        /// The queue is full.
        QueueFull = "queue-full",
        /// The queue was cleared, and the running command has not finished.
        QueueDraining = "queue-draining",
        /// Too many requests are waiting.
        TooManyRequests = "too-many-requests",
        /// An alarm holds the queue: [`Error::alarms`](crate::Error::alarms).
        Alarm = "alarm",
        /// The queue is held without an active alarm: by an alarm that is gone, or because a
        /// program stopped it.
        Held = "held",
        /// The arm may or may not have taken the command.
        Uncertain = "uncertain",
        /// The arm was reset, and its queue is lost.
        Reset = "reset",
        /// The arm has taken more commands than were sent.
        Unaccounted = "unaccounted",
        /// A stop came first.
        Stopped = "stopped",
        /// The command was dropped from the queue.
        Dropped = "dropped",
        /// The run or the jog is over, or the arm is not where it was supposed to begin.
        RunOver = "run-over",
        /// An earlier command is uncertain, so this one was not sent.
        AfterUncertain = "after-uncertain",
        /// The connection is closed.
        Closed = "closed",
    }
}

impl ErrorCode {
    /// Category of the error.
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
