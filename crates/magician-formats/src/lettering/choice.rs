//! Which font text is written with.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use crate::words::words;

/// The single-line fonts that are built in: those of A. V. Hershey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BundledFont {
    /// One stroke for each line of a letter, without ornament.
    #[default]
    Sans,
    /// A hand that joins its letters.
    Script,
    /// Black letter, its broad strokes outlined.
    Gothic,
}

words! {
    BundledFont, "font":
    Sans = "sans",
    Script = "script",
    Gothic = "gothic",
}

impl BundledFont {
    /// Its licence, in a word of the field; the whole of it lies beside the data.
    #[must_use]
    pub const fn licence(self) -> &'static str {
        "Hershey"
    }
}

/// Whether the lines of a font are what a pen follows, or the edges of its letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FontKind {
    /// Single lines.
    Stroke,
    /// Edges.
    Outline,
}

impl FontKind {
    /// Its name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stroke => "stroke",
            Self::Outline => "outline",
        }
    }
}

/// A font: one that is built in, by its name, or a file.
///
/// ```
/// use magician_formats::{BundledFont, FontChoice};
///
/// assert_eq!("script".parse(), Ok(FontChoice::Bundled(BundledFont::Script)));
/// assert!("serif".parse::<FontChoice>().unwrap_err().contains("sans, script, gothic"));
/// ```
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub enum FontChoice {
    /// Built in.
    Bundled(BundledFont),
    /// A file, and what it is called.
    File {
        /// The name of the file.
        name: String,
        /// What is in it.
        bytes: Arc<[u8]>,
    },
}

impl FontChoice {
    /// What is in a file of this name.
    #[must_use]
    pub fn file(name: impl Into<String>, bytes: impl Into<Arc<[u8]>>) -> Self {
        Self::File {
            name: name.into(),
            bytes: bytes.into(),
        }
    }
}

impl Default for FontChoice {
    fn default() -> Self {
        Self::Bundled(BundledFont::default())
    }
}

impl fmt::Debug for FontChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("FontChoice")
            .field(&self.to_string())
            .finish()
    }
}

impl fmt::Display for FontChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bundled(font) => font.fmt(f),
            Self::File { name, .. } => f.pad(name),
        }
    }
}

impl FromStr for FontChoice {
    type Err = String;

    /// One that is built in.
    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = text.trim().to_ascii_lowercase();
        let named = wanted.parse().map(Self::Bundled);
        named.map_err(|_: String| {
            let names = BundledFont::NAMES.join(", ");
            format!("unknown font '{}'; built in are {names}", text.trim())
        })
    }
}
