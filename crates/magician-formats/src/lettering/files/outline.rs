//! TrueType and OpenType fonts: outlines of letters.

use magician_host::message;
use std::sync::Arc;

use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};

use crate::Diagnostic;
use crate::curves::flatten;
use crate::lettering::outlines::{cap_height, outline};
use crate::lettering::{Glyph, Glyphs};

pub(super) struct OutlineFont {
    bytes: Arc<[u8]>,
    cap_height: f64,
}

pub(super) fn read(bytes: Arc<[u8]>) -> Result<OutlineFont, Diagnostic> {
    let font = font(&bytes).map_err(|error| Diagnostic::of_file(error.to_string()))?;
    let cap_height = cap_height(&font);
    if font.charmap().is_symbol() || font.charmap().has_map() {
        return Ok(OutlineFont { bytes, cap_height });
    }
    Err(Diagnostic::of_file(message!(
        "the font does not say which glyphs characters have"
    )))
}

/// Returns the font, or the first font of a collection.
fn font(bytes: &[u8]) -> Result<FontRef<'_>, skrifa::raw::ReadError> {
    FontRef::from_index(bytes, 0)
}

fn glyph(font: &FontRef<'_>, character: char, tolerance: f64) -> Option<Glyph> {
    let id = font.charmap().map(character)?;
    let metrics = font.glyph_metrics(Size::unscaled(), LocationRef::default());
    Some(Glyph {
        advance: metrics.advance_width(id)?.into(),
        lines: flatten(&outline(font, id)?, tolerance, true),
    })
}

impl Glyphs for OutlineFont {
    fn is_outlined(&self) -> bool {
        true
    }

    fn cap_height(&self) -> f64 {
        self.cap_height
    }

    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph> {
        glyph(&font(&self.bytes).ok()?, character, tolerance)
    }
}
