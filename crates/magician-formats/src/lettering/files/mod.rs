//! Readers of font files.

mod outline;
mod stroke_order;

use magician_host::message;
use std::sync::Arc;

use super::{Glyphs, svg_font};
use crate::encoding::{Fallback, decode};
use crate::{Diagnostic, gzip};

/// Largest size of an unpacked font file, bytes. A choice above any real font; it bounds memory.
const MAX_FILE_SIZE: usize = 256 << 20;

/// Reads a font of any supported kind.
pub(super) fn read(name: &str, bytes: &Arc<[u8]>) -> Result<Box<dyn Glyphs>, Diagnostic> {
    let of_this_file = |problem: Diagnostic| Diagnostic {
        message: message!("{name}: {why}", name, why = &problem.message),
        ..problem
    };
    let unpacked = gzip::unpack(bytes, MAX_FILE_SIZE).map_err(of_this_file)?;
    let bytes = match unpacked {
        std::borrow::Cow::Borrowed(_) => Arc::clone(bytes),
        std::borrow::Cow::Owned(unpacked) => unpacked.into(),
    };
    let font: Result<Box<dyn Glyphs>, Diagnostic> = match of(&bytes) {
        Some(Kind::Outline) => outline::read(bytes).map(|font| Box::new(font) as _),
        Some(Kind::Svg) => svg_font::read(&text(&bytes)?).map(|font| Box::new(font) as _),
        Some(Kind::KanjiVg) => {
            stroke_order::kanjivg(&text(&bytes)?).map(|font| Box::new(font) as _)
        }
        Some(Kind::Medians) => {
            stroke_order::medians(&text(&bytes)?, name).map(|font| Box::new(font) as _)
        }
        None => Err(Diagnostic::of_file(message!(
            "this is neither TrueType or OpenType, nor an SVG font, nor an order of strokes (KanjiVG, hanzi-writer)"
        ))),
    };
    let font = font.map_err(of_this_file)?;
    if font.cap_height().is_finite() && font.cap_height() > 0.0 {
        Ok(font)
    } else {
        Err(of_this_file(Diagnostic::of_file(message!(
            "the font has no height"
        ))))
    }
}

enum Kind {
    /// TrueType and OpenType.
    Outline,
    Svg,
    KanjiVg,
    Medians,
}

/// Detects the kind of a font file from its bytes.
fn of(bytes: &[u8]) -> Option<Kind> {
    const OUTLINE_MAGICS: [&[u8]; 4] = [&[0, 1, 0, 0], b"OTTO", b"true", b"ttcf"];
    if OUTLINE_MAGICS.iter().any(|magic| bytes.starts_with(magic)) {
        return Some(Kind::Outline);
    }
    let text = text(bytes).ok()?;
    match text.chars().next()? {
        '{' => Some(Kind::Medians),
        '<' if text.contains("\"kvg:") => Some(Kind::KanjiVg),
        '<' if text.contains("<font") => Some(Kind::Svg),
        _ => None,
    }
}

fn text(bytes: &[u8]) -> Result<String, Diagnostic> {
    let text = decode(bytes, Fallback::Refused)?.text;
    Ok(text.trim_start().to_owned())
}

/// Parses an XML file. Document types are allowed, because KanjiVG and SVG fonts use them.
pub(super) fn document(text: &str) -> Result<roxmltree::Document<'_>, Diagnostic> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(text, options)
        .map_err(|error| Diagnostic::of_file(error.to_string()))
}
