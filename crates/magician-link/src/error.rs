//! Errors as DobotLink numbers them.

use serde_json::{Value, json};

/// A number of DobotLink's table (document of its API, section 5). Its -32600 and -32601 are the reverse of the standard's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ErrorCode(pub i32);

impl ErrorCode {
    /// There is no such target: `dobotlink.TARGET`.
    pub const NO_TARGET: Self = Self(1);
    /// The method does not begin with `dobotlink.`.
    pub const NO_METHOD: Self = Self(2);
    /// Something else has the arm, or too much waits.
    pub const BUSY: Self = Self(17);
    /// No arm has this port.
    pub const NOT_FOUND: Self = Self(100);
    /// Another program has the arm.
    pub const OCCUPIED: Self = Self(101);
    /// The arm was not connected by this program, or does not answer.
    pub const NOT_CONNECTED: Self = Self(103);
    /// The line broke.
    pub const LINE_LOST: Self = Self(140);
    /// The driver of the arm has ended.
    pub const CLOSED: Self = Self(141);
    /// The arm did not answer.
    pub const NO_ANSWER: Self = Self(150);
    /// The arm's queue stayed full.
    pub const QUEUE_FULL: Self = Self(151);
    /// What was waited for did not end in time.
    pub const TIMEOUT: Self = Self(160);
    /// What was waited for will not end: a stop, a clear, an alarm, a disconnect, or a lost lease.
    pub const CANCELLED: Self = Self(161);
    /// The target has no such call.
    pub const NO_API: Self = Self(-32600);
    /// A parameter is missing or wrong.
    pub const PARAMS: Self = Self(-32602);
    /// `portName` is missing or wrong.
    pub const PORT_NAME: Self = Self(-32603);
    /// The arm cannot do it, or must not.
    pub const COMMAND: Self = Self(-32604);
    /// What is never done here: firmware and restart.
    pub const NEVER: Self = Self(-32605);
    /// A mistake of this program.
    pub const INTERNAL: Self = Self(-32606);
}

/// An error as DobotLink answers it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkError {
    /// Its number.
    pub code: ErrorCode,
    /// What is wrong, in a sentence.
    pub message: String,
}

impl LinkError {
    pub(crate) fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
        }
    }

    pub(crate) fn params(message: impl Into<String>) -> Self {
        Self::new(ErrorCode::PARAMS, message)
    }

    pub(crate) fn command(message: impl Into<String>) -> Self {
        Self::new(ErrorCode::COMMAND, message)
    }

    pub(crate) fn cancelled(why: impl Into<String>) -> Self {
        Self::new(ErrorCode::CANCELLED, why)
    }

    /// The object of an answer.
    pub(crate) fn to_value(&self) -> Value {
        json!({"code": self.code.0, "message": self.message})
    }

    /// What an error of the station's API is here. Its own sentence is kept: it names both values.
    pub(crate) fn of_station(error: &Value) -> Self {
        let number = error.get("code").and_then(Value::as_i64).unwrap_or(0);
        let kind = { error.get("data") }
            .and_then(|data| data.get("kind"))
            .and_then(Value::as_str);
        let message = error.get("message").and_then(Value::as_str);
        let code = match (number, kind.unwrap_or_default()) {
            (-32002, _) => ErrorCode::OCCUPIED,
            (-32003 | -32006, _) => ErrorCode::BUSY,
            (-32007, _) => ErrorCode::CANCELLED,
            (-32602, _) => ErrorCode::PARAMS,
            (-32600 | -32601 | -32603 | -32700, _) => ErrorCode::INTERNAL,
            (_, "port") => ErrorCode::LINE_LOST,
            (_, "closed") => ErrorCode::CLOSED,
            // Whether it was taken is not known: it is not sent again.
            (_, "timeout" | "uncertain") => ErrorCode::NO_ANSWER,
            (_, "queue-full") => ErrorCode::QUEUE_FULL,
            _ => ErrorCode::COMMAND,
        };
        if number == -32005 {
            let what = { error.get("data") }
                .and_then(|data| data.get("command"))
                .and_then(Value::as_str);
            let what = what.unwrap_or("the command");
            let why = format!("{what} may switch the laser on: start with --link-laser");
            return Self::command(why);
        }
        Self::new(code, message.unwrap_or("the station refuses it"))
    }
}
