//! Loaded fonts.

use super::hershey::Hershey;
use super::{BundledFont, FontChoice, Glyph, Glyphs};
use crate::Diagnostic;

/// A font, and the fallback for characters that it lacks.
pub(crate) struct LoadedFont {
    font: Box<dyn Glyphs>,
    fallback: Option<&'static Hershey>,
}

impl FontChoice {
    /// Loads the font.
    ///
    /// # Errors
    /// A [`Diagnostic`] if the file cannot be read as a font.
    pub(crate) fn load(&self) -> Result<LoadedFont, Diagnostic> {
        match self {
            Self::Bundled(font) => Ok(LoadedFont {
                font: Box::new(Hershey::of(*font)),
                fallback: None,
            }),
            Self::File { name, bytes } => Ok(LoadedFont {
                font: of_file(name, bytes)?,
                fallback: Some(Hershey::of(BundledFont::Sans)),
            }),
        }
    }
}

#[cfg(feature = "font-files")]
fn of_file(name: &str, bytes: &std::sync::Arc<[u8]>) -> Result<Box<dyn Glyphs>, Diagnostic> {
    super::files::read(name, bytes)
}

#[cfg(not(feature = "font-files"))]
fn of_file(name: &str, _bytes: &std::sync::Arc<[u8]>) -> Result<Box<dyn Glyphs>, Diagnostic> {
    let message = format!(
        "{name}: this build cannot read files of fonts: it lacks the feature font-files of magician-formats"
    );
    let missing = crate::Missing::Feature("font-files");
    Err(Diagnostic::of_file(message).with_missing(Some(missing)))
}

impl LoadedFont {
    /// Fallback for characters that the font lacks. `None` for bundled fonts.
    pub(crate) fn fallback(&self) -> Option<&'static Hershey> {
        self.fallback
    }
}

impl Glyphs for LoadedFont {
    fn cap_height(&self) -> f64 {
        self.font.cap_height()
    }

    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph> {
        self.font.glyph(character, tolerance)
    }

    fn is_outlined(&self) -> bool {
        self.font.is_outlined()
    }

    fn has_stroke_order(&self) -> bool {
        self.font.has_stroke_order()
    }
}
