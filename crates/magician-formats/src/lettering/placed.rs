//! Letters for drawings that place each letter themselves.

use super::{Glyph, Glyphs, LoadedFont};
use crate::formats::ReadOptions;
use crate::{Diagnostic, DiagnosticCode, Origin};

use magician_host::message;
use magician_host::{Setting, SettingValue};

/// Font for the texts of a drawing.
#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
pub(crate) struct Lettering {
    font: LoadedFont,
    name: String,
    strict: bool,
    tolerance: f64,
}

#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
impl Lettering {
    /// Loads the font from the options.
    ///
    /// # Errors
    /// A [`Diagnostic`] if the file cannot be read as a font.
    pub(crate) fn new(options: &ReadOptions, tolerance: f64) -> Result<Self, Diagnostic> {
        Ok(Self {
            font: options.text.font.load()?,
            name: options.text.font.to_string(),
            strict: options.strict_text,
            tolerance,
        })
    }

    /// Returns a character whose capitals are `size` mm high. `None` if no font has it.
    pub(crate) fn glyph(&self, character: char, size: f64) -> Option<Glyph> {
        let character = match character {
            '\u{A0}' | '\u{202F}' => character,
            space if space.is_whitespace() => ' ',
            // Drawings use both signs for a diameter.
            '∅' | '⌀' => 'Ø',
            other => other,
        };
        let sized = |font: &dyn Glyphs| {
            let scale = size / font.cap_height();
            let glyph = font.glyph(character, self.tolerance / scale.max(f64::MIN_POSITIVE))?;
            Some(glyph.scaled([scale; 2]))
        };
        let other = || sized(&self.font.fallback()?);
        sized(&self.font).or_else(other)
    }

    /// Reports a character that no font has: a note, or in strict mode an error.
    pub(crate) fn lacks(&self, character: char, origin: Origin) -> Result<Diagnostic, Diagnostic> {
        let found = lacks(character, &self.name, self.strict, origin);
        if self.strict {
            Err(found)
        } else {
            Ok(found.coded(DiagnosticCode::LeftOut))
        }
    }
}

/// Creates the diagnostic for a character that a font lacks.
pub(crate) fn lacks(character: char, font: &str, strict: bool, origin: Origin) -> Diagnostic {
    let code = format!("{:04X}", u32::from(character));
    let message = if strict {
        message!(
            "U+{code} '{character}': the font {font} does not have it",
            code,
            character,
            font
        )
    } else {
        message!(
            "U+{code} '{character}' is left out: the font {font} does not have it",
            code,
            character,
            font
        )
    };
    Diagnostic::new(origin, message).remedy(
        (Setting::Font, SettingValue::Any("FILE")),
        "writes it with a font that has it",
    )
}
