//! Outlines of TrueType and OpenType fonts, and the height of their capitals.

use kurbo::{BezPath, Point, Shape as _};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// Height of a capital if the font does not give it, as a share of its em. The usual ratio of Latin
/// fonts.
const DEFAULT_CAP_SHARE: f64 = 0.7;

/// Height of a capital, in units of the font: of the glyph H, else as stated in the font, else the
/// usual ratio.
///
/// The glyph comes first because table `OS/2` states the height only from version 2 on, and many
/// installed fonts have an older one.
pub(crate) fn cap_height(font: &FontRef<'_>) -> f64 {
    let metrics = font.metrics(Size::unscaled(), LocationRef::default());
    let of_h = font.charmap().map('H').and_then(|id| outline(font, id));
    match (of_h.map(|h| h.bounding_box().y1), metrics.cap_height) {
        (Some(height), _) if height > 0.0 => height,
        (_, Some(stated)) if stated > 0.0 => stated.into(),
        _ => DEFAULT_CAP_SHARE * f64::from(metrics.units_per_em),
    }
}

/// Returns the outline of a glyph, in units of the font. Empty for blanks; `None` if it cannot be
/// drawn.
pub(crate) fn outline(font: &FontRef<'_>, id: GlyphId) -> Option<BezPath> {
    let mut path = PathPen::default();
    if let Some(outline) = font.outline_glyphs().get(id) {
        let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
        outline.draw(settings, &mut path).ok()?;
    }
    Some(path.0)
}

/// Pen that collects an outline as a Bézier path.
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
