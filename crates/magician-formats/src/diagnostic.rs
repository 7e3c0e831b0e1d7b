//! Errors in files and notes about them, with their place and what to do about them.

use std::borrow::Cow;
use std::fmt;

use magician_host::{Act, Action, Message, Remedy, Setting, SettingValue, Voice, message};
use magician_protocol::{visible, visible_lines};

use crate::Origin;

/// An error in a file, or a note about it: its place, its message and advice.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Place in the file.
    pub origin: Origin,
    /// Id of the element or name of the point, if it has one.
    pub name: Option<String>,
    /// Kind, for programs.
    pub code: DiagnosticCode,
    /// Message, one sentence.
    pub message: Message,
    /// Advice that concerns neither the arm nor an option, such as "save it as UTF-8".
    pub help: Option<Message>,
    /// Remedies, which each front end words for its users: [`advice`](Self::advice).
    pub remedies: Vec<Remedy>,
    /// Prerequisite that this build or call lacks, if the file itself is fine.
    pub missing: Option<Missing>,
}

/// Kind of a [`Diagnostic`], for programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum DiagnosticCode {
    /// An error, or a fault that deserves attention.
    #[default]
    Problem,
    /// Part of the file is not done.
    LeftOut,
    /// The file leaves something open, or asks for something that this arm lacks; a default is
    /// used.
    Assumed,
    /// Position and size of the drawing.
    Placed,
    /// The lines are drawn in another order.
    Reordered,
    /// Laser power.
    Power,
    /// Speed.
    Speed,
    /// The run takes very long.
    Long,
    /// An output of the arm stays switched on.
    LeftOn,
    /// The tool gripped and took nothing.
    NothingPicked,
    /// The path leads where not every arm can go.
    Doubtful,
}

impl DiagnosticCode {
    /// All codes.
    pub const ALL: [Self; 11] = [
        Self::Problem,
        Self::LeftOut,
        Self::Assumed,
        Self::Placed,
        Self::Reordered,
        Self::Power,
        Self::Speed,
        Self::Long,
        Self::LeftOn,
        Self::NothingPicked,
        Self::Doubtful,
    ];

    /// Name in JSON.
    ///
    /// ```
    /// assert_eq!(magician_formats::DiagnosticCode::LeftOut.name(), "left-out");
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
            Self::LeftOn => "left-on",
            Self::NothingPicked => "nothing-picked",
            Self::Doubtful => "doubtful",
        }
    }
}

/// Prerequisite for reading a file. Once it is supplied, the [`Diagnostic`] does not occur.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Missing {
    /// Position of the arm at the start of the program:
    /// [`GcodeOptions::start`](crate::formats::GcodeOptions::start).
    Start,
    /// A cargo feature absent from this build: a reader of this crate
    /// ([`Format::feature`](crate::Format::feature)), fonts from files (`font-files`), or pictures.
    Feature(&'static str),
}

impl Diagnostic {
    /// Creates a problem at a place in the file.
    #[must_use]
    pub fn new(origin: Origin, message: impl Into<Message>) -> Self {
        Self {
            origin,
            name: None,
            code: DiagnosticCode::Problem,
            message: message.into(),
            help: None,
            remedies: Vec::new(),
            missing: None,
        }
    }

    /// Creates a problem of the file as a whole.
    #[must_use]
    pub fn of_file(message: impl Into<Message>) -> Self {
        Self::new(Origin::NONE, message)
    }

    /// Sets the id of the element or the name of the point.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// Sets the kind.
    #[must_use]
    pub fn coded(mut self, code: DiagnosticCode) -> Self {
        self.code = code;
        self
    }

    /// Sets the missing prerequisite.
    #[must_use]
    pub fn with_missing(mut self, lack: Option<Missing>) -> Self {
        self.missing = lack;
        self
    }

    /// Sets advice that concerns neither the arm nor an option, such as "save it as UTF-8".
    #[must_use]
    pub fn help(mut self, help: impl Into<Message>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds a remedy.
    ///
    /// ```
    /// use magician_host::{SettingValue, Setting};
    /// use magician_formats::Diagnostic;
    ///
    /// let diagnostic = Diagnostic::of_file("the drawing is 400 by 300 mm")
    ///     .remedy((Setting::Scale, SettingValue::Number(0.5)), "fits there");
    /// assert_eq!(diagnostic.remedies[0].act.to_string(), "scale 0.5");
    /// ```
    #[must_use]
    pub fn remedy(self, act: impl Into<Act>, effect: impl Into<Cow<'static, str>>) -> Self {
        self.with(Remedy::new(act, effect))
    }

    /// Adds a remedy that was made elsewhere.
    #[must_use]
    pub fn with(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }

    /// Creates the diagnostic for an unknown height of the work surface.
    #[must_use]
    pub fn unknown_surface() -> Self {
        Self::of_file(message!("work surface height unknown"))
            .remedy(Action::CalibrateSurface, "measures it")
            .remedy(Action::TouchOff, "takes it from where the tool touches")
            .remedy(
                (Setting::Surface, SettingValue::Any("Z")),
                "sets it: the z of the pose when the tool touches it",
            )
    }

    /// True if the height of the work surface is missing. Measuring it requires a homed arm.
    #[must_use]
    pub fn lacks_surface(&self) -> bool {
        let measures = Act::Do(Action::CalibrateSurface);
        self.remedies.iter().any(|remedy| remedy.act == measures)
    }

    /// Returns the advice and all remedies in the words of a front end; `None` if there are
    /// neither.
    #[must_use]
    pub fn advice(&self, voice: &impl Voice) -> Option<String> {
        let parts = self.help.iter().map(|help| help.as_str().to_owned());
        let parts: Vec<String> = parts.chain(voice.remedies(&self.remedies)).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// Prints `line 3, column 5 (outline): message`. Control characters quoted from the file are
/// escaped, so that a terminal does not obey them.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Origin { line, column, .. } = self.origin;
        match (line, column) {
            (0, _) => {}
            (line, 0) => write!(f, "line {line}")?,
            (line, column) => write!(f, "line {line}, column {column}")?,
        }
        // SVG elements without an id arrive with an empty name.
        let name = self.name.as_ref().filter(|name| !name.is_empty());
        if let Some(name) = name {
            let space = if self.origin.is_known() { " " } else { "" };
            write!(f, "{space}({})", visible(name))?;
        }
        if self.origin.is_known() || name.is_some() {
            f.write_str(": ")?;
        }
        visible_lines(&self.message).fmt(f)
    }
}

impl std::error::Error for Diagnostic {}

impl Diagnostic {
    /// Returns the message with the place before it, as `Display` prints it, still translatable.
    #[must_use]
    pub fn sentence(&self) -> Message {
        let Origin { line, column, .. } = self.origin;
        let what = &self.message;
        let name = self.name.as_deref().filter(|name| !name.is_empty());
        let name = name.map(|name| visible(name).to_string());
        let placed = match (line, column, name) {
            (0, _, None) => return what.clone(),
            (0, _, Some(name)) => message!("({name}): {what}", name, what),
            (line, 0, None) => message!("line {line}: {what}", line, what),
            (line, 0, Some(name)) => message!("line {line} ({name}): {what}", line, name, what),
            (line, column, None) => {
                message!("line {line}, column {column}: {what}", line, column, what)
            }
            (line, column, Some(name)) => message!(
                "line {line}, column {column} ({name}): {what}",
                line,
                column,
                name,
                what
            ),
        };
        debug_assert_eq!(visible_lines(&placed).to_string(), self.to_string());
        placed
    }
}

/// Becomes an error of the driver with the code of an invalid program.
impl From<Diagnostic> for magician_host::Error {
    fn from(diagnostic: Diagnostic) -> Self {
        let error = Self::new(
            magician_host::ErrorCode::InvalidProgram,
            diagnostic.sentence(),
        );
        let remedies = diagnostic.remedies.into_iter();
        remedies.fold(error, |error, remedy| {
            error.remedy(remedy.act, remedy.effect)
        })
    }
}
