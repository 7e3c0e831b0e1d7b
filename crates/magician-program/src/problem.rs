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
    /// What.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// What is missing, where nothing is wrong with the file.
    pub lacks: Option<Lack>,
}

/// What is not known when a file is read, and solves a [`Problem`] when it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Lack {
    /// Where the arm stands when the program begins: [`GcodeOptions::start`](crate::formats::GcodeOptions::start).
    Start,
}

impl Problem {
    /// At a place.
    #[must_use]
    pub fn new(origin: Origin, message: impl Into<String>) -> Self {
        Self {
            origin,
            name: None,
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
impl From<Problem> for magician::Error {
    fn from(problem: Problem) -> Self {
        Self::invalid(problem.to_string())
    }
}
