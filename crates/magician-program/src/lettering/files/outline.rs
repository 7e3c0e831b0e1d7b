//! TrueType and OpenType: the edges of letters.

use std::sync::Arc;

use kurbo::{BezPath, Point};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, MetadataProvider};

use crate::Diagnostic;
use crate::curves::flatten;
use crate::lettering::{Glyph, Glyphs};

/// How high a capital is where the font does not say it, of its size.
const USUAL_CAP: f64 = 0.7;

pub(super) struct OutlineFont {
    bytes: Arc<[u8]>,
    cap_height: f64,
}

pub(super) fn read(bytes: Arc<[u8]>) -> Result<OutlineFont, Diagnostic> {
    let font = font(&bytes).map_err(|error| Diagnostic::of_file(error.to_string()))?;
    let metrics = font.metrics(Size::unscaled(), LocationRef::default());
    let of_h = glyph(&font, 'H', 1.0).and_then(|glyph| glyph.bounds());
    let cap_height = match (of_h, metrics.cap_height) {
        (Some([_, most]), _) if most[1] > 0.0 => most[1],
        (_, Some(said)) if said > 0.0 => said.into(),
        _ => USUAL_CAP * f64::from(metrics.units_per_em),
    };
    if font.charmap().is_symbol() || font.charmap().has_map() {
        return Ok(OutlineFont { bytes, cap_height });
    }
    Err(Diagnostic::of_file(
        "the font does not say which glyphs characters have",
    ))
}

/// The font, or the first one of a collection.
fn font(bytes: &[u8]) -> Result<FontRef<'_>, skrifa::raw::ReadError> {
    FontRef::from_index(bytes, 0)
}

fn glyph(font: &FontRef<'_>, character: char, tolerance: f64) -> Option<Glyph> {
    let id = font.charmap().map(character)?;
    let (size, place) = (Size::unscaled(), LocationRef::default());
    let advance = font.glyph_metrics(size, place).advance_width(id)?;
    let mut path = PathPen::default();
    if let Some(outline) = font.outline_glyphs().get(id) {
        outline
            .draw(DrawSettings::unhinted(size, place), &mut path)
            .ok()?;
    }
    Some(Glyph {
        advance: advance.into(),
        lines: flatten(&path.0, tolerance, true),
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

/// Takes a glyph down.
#[derive(Default)]
struct PathPen(BezPath);

fn point(x: f32, y: f32) -> Point {
    Point::new(x.into(), y.into())
}

impl OutlinePen for PathPen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(point(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(point(x, y));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.0.quad_to(point(cx, cy), point(x, y));
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        self.0
            .curve_to(point(cx0, cy0), point(cx1, cy1), point(x, y));
    }

    fn close(&mut self) {
        self.0.close_path();
    }
}
