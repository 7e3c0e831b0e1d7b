//! Fonts defined in the drawing: `font` with `font-face` and `glyph` (SVG 1.1, chapter 20).
//!
//! usvg does not support them. So it gets a synthetic TrueType font of the same family with the
//! same advances and invisible glyphs ([`measures`]). It lays the text out with that font, and the
//! lines of the letters come from the file.

mod measures;

use magician_host::message;
use std::collections::BTreeSet;
use std::sync::Arc;

use kurbo::Affine;
use roxmltree::Node;
use usvg::fontdb::{Database, FaceInfo, ID, Language, Source, Stretch, Style, Weight};
use usvg::{Font, FontFamily, FontResolver, Text};

use super::super::collector::{NodeContext, StrokeCollector, matrix};
use super::super::lines::Line;
use super::super::notes::Notes;
use super::super::source;
use crate::formats::Fills;
use crate::lettering::{Glyphs, SvgFont};
use crate::{Diagnostic, DiagnosticCode, Lines, font};

/// Largest number of fonts per drawing. It bounds time, because each becomes a font file in memory.
const MAX_FONTS: usize = 256;

/// Fonts in a drawing.
#[derive(Clone, Default)]
pub(in super::super) struct FileFonts(Vec<Arc<FileFont>>);

struct FileFont {
    family: String,
    weight: u16,
    italic: bool,
    font: SvgFont,
}

impl FileFonts {
    /// Reads the fonts in a drawing. A font that cannot be read is left out with a note.
    pub(in super::super) fn of(text: &str, notes: &mut Notes) -> Result<Self, Diagnostic> {
        let mut fonts = Self::default();
        // Avoid parsing the document again for the many drawings without fonts.
        if !text.contains("font-face") || !text.contains("glyph") {
            return Ok(fonts);
        }
        let characters: BTreeSet<char> = text.chars().collect();
        let document = source::parse(text)?;
        let lines = Lines::new(text);
        let elements = document.descendants();
        for node in elements
            .filter(|node| source::is(node, "font"))
            .take(MAX_FONTS)
        {
            let face = node.children().find(|node| source::is(node, "font-face"));
            let Some(face) = face else { continue };
            let family = face.attribute("font-family").unwrap_or_default();
            let family = family.trim().trim_matches(['\'', '"']).trim();
            if family.is_empty() {
                continue;
            }
            match SvgFont::of(&node) {
                Ok(font) => fonts.0.push(Arc::new(FileFont {
                    family: family.to_owned(),
                    weight: weight(&face),
                    italic: matches!(face.attribute("font-style"), Some("italic" | "oblique")),
                    font: font.with_lacking(characters.iter().copied()),
                })),
                Err(problem) => {
                    let remark = message!(
                        "the font {family} is not used: {message}",
                        family,
                        message = problem.message
                    );
                    let start = node.range().start;
                    let note = Diagnostic::new(lines.origin(start..start), remark);
                    notes.add(note.coded(DiagnosticCode::LeftOut));
                }
            }
        }
        Ok(fonts)
    }

    /// Adds the synthetic fonts to a database.
    pub(super) fn among(&self, others: Arc<Database>) -> LaidFonts {
        let mut laid = LaidFonts {
            database: others,
            faces: Vec::new(),
        };
        for font in &self.0 {
            let Some(bytes) = measures::of(&font.font) else {
                continue;
            };
            let face = FaceInfo {
                id: ID::dummy(),
                source: Source::Binary(Arc::new(bytes)),
                index: 0,
                families: vec![(font.family.clone(), Language::English_UnitedStates)],
                post_script_name: String::new(),
                style: if font.italic {
                    Style::Italic
                } else {
                    Style::Normal
                },
                weight: Weight(font.weight),
                stretch: Stretch::Normal,
                monospaced: false,
            };
            let id = Arc::make_mut(&mut laid.database).push_face_info(face);
            laid.faces.push((id, Arc::clone(font)));
        }
        laid
    }
}

fn weight(face: &Node<'_, '_>) -> u16 {
    match face.attribute("font-weight").map(str::trim) {
        Some("bold") => 700,
        Some(number) => number.parse().unwrap_or(400),
        None => 400,
    }
}

/// Fonts for laying out a drawing.
#[derive(Clone)]
pub(in super::super) struct LaidFonts {
    pub(super) database: Arc<Database>,
    faces: Vec<(ID, Arc<FileFont>)>,
}

impl LaidFonts {
    /// True if the file has no fonts.
    pub(super) fn are_of_others(&self) -> bool {
        self.faces.is_empty()
    }

    /// Returns the font in the file that a face stands for.
    fn of(&self, face: ID) -> Option<&FileFont> {
        let found = self.faces.iter().find(|(id, _)| *id == face);
        found.map(|(_, font)| &**font)
    }

    /// Height of a capital of a font in the file, in units of its synthetic face.
    pub(super) fn cap_height(&self, face: ID) -> Option<f64> {
        let FileFont { font, .. } = self.of(face)?;
        Some(font.cap_height() * measures::UNITS_PER_EM / font.em())
    }

    /// Creates a resolver that prefers fonts in the file.
    pub(super) fn resolver(&self, others: FontResolver<'static>) -> FontResolver<'static> {
        let FontResolver {
            select_font,
            select_fallback,
        } = others;
        let faces = self.faces.clone();
        FontResolver {
            select_font: Box::new(move |font, database| {
                for family in font.families() {
                    let FontFamily::Named(name) = family else {
                        break;
                    };
                    if let Some(own) = nearest(&faces, name, font) {
                        return Some(own);
                    }
                }
                select_font(font, database)
            }),
            select_fallback: Box::new(move |character, used, database| {
                let ours = font::first_face(database).filter(|ours| !used.contains(ours));
                ours.or_else(|| select_fallback(character, used, database))
            }),
        }
    }
}

/// Returns the font of a family that best matches style and weight.
fn nearest(faces: &[(ID, Arc<FileFont>)], family: &str, asked: &Font) -> Option<ID> {
    let italic = asked.style() != usvg::FontStyle::Normal;
    let of_family = faces.iter();
    let of_family = of_family.filter(|(_, font)| font.family.eq_ignore_ascii_case(family));
    let nearest = of_family
        .min_by_key(|(_, font)| (font.italic != italic, font.weight.abs_diff(asked.weight())));
    nearest.map(|(id, _)| *id)
}

impl StrokeCollector<'_> {
    /// True if a text has letters of a font in the file.
    pub(super) fn has_own_letters(&self, text: &Text, single_line: bool) -> bool {
        let glyphs = text
            .layouted()
            .iter()
            .flat_map(|span| &span.positioned_glyphs);
        let mut fonts = glyphs.filter_map(|glyph| self.fonts.of(glyph.font));
        fonts.any(|font| !single_line || font.font.is_single_line())
    }

    /// Draws the letters of fonts in the file. usvg has laid out the other letters.
    pub(super) fn own_letters(
        &mut self,
        text: &Text,
        place: &NodeContext,
    ) -> Result<(), Diagnostic> {
        let fonts = self.fonts.clone();
        for span in text.layouted().iter().filter(|span| span.visible) {
            let stroke = span.stroke.as_ref().map(usvg::Stroke::paint);
            let paint = stroke.or(span.fill.as_ref().map(usvg::Fill::paint));
            let white = paint.is_some_and(|paint| self.whites.is_white(paint));
            for laid in &span.positioned_glyphs {
                let Some(FileFont { family, font, .. }) = fonts.of(laid.font) else {
                    continue;
                };
                let scale = measures::UNITS_PER_EM / font.em();
                let to = place.to * matrix(laid.outline_transform()) * Affine::scale(scale);
                let tolerance = self.close.tolerance / to.determinant().abs().sqrt();
                let mut advance = 0.0;
                for character in laid.text.chars() {
                    let Some(glyph) = font.glyph(character, tolerance) else {
                        continue;
                    };
                    if font.lacks(character) && !character.is_whitespace() {
                        let remark = message!(
                            "written in sans, because the font {family} does not have it: '{character}'",
                            family,
                            character
                        );
                        let note = place.element.diagnostic(remark);
                        self.notes.add(note.coded(DiagnosticCode::Assumed));
                    }
                    let placed = |line: &Line| -> Line {
                        let points = line.iter().map(|[x, y]| {
                            let at = to * kurbo::Point::new(x + advance, *y);
                            [at.x, at.y]
                        });
                        points.collect()
                    };
                    let lines: Vec<Line> = glyph.lines.iter().map(placed).collect();
                    advance += glyph.advance;
                    let closed = self.fills == Fills::Areas && font.is_closed(character);
                    let fill = span.fill.as_ref().filter(|_| closed);
                    if let Some(fill) = fill {
                        self.area(lines.clone(), fill, place)?;
                    }
                    if fill.is_none() || white {
                        self.add(lines, place, white, paint)?;
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
