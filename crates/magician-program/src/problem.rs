use std::fmt;

use magician_protocol::{visible, visible_lines};

use crate::Origin;

/// What is wrong with a file, or deserves to be known of it: where, what, and what to do about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Where.
    pub origin: Origin,
    /// The id of the element or the name of the point, if it has one.
    pub name: Option<String>,
    /// What kind of thing it is.
    pub code: NoteCode,
    /// What.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// What is missing, where nothing is wrong with the file.
    pub lacks: Option<Lack>,
}

/// What kind of thing a [`Problem`] is, for programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NoteCode {
    /// Something is wrong.
    #[default]
    Problem,
    /// Something of the file is not done.
    LeftOut,
    /// What the file does not say, or says in a way that this arm has not, is taken in a certain way.
    Assumed,
    /// Where it lies, and how large it is.
    Placed,
    /// It is drawn in another order.
    Reordered,
    /// How strong the laser is.
    Power,
    /// How fast the arm is.
    Speed,
    /// It takes very long.
    Long,
}

impl NoteCode {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Problem,
        Self::LeftOut,
        Self::Assumed,
        Self::Placed,
        Self::Reordered,
        Self::Power,
        Self::Speed,
        Self::Long,
    ];

    /// Its name in JSON.
    ///
    /// ```
    /// assert_eq!(magician_program::NoteCode::LeftOut.name(), "left-out");
    /// ```
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Problem => "problem",
            Self::LeftOut => "left-out",
            Self::Assumed => "assumed",
            Self::Placed => "placed",
            Self::Reordered => "reordered",
            Self::Power => "power",
            Self::Speed => "speed",
            Self::Long => "long",
        }
    }
}

/// What is not known when a file is read, and solves a [`Problem`] when it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Lack {
    /// Where the arm stands when the program begins: [`GcodeOptions::start`](crate::formats::GcodeOptions::start).
    Start,
    /// A feature of this crate, which this build does not have: a reader
    /// ([`Format::feature`](crate::Format::feature)), or the font (`text`).
    Feature(&'static str),
}

impl Problem {
    /// At a place.
    #[must_use]
    pub fn new(origin: Origin, message: impl Into<String>) -> Self {
        Self {
            origin,
            name: None,
            code: NoteCode::Problem,
            message: message.into(),
            help: None,
            lacks: None,
        }
    }

    /// Of the file as a whole.
    #[must_use]
    pub fn of_file(message: impl Into<String>) -> Self {
        Self::new(Origin::NONE, message)
    }

    /// With the id of its element or the name of its point.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// As a note of this kind.
    #[must_use]
    pub fn coded(mut self, code: NoteCode) -> Self {
        self.code = code;
        self
    }

    /// With what is missing.
    #[must_use]
    pub(crate) fn lacking(mut self, lack: Option<Lack>) -> Self {
        self.lacks = lack;
        self
    }

    /// With what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// `line 3, column 5 (outline): what`. A terminal obeys nothing of what is quoted from the file.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Origin { line, column, .. } = self.origin;
        match (line, column) {
            (0, _) => {}
            (line, 0) => write!(f, "line {line}")?,
            (line, column) => write!(f, "line {line}, column {column}")?,
        }
        if let Some(name) = &self.name {
            let space = if self.origin.is_known() { " " } else { "" };
            write!(f, "{space}({})", visible(name))?;
        }
        if self.origin.is_known() || self.name.is_some() {
            f.write_str(": ")?;
        }
        visible_lines(&self.message).fmt(f)
    }
}

impl std::error::Error for Problem {}

/// As an error of the driver: invalid input.
impl From<Problem> for magician_host::Error {
    fn from(problem: Problem) -> Self {
        Self::new(
            magician_host::ErrorCode::InvalidProgram,
            problem.to_string(),
        )
    }
}
