//! Letters for drawings that say themselves where their texts go.

use super::{Glyph, Glyphs, LoadedFont};
use crate::formats::ReadOptions;
use crate::{Diagnostic, DiagnosticCode, Origin};

use magician_host::message;
use magician_host::{Given, Setting};

/// The font that the texts of a drawing are written with.
#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
pub(crate) struct Lettering {
    font: LoadedFont,
    name: String,
    strict: bool,
    tolerance: f64,
}

#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
impl Lettering {
    /// The font that was asked for.
    ///
    /// # Errors
    /// What is wrong with its file.
    pub(crate) fn new(options: &ReadOptions, tolerance: f64) -> Result<Self, Diagnostic> {
        Ok(Self {
            font: options.text.font.load()?,
            name: options.text.font.to_string(),
            strict: options.strict_text,
            tolerance,
        })
    }

    /// A character whose capitals are so high, mm; none if no font has it.
    pub(crate) fn glyph(&self, character: char, size: f64) -> Option<Glyph> {
        let character = match character {
            '\u{A0}' | '\u{202F}' => character,
            space if space.is_whitespace() => ' ',
            // What drawings mean by the sign of a diameter.
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

    /// That no font has a character: a note, or the reason to refuse the drawing.
    pub(crate) fn lacks(&self, character: char, origin: Origin) -> Result<Diagnostic, Diagnostic> {
        let found = lacks(character, &self.name, self.strict, origin);
        if self.strict {
            Err(found)
        } else {
            Ok(found.coded(DiagnosticCode::LeftOut))
        }
    }
}

/// That a font does not have a character, and what helps.
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
        (Setting::Font, Given::Any("FILE")),
        "writes it with a font that has it",
    )
}
