//! Errors with the numbers of DobotLink.

use serde_json::{Value, json};

/// Error number from DobotLink's table (document of its API, section 5). Compared with JSON-RPC
/// 2.0, the meanings of -32600 and -32601 are swapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ErrorCode(pub i32);

impl ErrorCode {
    /// The target in `dobotlink.TARGET` does not exist.
    pub const NO_TARGET: Self = Self(1);
    /// The method does not start with `dobotlink.`.
    pub const NO_METHOD: Self = Self(2);
    /// A job or a jog occupies the arm, or too many calls wait.
    pub const BUSY: Self = Self(17);
    /// No arm has this port.
    pub const NOT_FOUND: Self = Self(100);
    /// Another session holds the arm.
    pub const OCCUPIED: Self = Self(101);
    /// The program has not connected the arm, or the arm does not answer.
    pub const NOT_CONNECTED: Self = Self(103);
    /// The line to the arm broke.
    pub const LINE_LOST: Self = Self(140);
    /// The driver of the arm has ended.
    pub const CLOSED: Self = Self(141);
    /// The arm did not answer.
    pub const NO_ANSWER: Self = Self(150);
    /// The arm's queue stayed full.
    pub const QUEUE_FULL: Self = Self(151);
    /// The command did not finish in time.
    pub const TIMEOUT: Self = Self(160);
    /// The command will not finish: a stop, a clear, an alarm, a disconnect, or a lost lease.
    pub const CANCELLED: Self = Self(161);
    /// The target has no such call.
    pub const NO_API: Self = Self(-32600);
    /// A parameter is missing or wrong.
    pub const PARAMS: Self = Self(-32602);
    /// `portName` is missing or wrong.
    pub const PORT_NAME: Self = Self(-32603);
    /// The arm cannot carry out the command, or must not.
    pub const COMMAND: Self = Self(-32604);
    /// Never carried out: changing the firmware, and restarting.
    pub const NEVER: Self = Self(-32605);
    /// Bug of this program.
    pub const INTERNAL: Self = Self(-32606);
}

/// Error as answered to a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkError {
    /// Number.
    pub code: ErrorCode,
    /// Explanation of the error, a sentence.
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

    /// Returns the error object of an answer.
    pub(crate) fn to_value(&self) -> Value {
        json!({"code": self.code.0, "message": self.message})
    }

    /// Converts an error of the station. Keeps its message, which names the values.
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
            // The arm may have taken the command, so it is not sent again.
            (_, "timeout" | "uncertain") => ErrorCode::NO_ANSWER,
            (_, "queue-full") => ErrorCode::QUEUE_FULL,
            // Everything else: the arm cannot or must not do it.
            _ => ErrorCode::COMMAND,
        };
        // The station's message asks for the parameter `yes`, which these programs cannot send.
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
