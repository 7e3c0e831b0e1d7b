//! What goes wrong, as the user sees it: a kind that decides the exit status, and a message.

use std::fmt;
use std::io::{self, Write};

use magician::ErrorKind;
use magician_motion::MotionError;
use serde::Serialize;

use crate::output::Paint;

/// Whose problem it is. The exit status and the name in JSON follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum Kind {
    Bug,
    Usage,
    InvalidInput,
    Unreachable,
    Port,
    Closed,
    Timeout,
    Unexpected,
    Unsupported,
    QueueFull,
    Alarm,
    Uncertain,
    CheckFailed,
    Interrupted,
    /// The reader of our output went away: end quietly.
    BrokenPipe,
}

impl Kind {
    /// The exit status.
    pub(crate) const fn status(self) -> u8 {
        match self {
            Self::BrokenPipe => 0,
            Self::Bug => 1,
            Self::Usage => 2,
            Self::InvalidInput | Self::Unreachable => 3,
            Self::Port | Self::Closed => 4,
            Self::Timeout => 5,
            Self::Unexpected | Self::Unsupported => 6,
            Self::QueueFull => 7,
            Self::Alarm => 8,
            Self::Uncertain => 9,
            Self::CheckFailed => 10,
            Self::Interrupted => 130,
        }
    }

    /// The name in JSON.
    const fn name(self) -> &'static str {
        match self {
            Self::BrokenPipe | Self::Closed => "closed",
            Self::Bug => "bug",
            Self::Usage => "usage",
            Self::InvalidInput => "invalid-input",
            Self::Unreachable => "unreachable",
            Self::Port => "port",
            Self::Timeout => "timeout",
            Self::Unexpected => "unexpected",
            Self::Unsupported => "unsupported",
            Self::QueueFull => "queue-full",
            Self::Alarm => "alarm",
            Self::Uncertain => "uncertain",
            Self::Interrupted => "interrupted",
            Self::CheckFailed => "check-failed",
        }
    }
}

/// Why a verb could not do what it was asked to.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) kind: Kind,
    pub(crate) message: String,
    /// What to do about it; for people only.
    hint: Option<String>,
    figures: Option<Box<Figures>>,
    /// Whether the user has been told already.
    told: bool,
}

/// What a failure is about, in figures. What does not apply is absent.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Figures {
    /// The command of the protocol.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) command: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) value: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) limit: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<&'static str>,
    /// First queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) from: Option<u64>,
    /// Last queue index in doubt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) to: Option<u64>,
}

/// The object that `--json` puts on stderr.
#[derive(Serialize)]
struct Report<'a> {
    error: Body<'a>,
}

#[derive(Serialize)]
struct Body<'a> {
    kind: &'static str,
    message: &'a str,
    #[serde(flatten)]
    figures: Option<&'a Figures>,
}

impl Failure {
    pub(crate) fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            hint: None,
            figures: None,
            told: false,
        }
    }

    /// A failure that the user has been told of already.
    pub(crate) fn told(kind: Kind) -> Self {
        Self {
            told: true,
            ..Self::new(kind, "")
        }
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, message)
    }

    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self::new(Kind::InvalidInput, message)
    }

    pub(crate) fn unexpected(message: impl Into<String>) -> Self {
        Self::new(Kind::Unexpected, message)
    }

    pub(crate) fn interrupted() -> Self {
        Self::new(Kind::Interrupted, "interrupted")
    }

    /// Adds what to do about it.
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds what it is about.
    pub(crate) fn about(mut self, figures: Figures) -> Self {
        self.figures = Some(Box::new(figures));
        self
    }

    /// Tells the user on stderr, as one JSON object if asked to. A stderr that cannot be written
    /// to is no reason to fail again.
    pub(crate) fn report(&self, json: bool) {
        let mut stderr = io::stderr().lock();
        let _ = match (self.kind, json) {
            (Kind::BrokenPipe, _) => Ok(()),
            _ if self.told => Ok(()),
            (_, true) => self.write_json(&mut stderr),
            (_, false) => self.write_text(&mut stderr, Paint::for_stderr()),
        };
    }

    fn write_json(&self, to: &mut impl Write) -> io::Result<()> {
        let report = Report {
            error: Body {
                kind: self.kind.name(),
                message: &self.message,
                figures: self.figures.as_deref(),
            },
        };
        serde_json::to_writer(&mut *to, &report)?;
        writeln!(to)
    }

    fn write_text(&self, to: &mut impl Write, paint: Paint) -> io::Result<()> {
        if self.kind != Kind::Interrupted {
            write!(to, "{} ", paint.error("error:"))?;
        }
        writeln!(to, "{}", self.message)?;
        match &self.hint {
            Some(hint) => writeln!(to, "{} {hint}", paint.dim("hint:")),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Errors of writing our own output.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::new(Kind::BrokenPipe, "nobody reads the output"),
            _ => Self::new(
                Kind::Closed,
                format!("the output cannot be written: {error}"),
            ),
        }
    }
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        if error.is_io() {
            return io::Error::from(error).into();
        }
        Self::new(Kind::Bug, format!("a value has no JSON form: {error}"))
    }
}

impl From<&clap::Error> for Failure {
    fn from(error: &clap::Error) -> Self {
        let text = error.render().to_string();
        let mut paragraphs = text.split("\n\n").map(one_line);
        let message = paragraphs.next().unwrap_or_default();
        let rest: Vec<_> = paragraphs
            .filter(|text| !text.starts_with("For more"))
            .collect();
        let failure = Self::usage(message.trim_start_matches("error: "));
        match rest.join("; ").as_str() {
            "" => failure,
            rest => failure.hint(rest.replace("tip: ", "").replace("Usage: ", "usage: ")),
        }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl From<magician::Error> for Failure {
    fn from(error: magician::Error) -> Self {
        let kind = match error.kind() {
            ErrorKind::InvalidInput => Kind::InvalidInput,
            ErrorKind::Unreachable => Kind::Unreachable,
            ErrorKind::Port => Kind::Port,
            ErrorKind::Timeout => Kind::Timeout,
            ErrorKind::Unexpected => Kind::Unexpected,
            ErrorKind::Unsupported => Kind::Unsupported,
            ErrorKind::QueueFull => Kind::QueueFull,
            ErrorKind::Alarm => Kind::Alarm,
            ErrorKind::Uncertain => Kind::Uncertain,
            ErrorKind::Closed => Kind::Closed,
            _ => Kind::Bug,
        };
        Self::new(kind, error.to_string()).about(Figures {
            command: error.command().map(str::to_owned),
            value: error.value(),
            limit: error.limit(),
            unit: error.unit(),
            from: error.from(),
            to: error.to(),
        })
    }
}

impl From<MotionError> for Failure {
    fn from(error: MotionError) -> Self {
        magician::Error::from(error).into()
    }
}
