//! Texts in single lines: of fonts whose name asks for them, or all on request.
//!
//! usvg lays the text out with the outline font. Each letter is replaced by one in single lines at
//! the same place and of the same width. So anchors, tspans, letter spacing, rotated letters and
//! texts on paths work, and script letters stay joined.

use std::collections::HashMap;

use kurbo::Affine;
use magician_host::message;
use magician_host::{Setting, SettingValue};
use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use usvg::fontdb::ID;
use usvg::layout::PositionedGlyph;
use usvg::{FontFamily, Path, Text};

use super::super::collector::{NodeContext, StrokeCollector, matrix};
use super::super::lines::Line;
use super::LaidFonts;
use crate::lettering::{BundledFont, FontChoice, Glyphs, cap_height};
use crate::{Diagnostic, DiagnosticCode, ReadOptions, TextLines};

/// Returns the single-line font of a text; `None` if its outlines are drawn.
pub(super) fn font(text: &Text, writing: &ReadOptions) -> Option<FontChoice> {
    let spans = text.chunks().iter().flat_map(|chunk| chunk.spans());
    let families = spans.flat_map(|span| span.font().families());
    let mut asked = families.filter_map(|family| match family {
        FontFamily::Named(name) => single_line(name),
        _ => None,
    });
    match asked.next() {
        Some(font) => Some(FontChoice::Bundled(font)),
        None if writing.text_lines == TextLines::Stroke => Some(writing.text.font.clone()),
        None => None,
    }
}

/// Returns the font for a family name that says it has single lines, as plotter software names
/// them.
fn single_line(family: &str) -> Option<BundledFont> {
    let name = family.to_ascii_lowercase();
    if !(name.starts_with("hershey") || name.ends_with("1-stroke") || name.ends_with("single line"))
    {
        return None;
    }
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    Some(if has(&["script", "cursive"]) {
        BundledFont::Script
    } else if has(&["gothic", "blackletter"]) {
        BundledFont::Gothic
    } else {
        BundledFont::Sans
    })
}

/// Metrics of a glyph in the font used for the layout, in units of that font.
struct Metrics {
    cap_height: f64,
    advance: f64,
}

impl LaidFonts {
    /// Returns the metrics of a glyph; `cap_heights` caches the capital height per font. `None` if
    /// the font cannot be read.
    fn metrics(
        &self,
        glyph: &PositionedGlyph,
        cap_heights: &mut HashMap<ID, f64>,
    ) -> Option<Metrics> {
        self.database.with_face_data(glyph.font, |data, index| {
            let font = FontRef::from_index(data, index).ok()?;
            let metrics = font.glyph_metrics(Size::unscaled(), LocationRef::default());
            let cap_height = cap_heights.entry(glyph.font).or_insert_with(|| {
                // The synthetic face of a font in the file has no visible letters to measure.
                let of_file = self.cap_height(glyph.font);
                of_file.unwrap_or_else(|| cap_height(&font))
            });
            Some(Metrics {
                cap_height: *cap_height,
                advance: metrics
                    .advance_width(GlyphId::new(glyph.id.0))
                    .unwrap_or_default()
                    .into(),
            })
        })?
    }
}

impl StrokeCollector<'_> {
    pub(super) fn single_lines(
        &mut self,
        text: &Text,
        choice: &FontChoice,
        place: &NodeContext,
    ) -> Result<(), Diagnostic> {
        let font = choice.load()?;
        let fonts = self.fonts.clone();
        let mut cap_heights = HashMap::new();
        let mut missing = String::new();
        for span in text.layouted().iter().filter(|span| span.visible) {
            let paints = [
                span.stroke.as_ref().map(usvg::Stroke::paint),
                span.fill.as_ref().map(usvg::Fill::paint),
            ];
            let paint = paints.into_iter().flatten().next();
            let white = paint.is_some_and(|paint| self.whites.is_white(paint));
            let lines = [&span.underline, &span.overline, &span.line_through];
            for line in lines.into_iter().flatten() {
                self.add(vec![middle(line, place.to)], place, white, paint)?;
            }
            for laid in &span.positioned_glyphs {
                let Some(own) = fonts.metrics(laid, &mut cap_heights) else {
                    let remark = message!(
                        "text is left out: the font that it is laid out with cannot be read"
                    );
                    let note = place.element.diagnostic(remark);
                    self.notes.add(note.coded(DiagnosticCode::LeftOut));
                    continue;
                };
                let to = place.to * matrix(laid.outline_transform());
                let scale = own.cap_height / font.cap_height();
                let tolerance = self.close.tolerance / (scale * to.determinant().abs().sqrt());
                let mut advance = 0.0;
                let mut letters: Vec<Line> = Vec::new();
                for character in laid
                    .text
                    .chars()
                    .filter(|character| !character.is_control())
                {
                    let glyph = font.glyph(character, tolerance).or_else(|| {
                        let other = font.fallback()?;
                        other.glyph(character, tolerance)
                    });
                    let Some(glyph) = glyph else {
                        if !missing.contains(character) {
                            missing.push(character);
                        }
                        continue;
                    };
                    let moved = |line: &Line| line.iter().map(|[x, y]| [x + advance, *y]).collect();
                    letters.extend(glyph.lines.iter().map(moved));
                    advance += glyph.advance;
                }
                // Same advance as in the layout, so that spacing, anchors and paths stay right.
                let widened = if advance > 0.0 && own.advance > 0.0 {
                    own.advance / advance
                } else {
                    scale
                };
                let to = to * Affine::scale_non_uniform(widened, scale);
                for point in letters.iter_mut().flatten() {
                    let at = to * kurbo::Point::new(point[0], point[1]);
                    *point = [at.x, at.y];
                }
                self.add(letters, place, white, paint)?;
            }
        }
        for character in missing.chars() {
            self.lacks(character, &choice.to_string(), place, |note| {
                note.remedy(
                    (Setting::Font, SettingValue::Any("FILE")),
                    "writes it with a font that has it",
                )
            })?;
        }
        Ok(())
    }
}

/// Returns the centre line of a bar, such as an underline.
fn middle(bar: &Path, to: Affine) -> Line {
    let bounds = bar.data().bounds();
    let y = f64::from(bounds.top() + bounds.bottom()) / 2.0;
    let ends = [bounds.left(), bounds.right()];
    let point = |x: f32| {
        let at = to * kurbo::Point::new(x.into(), y);
        [at.x, at.y]
    };
    ends.map(point).to_vec()
}
