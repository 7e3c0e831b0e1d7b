//! Errors of the API as data: a code, a sentence, and what they are about.

use magician::report::{ErrorFigures, SentenceReport};
use magician::{ErrorKind, Message};
use serde_json::{Map, Value, json};

use super::Role;

/// An error as JSON-RPC carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct RpcError {
    /// Its number.
    pub code: i32,
    /// What is wrong, in a sentence.
    pub message: String,
    /// What it is about. It always has `kind` where the code is one of this API's own.
    pub data: Map<String, Value>,
}

impl RpcError {
    /// The text is no JSON.
    pub const PARSE: i32 = -32700;
    /// It is no request.
    pub const REQUEST: i32 = -32600;
    /// There is no such method.
    pub const METHOD: i32 = -32601;
    /// A parameter is wrong; `data.param` names it.
    pub const PARAMS: i32 = -32602;
    /// A mistake of the station.
    pub const INTERNAL: i32 = -32603;
    /// The arm or its line; `data.kind` is a name of [`ErrorKind`].
    pub const ARM: i32 = -32000;
    /// The session's role does not allow it.
    pub const FORBIDDEN: i32 = -32001;
    /// It needs the lease of the arm.
    pub const LEASE: i32 = -32002;
    /// A job or a jog has the arm.
    pub const BUSY: i32 = -32003;
    /// The check refuses a program.
    pub const CHECK_FAILED: i32 = -32004;
    /// It is dangerous, and `yes` was not given.
    pub const DANGEROUS: i32 = -32005;
    /// More than the station takes.
    pub const TOO_MANY: i32 = -32006;
    /// A stop came first.
    pub const STOPPED: i32 = -32007;
    /// A teacher has frozen the arm.
    pub const FROZEN: i32 = -32008;
    /// All of them.
    pub const CODES: [i32; 14] = [
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
        Self::DANGEROUS,
        Self::FROZEN,
        Self::TOO_MANY,
        Self::STOPPED,
    ];

    /// One of these numbers. A sentence that was made with [`message!`](magician::message) is in the data too.
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
        if message.template().is_some() {
            error.said(&message)
        } else {
            error
        }
    }

    /// Adds what it is about.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.data.insert(name.to_owned(), value.into());
        self
    }

    /// Adds the sentence as data: what a page says in its own words and language.
    #[must_use]
    pub fn said(mut self, sentence: &Message) -> Self {
        if let Ok(Value::Object(parts)) = serde_json::to_value(SentenceReport::of(sentence)) {
            self.data.extend(parts);
        }
        self
    }

    /// What needs `yes`, as it is called, and by which command.
    pub(crate) fn dangerous(what: &str, command: &str, danger: Danger) -> Self {
        let message = format!("{what} {}: it needs \"yes\": true", danger.what());
        let error = Self::new(Self::DANGEROUS, message);
        error.with("command", command).with("danger", danger.name())
    }

    /// No request.
    #[must_use]
    pub fn request(message: impl Into<Message>) -> Self {
        Self::new(Self::REQUEST, message)
    }

    /// A parameter is wrong.
    #[must_use]
    pub fn param(name: &str, message: impl Into<Message>) -> Self {
        Self::new(Self::PARAMS, message).with("param", name)
    }

    /// The arm has no such thing, or does not do it.
    #[must_use]
    pub fn arm(kind: ErrorKind, message: impl Into<Message>) -> Self {
        Self::new(Self::ARM, message).with("kind", kind.name())
    }

    /// A role that is too low for something.
    #[must_use]
    pub fn forbidden(role: Role, needs: Role, what: &str) -> Self {
        let (role, needs) = (role.name(), needs.name());
        let message = format!("{what} needs the role {needs}, this session is {role}");
        Self::new(Self::FORBIDDEN, message)
            .with("role", role)
            .with("needs", needs)
    }

    /// A mistake of the station.
    pub(crate) fn internal(message: impl Into<Message>) -> Self {
        Self::new(Self::INTERNAL, message)
    }

    /// The error of an answer, as an answer has it; `None` for what is none.
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
            Some(_) => return None,
        };
        Some(Self {
            code,
            message,
            data,
        })
    }

    /// The result of a journal's line: `ok`, or the error's kind.
    pub(crate) fn outcome(&self) -> &str {
        match self.data.get("kind") {
            Some(Value::String(kind)) => kind,
            _ => "request",
        }
    }

    /// The object of an answer.
    #[must_use]
    pub fn to_value(&self) -> Value {
        let mut error = json!({"code": self.code, "message": self.message});
        if !self.data.is_empty() {
            error["data"] = Value::Object(self.data.clone());
        }
        error
    }
}

/// What `yes` is needed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Danger {
    /// The laser may burn.
    Laser,
    /// The command is dangerous: what it does, as [`Row::danger`](magician_protocol::Row::danger) says it.
    Arm(&'static str),
}

impl Danger {
    /// A command of a job. None that can be queued does anything else.
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

/// The name of an own code.
const fn kind(code: i32) -> Option<&'static str> {
    Some(match code {
        RpcError::FORBIDDEN => "forbidden",
        RpcError::LEASE => "lease",
        RpcError::BUSY => "busy",
        RpcError::CHECK_FAILED => "check-failed",
        RpcError::DANGEROUS => "dangerous",
        RpcError::FROZEN => "frozen",
        RpcError::TOO_MANY => "too-many",
        RpcError::STOPPED => "stopped",
        _ => return None,
    })
}

impl From<&magician::Error> for RpcError {
    /// With the figures that `--json` has, and what to do about it.
    fn from(error: &magician::Error) -> Self {
        let mut out = Self::arm(error.kind(), error.to_string());
        if let Ok(Value::Object(figures)) = serde_json::to_value(ErrorFigures::of(error)) {
            out.data.extend(figures);
        }
        out.said(error.sentence())
    }
}

impl From<magician::Error> for RpcError {
    fn from(error: magician::Error) -> Self {
        Self::from(&error)
    }
}
