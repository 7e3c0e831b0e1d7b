//! A font that is there to be written with.

use super::hershey::Hershey;
use super::{FontChoice, Glyph, Glyphs};
use crate::Diagnostic;

/// A font that is there to be written with.
pub(crate) enum LoadedFont {
    Hershey(&'static Hershey),
}

impl FontChoice {
    /// Reads the font.
    ///
    /// # Errors
    /// What is wrong with its file.
    pub(crate) fn load(&self) -> Result<LoadedFont, Diagnostic> {
        match self {
            Self::Bundled(font) => Ok(LoadedFont::Hershey(Hershey::of(*font))),
            Self::File { name, .. } => Err(Diagnostic::of_file(format!(
                "{name}: fonts of files are not read"
            ))),
        }
    }
}

impl Glyphs for LoadedFont {
    fn cap_height(&self) -> f64 {
        match self {
            Self::Hershey(font) => font.cap_height(),
        }
    }

    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph> {
        match self {
            Self::Hershey(font) => font.glyph(character, tolerance),
        }
    }
}
