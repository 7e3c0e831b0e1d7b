//! Errors of known causes: alarms, the connection, values out of range, motions out of reach.

use std::io;

use magician_motion::{MotionError, Unreachable};
use magician_protocol::{
    Alarm, AlarmSet, DecodeError, EncodeError, MAX_PARAMS, Number, RangeError,
};

use super::{Error, ErrorCode, motion, range};
use crate::remedy::Action;
use crate::{Message, message};

impl Error {
    /// Creates an error for alarms that hold the queue. `tool_unknown` is true if they may be
    /// caused by a tool that was never set.
    pub fn alarm(alarms: AlarmSet, tool_unknown: bool) -> Self {
        let mut message = message!("the arm stopped with an alarm");
        // Alarms below 0x08 do not hold the queue, so they are not the reason.
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

    /// Creates an error for a queue that is held without an active alarm.
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
        // Empty, but present: callers distinguish it from errors without alarms.
        error.0.alarms = Some(AlarmSet::new());
        error
    }

    /// Creates an error for a reset of the arm. `gone` are the first and last lost index.
    pub fn reset(gone: Option<(u64, u64)>) -> Self {
        let (message, from, to) = match gone {
            // u64::MAX: a command without a known index was lost as well.
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

    /// Creates an error for a controller that has taken more queued commands than this program
    /// sent. `from` and `to` are the first and last surplus index.
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

    /// Creates an error for a closed connection.
    #[must_use]
    pub fn closed() -> Self {
        Self::new(ErrorCode::Closed, message!("the connection is closed"))
    }

    /// Creates an error for a driver task that accepts no messages.
    pub fn stuck() -> Self {
        Self::new(ErrorCode::NotSent, message!("the connection is stuck"))
    }

    /// Creates an error for a line that failed while in use, or whose peer refused a request
    /// (`PermissionDenied`) or ended (`ConnectionAborted`, with its own text).
    pub fn gone(name: &str, source: io::Error) -> Self {
        let message = match source.kind() {
            io::ErrorKind::PermissionDenied => {
                message!("refused: {cause}", cause = source.to_string())
            }
            // The program at the other end states why it ended the connection, so the advice on the
            // cable would mislead. The system's own errors of this kind have no text.
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

/// Interval of queue indices in words.
pub(super) fn span(from: u64, to: u64) -> Message {
    if from == to {
        message!("queue index {from}", from)
    } else {
        message!("queue indices {from} to {to}", from, to)
    }
}

impl From<EncodeError> for Error {
    fn from(error: EncodeError) -> Self {
        let message = match error {
            EncodeError::TooLong { needed } => message!(
                "{needed} parameter bytes, a frame carries {most}",
                needed,
                most = MAX_PARAMS
            ),
            // No other error exists yet.
            _ => error.to_string().into(),
        };
        debug_assert_eq!(message, error.to_string());
        Self::invalid(message)
    }
}

impl From<RangeError> for Error {
    fn from(error: RangeError) -> Self {
        let refused = Self::invalid(range::of_range(&error));
        // NaN and infinities violate no particular bound.
        let Some(limit) = error.limit() else {
            return refused;
        };
        // The number as given: a program that reads it back gets 0.001 rather than its nearest
        // `f32`.
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
            // Not finite: a wrong value rather than a place out of reach.
            MotionError::Unreachable(_) => Self::invalid(message),
            _ => Self::invalid(message),
        }
    }
}
