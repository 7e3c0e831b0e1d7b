//! Choice of a font for text.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use crate::keywords::keywords;

/// Bundled single-line fonts, by A. V. Hershey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BundledFont {
    /// Sans serif, one stroke per line of a letter.
    #[default]
    Sans,
    /// Script with joined letters.
    Script,
    /// Black letter, its broad strokes as outlines.
    Gothic,
}

keywords! {
    BundledFont, "font":
    Sans = "sans",
    Script = "script",
    Gothic = "gothic",
}

impl BundledFont {
    /// Name of its licence. The full text lies beside the data.
    #[must_use]
    pub const fn licence(self) -> &'static str {
        "Hershey"
    }
}

/// Kind of a font: lines for a pen to follow, or outlines of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FontKind {
    /// Single lines.
    Stroke,
    /// Edges.
    Outline,
}

impl FontKind {
    /// Name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stroke => "stroke",
            Self::Outline => "outline",
        }
    }
}

/// A font: a bundled one by name, or a file.
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
    /// Bundled font.
    Bundled(BundledFont),
    /// Font file.
    File {
        /// Name of the file.
        name: String,
        /// Bytes of the file.
        bytes: Arc<[u8]>,
    },
}

impl FontChoice {
    /// Creates a choice from the name and the bytes of a file.
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

    /// Parses the name of a bundled font.
    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = text.trim().to_ascii_lowercase();
        let named = wanted.parse().map(Self::Bundled);
        named.map_err(|_: String| {
            let names = BundledFont::NAMES.join(", ");
            format!("unknown font '{}'; built in are {names}", text.trim())
        })
    }
}
