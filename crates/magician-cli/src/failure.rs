//! Failures as the user sees them: a kind, which decides the exit status, and a message.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use magician::report::ErrorFigures;
use magician::{ErrorCode, ErrorKind, Voice};
use magician_job::recording::RecordError;
use magician_job::report::Note;
use magician_motion::MotionError;
use magician_program::Diagnostic;
use serde::Serialize;

use crate::json::write_json;
use crate::paint::Paint;
use crate::voice::Command;

/// Safety advice that precedes every question about the laser.
pub(crate) const GOGGLES_ADVICE: &str =
    "wear goggles for its wavelength, remove anything that must not burn, and never leave it";

/// Kind of failure. Decides the exit status and the name in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Failure that the driver classifies.
    Driver(ErrorKind),
    Bug,
    Usage,
    CheckFailed,
    Interrupted,
    /// The reader of our output has gone away: end quietly, with status 0.
    BrokenPipe,
}

impl Kind {
    /// Returns the exit status.
    pub(crate) const fn status(self) -> u8 {
        match self {
            Self::BrokenPipe => 0,
            Self::Bug => 1,
            Self::Usage => 2,
            Self::Driver(kind) => match kind {
                ErrorKind::InvalidInput | ErrorKind::Unreachable => 3,
                ErrorKind::Port | ErrorKind::Closed => 4,
                ErrorKind::Timeout => 5,
                ErrorKind::Unexpected | ErrorKind::Unsupported => 6,
                ErrorKind::QueueFull => 7,
                ErrorKind::Alarm => 8,
                ErrorKind::Uncertain => 9,
                _ => 1,
            },
            Self::CheckFailed => 10,
            Self::Interrupted => 130,
        }
    }

    /// Returns the name in JSON.
    const fn name(self) -> &'static str {
        match self {
            Self::Driver(kind) => kind.name(),
            Self::BrokenPipe => "closed",
            Self::Bug => "bug",
            Self::Usage => "usage",
            Self::CheckFailed => "check-failed",
            Self::Interrupted => "interrupted",
        }
    }
}

/// Reason why a verb failed.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) kind: Kind,
    pub(crate) message: String,
    /// Hint for people that the remedies in `figures` do not give.
    hint: Option<String>,
    figures: Option<Box<ErrorFigures>>,
    /// The message with its place in a file, drawn for people.
    drawn: Option<Box<str>>,
    /// Notes on the file. People have read them by then, so only JSON repeats them.
    notes: Vec<Note>,
    /// True if the user has seen the message already.
    is_reported: bool,
}

/// Object that `--json` writes to stderr.
#[derive(Serialize)]
struct Report<'a> {
    error: Body<'a>,
}

#[derive(Serialize)]
struct Body<'a> {
    kind: &'static str,
    message: &'a str,
    #[serde(flatten)]
    figures: Option<&'a ErrorFigures>,
    #[serde(skip_serializing_if = "<[Note]>::is_empty")]
    notes: &'a [Note],
}

impl Failure {
    pub(crate) fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            hint: None,
            figures: None,
            drawn: None,
            notes: Vec::new(),
            is_reported: false,
        }
    }

    /// Creates a failure whose message the user has already seen.
    pub(crate) fn already_reported(kind: Kind) -> Self {
        Self {
            is_reported: true,
            ..Self::new(kind, "")
        }
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, message)
    }

    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self::new(Kind::Driver(ErrorKind::InvalidInput), message)
    }

    pub(crate) fn unexpected(message: impl Into<String>) -> Self {
        Self::new(Kind::Driver(ErrorKind::Unexpected), message)
    }

    /// Creates the failure of work that could burn without permission.
    pub(crate) fn burn_not_allowed(message: impl Into<String>) -> Self {
        Self::usage(message).hint(format!("{GOGGLES_ADVICE}; --yes allows it"))
    }

    /// Creates the failure of a file that could not be written.
    pub(crate) fn unwritable(path: &Path, error: &impl fmt::Display) -> Self {
        Self::invalid(format!("{} cannot be written: {error}", path.display()))
    }

    pub(crate) fn interrupted() -> Self {
        Self::new(Kind::Interrupted, "interrupted")
    }

    /// Adds a hint.
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Returns the bare fact, without the name of the command, for places where the command is
    /// clear.
    pub(crate) fn fact(&self) -> &str {
        let fact = self
            .figures
            .as_ref()
            .and_then(|figures| figures.fact.as_deref());
        fact.unwrap_or(&self.message)
    }

    /// Adds the driver's figures: remedies, indices, alarms.
    pub(crate) fn about(mut self, figures: ErrorFigures) -> Self {
        self.figures = Some(Box::new(figures));
        self
    }

    /// Adds the notes on the file, since they may contain the reason.
    pub(crate) fn with_notes<'n>(
        mut self,
        notes: impl IntoIterator<Item = &'n Diagnostic>,
    ) -> Self {
        self.notes = Note::all(&Command, notes);
        self
    }

    /// Replaces the message by this drawing for people.
    pub(crate) fn drawn(mut self, picture: impl Into<Box<str>>) -> Self {
        self.drawn = Some(picture.into());
        self
    }

    /// Prints the failure on stderr, as one JSON object if `json`. An unwritable stderr is ignored:
    /// there is nowhere left to report it.
    pub(crate) fn report(&self, json: bool) {
        let mut stderr = io::stderr().lock();
        let _ = match (self.kind, json) {
            (Kind::BrokenPipe, _) => Ok(()),
            _ if self.is_reported => Ok(()),
            (_, true) => self.write_json(&mut stderr),
            (_, false) => self.write_text(&mut stderr, Paint::for_stderr()),
        };
    }

    pub(crate) fn write_json(&self, to: &mut impl Write) -> io::Result<()> {
        let report = Report {
            error: Body {
                kind: self.kind.name(),
                message: &self.message,
                figures: self.figures.as_deref(),
                notes: &self.notes,
            },
        };
        write_json(&mut *to, &report)?;
        writeln!(to)
    }

    pub(crate) fn write_text(&self, to: &mut impl Write, paint: Paint) -> io::Result<()> {
        let message = paint.harmless(&self.message);
        match &self.drawn {
            Some(picture) => writeln!(to, "{}", picture.trim_end())?,
            None if self.kind == Kind::Interrupted => writeln!(to, "{message}")?,
            None => writeln!(to, "{} {message}", paint.error("error:"))?,
        }
        // A drawing contains the remedies already.
        let figures = self.figures.as_ref().filter(|_| self.drawn.is_none());
        let remedies = figures.map(|figures| &figures.remedies);
        let remedies = remedies.and_then(|remedies| Command.remedies(remedies));
        for hint in remedies.iter().chain(&self.hint) {
            writeln!(to, "{} {}", paint.dim("hint:"), paint.harmless(hint))?;
        }
        Ok(())
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
            io::ErrorKind::BrokenPipe => Self::new(Kind::BrokenPipe, "the output was closed"),
            _ => Self::new(
                Kind::Driver(ErrorKind::Closed),
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
        Self::new(
            Kind::Bug,
            format!("a value cannot be written as JSON: {error}"),
        )
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        let message = error.to_string();
        match error {
            RecordError::Format(_) => Self::usage(message).hint(
                "use .mcap, .csv or .jsonl for readings, .plan.json or .playback for a program \
                    that repeats the motion",
            ),
            RecordError::Unwritable { .. } => Self::invalid(message),
            RecordError::Write(error) => error.into(),
            RecordError::Program(problem) => magician::Error::from(problem).into(),
            RecordError::Arm(error) => error.into(),
            RecordError::Lost { readings, .. } => Self::new(Kind::Driver(ErrorKind::Port), message)
                .hint(format!("the {readings} readings before that are saved")),
            RecordError::TaskFailed(_) => Self::new(Kind::Bug, message),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        }
    }
}

/// Creates the failure of an incomplete recording of work that itself succeeded.
pub(crate) fn incomplete(what: &str, why: &str) -> Failure {
    Failure::new(
        Kind::Driver(ErrorKind::Port),
        format!("the {what} is incomplete: {why}"),
    )
}

impl From<magician::Error> for Failure {
    fn from(error: magician::Error) -> Self {
        Self::from(&error)
    }
}

impl From<&magician::Error> for Failure {
    fn from(error: &magician::Error) -> Self {
        if error.code() == ErrorCode::LaserNotAllowed {
            return Self::burn_not_allowed(error.to_string());
        }
        if let Some(detail) = error.detail() {
            tracing::info!("{detail}");
        }
        let failure = Self::new(Kind::Driver(error.kind()), error.to_string());
        failure.about(ErrorFigures::of(error))
    }
}

impl From<MotionError> for Failure {
    fn from(error: MotionError) -> Self {
        magician::Error::from(error).into()
    }
}
