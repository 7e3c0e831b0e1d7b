//! Errors of the API: a code, a sentence, and structured details.

use magician::report::{ErrorFigures, SentenceReport};
use magician::{ErrorKind, Message, message};
use magician_protocol::visible;
use serde_json::{Map, Value, json};

use super::Role;

/// Error of JSON-RPC.
#[derive(Clone, Debug, PartialEq)]
pub struct RpcError {
    /// Code.
    pub code: i32,
    /// Explanation of the error, a sentence.
    pub message: String,
    /// Details. Contains `kind` for all codes of this API's own.
    pub data: Map<String, Value>,
}

impl RpcError {
    /// The text is not JSON.
    pub const PARSE: i32 = -32700;
    /// The message is not a valid request.
    pub const REQUEST: i32 = -32600;
    /// The method does not exist.
    pub const METHOD: i32 = -32601;
    /// A parameter is invalid; `data.param` names it.
    pub const PARAMS: i32 = -32602;
    /// Bug of the station.
    pub const INTERNAL: i32 = -32603;
    /// Error of the arm or its line; `data.kind` is a name of [`ErrorKind`].
    pub const ARM: i32 = -32000;
    /// The session's role does not suffice.
    pub const FORBIDDEN: i32 = -32001;
    /// The session does not hold the lease of the arm.
    pub const LEASE: i32 = -32002;
    /// A job or a jog occupies the arm.
    pub const BUSY: i32 = -32003;
    /// The check refuses the program.
    pub const CHECK_FAILED: i32 = -32004;
    /// The command is dangerous and `yes` is missing.
    pub const DANGEROUS: i32 = -32005;
    /// A limit of the station is exceeded.
    pub const TOO_MANY: i32 = -32006;
    /// A stop ended the request, or the station is ending.
    pub const STOPPED: i32 = -32007;
    /// A teacher has frozen the arm.
    pub const FROZEN: i32 = -32008;
    /// The program is another one than was checked.
    pub const CHANGED: i32 = -32009;
    /// All codes.
    pub const CODES: [i32; 15] = [
        Self::PARSE,
        Self::REQUEST,
        Self::METHOD,
        Self::PARAMS,
        Self::INTERNAL,
        Self::ARM,
        Self::FORBIDDEN,
        Self::LEASE,
        Self::BUSY,
        Self::CHECK_FAILED,
        Self::CHANGED,
        Self::DANGEROUS,
        Self::FROZEN,
        Self::TOO_MANY,
        Self::STOPPED,
    ];

    /// Creates an error. If the sentence was made with [`message!`](magician::message), its
    /// template and values are added to the data.
    #[must_use]
    pub fn new(code: i32, message: impl Into<Message>) -> Self {
        let message = message.into();
        let mut data = Map::new();
        if let Some(kind) = kind(code) {
            data.insert("kind".to_owned(), json!(kind));
        }
        let error = Self {
            code,
            message: message.as_str().to_owned(),
            data,
        };
        // Only sentences with a template can be translated.
        if message.template().is_some() {
            error.with_sentence(&message)
        } else {
            error
        }
    }

    /// Adds a detail.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.data.insert(name.to_owned(), value.into());
        self
    }

    /// Adds template and values of the sentence, from which a page makes the sentence in its own
    /// language.
    #[must_use]
    pub fn with_sentence(mut self, sentence: &Message) -> Self {
        if let Ok(Value::Object(parts)) = serde_json::to_value(SentenceReport::of(sentence)) {
            self.data.extend(parts);
        }
        self
    }

    /// Error for something that needs `yes`: what it is called, and the command or method that does
    /// it.
    pub(crate) fn dangerous(what: &'static str, command: &str, danger: Danger) -> Self {
        let message = message!(
            "{what} {danger}: it needs \"yes\": true",
            what = Message::word(what),
            danger = Message::word(danger.what())
        );
        let error = Self::new(Self::DANGEROUS, message);
        error.with("command", command).with("danger", danger.name())
    }

    /// Error for an invalid request.
    #[must_use]
    pub fn request(message: impl Into<Message>) -> Self {
        Self::new(Self::REQUEST, message)
    }

    /// Error for an invalid parameter.
    #[must_use]
    pub fn param(name: &str, message: impl Into<Message>) -> Self {
        Self::new(Self::PARAMS, message).with("param", name)
    }

    /// Error for an invalid parameter whose sentence quotes a file or a name: control characters
    /// are escaped in the message.
    pub(crate) fn param_quoting(name: &str, sentence: &Message) -> Self {
        Self::param(name, visible(sentence).to_string()).with_sentence(sentence)
    }

    /// Error of the arm, by kind.
    #[must_use]
    pub fn arm(kind: ErrorKind, message: impl Into<Message>) -> Self {
        Self::new(Self::ARM, message).with("kind", kind.name())
    }

    /// Error for a role that does not suffice for `what`.
    #[must_use]
    pub fn forbidden(role: Role, needs: Role, what: impl Into<Message>) -> Self {
        let (role, needs) = (role.name(), needs.name());
        let message = message!(
            "{what} needs the role {needs}, this session is {role}",
            what = what.into(),
            needs = Message::word(needs),
            role = Message::word(role)
        );
        Self::new(Self::FORBIDDEN, message)
            .with("role", role)
            .with("needs", needs)
    }

    /// Error for a bug of the station.
    pub(crate) fn internal(message: impl Into<Message>) -> Self {
        Self::new(Self::INTERNAL, message)
    }

    /// Parses the error object of an answer. `None` if the value is not one.
    #[must_use]
    pub fn from_value(value: Value) -> Option<Self> {
        let Value::Object(mut error) = value else {
            return None;
        };
        let code = error
            .get("code")?
            .as_i64()
            .and_then(|code| i32::try_from(code).ok())?;
        let message = error.get("message")?.as_str()?.to_owned();
        let data = match error.remove("data") {
            None => Map::new(),
            Some(Value::Object(data)) => data,
            // `data` of a foreign server may have any form; ours is an object.
            Some(_) => return None,
        };
        Some(Self {
            code,
            message,
            data,
        })
    }

    /// Returns the result for the journal: the error's kind.
    pub(crate) fn outcome(&self) -> &str {
        match self.data.get("kind") {
            Some(Value::String(kind)) => kind,
            // An error of JSON-RPC itself.
            _ => "request",
        }
    }

    /// Returns the error object of an answer.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let mut error = json!({"code": self.code, "message": self.message});
        if !self.data.is_empty() {
            error["data"] = Value::Object(self.data.clone());
        }
        error
    }
}

/// Reason why `yes` is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Danger {
    /// The laser may burn.
    Laser,
    /// The command is dangerous: its effect, in the words of
    /// [`Row::danger`](magician_protocol::Row::danger).
    Arm(&'static str),
}

impl Danger {
    /// Dangerous command in a job. Every dangerous command that can be queued has one of these
    /// effects.
    pub(crate) const JOB: Self = Self::Arm("can brick, uncalibrate or unlock the arm");

    const fn name(self) -> &'static str {
        match self {
            Self::Laser => "laser",
            Self::Arm(_) => "arm",
        }
    }

    const fn what(self) -> &'static str {
        match self {
            Self::Laser => "may switch the laser on",
            Self::Arm(danger) => danger,
        }
    }
}

/// Returns the kind for a code of this API's own. `None` for the codes of JSON-RPC, and for
/// [`RpcError::ARM`], whose kind varies.
const fn kind(code: i32) -> Option<&'static str> {
    Some(match code {
        RpcError::FORBIDDEN => "forbidden",
        RpcError::LEASE => "lease",
        RpcError::BUSY => "busy",
        RpcError::CHECK_FAILED => "check-failed",
        RpcError::DANGEROUS => "dangerous",
        RpcError::FROZEN => "frozen",
        RpcError::CHANGED => "changed",
        RpcError::TOO_MANY => "too-many",
        RpcError::STOPPED => "stopped",
        // The codes of JSON-RPC have no kind of ours.
        _ => return None,
    })
}

impl From<&magician::Error> for RpcError {
    /// Adds the figures of `--json`, and the remedies.
    fn from(error: &magician::Error) -> Self {
        let mut out = Self::arm(error.kind(), error.to_string());
        if let Ok(Value::Object(figures)) = serde_json::to_value(ErrorFigures::of(error)) {
            out.data.extend(figures);
        }
        out.with_sentence(error.sentence())
    }
}

impl From<magician::Error> for RpcError {
    fn from(error: magician::Error) -> Self {
        Self::from(&error)
    }
}
