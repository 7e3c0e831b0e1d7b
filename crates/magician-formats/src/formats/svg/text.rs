//! Texts in drawings, as outlines of letters or in single lines.

mod embedded;
mod single;

use magician_host::message;
use std::sync::Arc;

use kurbo::{Affine, BezPath, PathEl};
use usvg::fontdb::Database;
use usvg::{FontFamily, FontStyle, Group, Node, Options, Path, Text, TextFlow};

use super::collector::{NodeContext, StrokeCollector, matrix};
use super::lines::{curves, flatten};
use super::white::Whites;
use crate::formats::Fills;
use crate::{Diagnostic, DiagnosticCode, TextLines, font};

pub(super) use embedded::{FileFonts, LaidFonts};

/// Returns the fonts for laying texts out: the bundled font, the installed ones on request, and
/// those in the file.
pub(super) fn fonts(of_file: &FileFonts, installed: bool) -> LaidFonts {
    of_file.among(database(installed))
}

/// Sets up usvg: fonts in the file come first, then installed or bundled ones.
pub(super) fn set_up(options: &mut Options<'_>, fonts: &LaidFonts, installed: bool) {
    options.font_family = font::BUNDLED_FAMILY.to_owned();
    options.fontdb = Arc::clone(&fonts.database);
    #[allow(clippy::match_bool, reason = "an arm of some builds only")]
    let others = match installed {
        #[cfg(feature = "system-fonts")]
        true => font::installed_resolver(),
        _ => font::resolver(),
    };
    options.font_resolver = if fonts.are_of_others() {
        others
    } else {
        fonts.resolver(others)
    };
}

#[allow(clippy::match_bool, reason = "an arm of some builds only")]
fn database(installed: bool) -> Arc<Database> {
    match installed {
        #[cfg(feature = "system-fonts")]
        true => font::installed(),
        _ => font::database(),
    }
}

/// True if texts may name installed fonts and this build can load them.
pub(super) fn names_fonts(source: &str) -> bool {
    cfg!(feature = "system-fonts") && source.contains("text") && source.contains("font")
}

/// True if a text has characters that no font has.
pub(super) fn lacks_glyphs(group: &Group) -> bool {
    group.children().iter().any(|node| match node {
        Node::Group(group) => lacks_glyphs(group),
        Node::Text(text) => !missing(text).is_empty(),
        _ => false,
    })
}

/// True if a text runs along a path.
pub(super) fn runs_along_paths(group: &Group) -> bool {
    group.children().iter().any(|node| match node {
        Node::Group(group) => runs_along_paths(group),
        Node::Text(text) => {
            let mut chunks = text.chunks().iter();
            chunks.any(|chunk| matches!(chunk.text_flow(), TextFlow::Path(_)))
        }
        _ => false,
    })
}

impl StrokeCollector<'_> {
    pub(super) fn text(&mut self, text: &Text, outer: &NodeContext) -> Result<(), Diagnostic> {
        let place = self.inner(text.id(), outer);
        let all_single = self.writing.text_lines == TextLines::Stroke;
        let own = self.has_own_letters(text, all_single);
        if let Some(font) = single::font(text, self.writing).filter(|_| !own) {
            return self.single_lines(text, &font, &place);
        }
        if own {
            self.own_letters(text, &place)?;
        }
        for character in missing(text).chars() {
            let help = message!("turn the text into paths in the program that it was drawn with");
            self.lacks(character, font::BUNDLED_FAMILY, &place, |note| {
                note.help(help)
            })?;
        }
        let database = Arc::clone(&self.fonts.database);
        let spans = text.layouted().iter();
        let glyphs = spans.flat_map(|span| &span.positioned_glyphs);
        // A font in the file may lack a blank, so blanks do not count.
        let mut seen = glyphs.filter(|glyph| !own || !glyph.text.trim().is_empty());
        let is_ours = seen.any(|glyph| font::is_bundled(&database, glyph.font));
        // Installed fonts already match what the text asks for.
        let differing = if is_ours {
            differences(text)
        } else {
            Vec::new()
        };
        for wish in differing {
            let remark = message!(
                "text is written in {font} Regular instead of {wish}",
                font = font::BUNDLED_FAMILY,
                wish
            );
            self.notes.add(
                place
                    .element
                    .diagnostic(remark)
                    .coded(DiagnosticCode::Assumed),
            );
        }
        self.letters(text.flattened(), &place, speck(text))
    }

    /// Reports a character that no font has: a note, or in strict mode an error.
    fn lacks(
        &mut self,
        character: char,
        font: &str,
        place: &NodeContext,
        advice: impl FnOnce(Diagnostic) -> Diagnostic,
    ) -> Result<(), Diagnostic> {
        let code = u32::from(character);
        let code = format!("{code:04X}");
        let remark = if self.writing.strict_text {
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
        let found = advice(place.element.diagnostic(remark));
        if self.writing.strict_text {
            return Err(found);
        }
        self.notes.add(found.coded(DiagnosticCode::LeftOut));
        Ok(())
    }

    /// Collects the outlines of a text's letters, regardless of the option for fills, except
    /// specks.
    fn letters(
        &mut self,
        group: &Group,
        outer: &NodeContext,
        speck: f64,
    ) -> Result<(), Diagnostic> {
        let to = outer.to * matrix(group.transform());
        let place = NodeContext {
            to,
            ..outer.clone()
        };
        for node in group.children() {
            match node {
                Node::Group(group) => self.letters(group, &place, speck)?,
                Node::Path(path) if path.is_visible() => {
                    let placed = self.curves(path, &place)?;
                    // Specks are recognised by size in the text's own units, before any transform.
                    let own = curves(path.data(), Affine::IDENTITY);
                    let outlines = outlines(&own).zip(outlines(&placed));
                    let letters = outlines.filter(|(own, _)| extent(own) > speck);
                    let letters: BezPath =
                        letters.flat_map(|(_, placed)| placed).copied().collect();
                    let white = is_all_white(&self.whites, path);
                    let lines = flatten(&letters, self.close.tolerance, true);
                    let fill = path.fill().filter(|_| self.fills == Fills::Areas);
                    if let Some(fill) = fill {
                        self.area(lines.clone(), fill, &place)?;
                    }
                    if fill.is_none() || white {
                        let paint = path.stroke().map(usvg::Stroke::paint);
                        let paint = paint.or(path.fill().map(usvg::Fill::paint));
                        self.add(lines, &place, white, paint)?;
                    }
                    self.whites.paint(path, place.to, &place.clips, self.close);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Iterates over the subpaths of a path.
fn outlines(path: &BezPath) -> impl Iterator<Item = &[PathEl]> {
    let elements = path.elements();
    elements.chunk_by(|_, next| !matches!(next, PathEl::MoveTo(_)))
}

/// Longer side of the bounding box.
fn extent(outline: &[PathEl]) -> f64 {
    let path = BezPath::from_vec(outline.to_vec());
    path.control_box().size().max_side()
}

/// Size below which an outline is the speck drawn for a missing character (`SPECK_GLYPH` in
/// `font.rs`). No real outline is that small.
fn speck(text: &Text) -> f64 {
    let spans = text.chunks().iter().flat_map(|chunk| chunk.spans());
    let sizes = spans.map(|span| f64::from(span.font_size().get()));
    sizes.fold(0.0, f64::max) * 1e-3
}

/// Returns the characters of a text that the font lacks, each once.
fn missing(text: &Text) -> String {
    let mut missing = String::new();
    let spans = text.layouted().iter().filter(|span| span.visible);
    for glyph in spans.flat_map(|span| &span.positioned_glyphs) {
        if glyph.id.0 == 0 {
            for character in glyph.text.chars() {
                if !missing.contains(character) {
                    missing.push(character);
                }
            }
        }
    }
    missing
}

/// Returns the font properties that a text asks for and does not get: family, bold, italic.
fn differences(text: &Text) -> Vec<String> {
    let mut asked = Vec::new();
    let spans = text.chunks().iter().flat_map(|chunk| chunk.spans());
    for font in spans.map(|span| span.font()) {
        let other = match font.families().first() {
            Some(FontFamily::Named(name)) if !name.eq_ignore_ascii_case(font::BUNDLED_FAMILY) => {
                Some(name.clone())
            }
            _ => None,
        };
        let bold = (font.weight() >= 600).then(|| "bold".to_owned());
        let italic = (font.style() != FontStyle::Normal).then(|| "italic".to_owned());
        for wish in [other, bold, italic].into_iter().flatten() {
            if !asked.contains(&wish) {
                asked.push(wish);
            }
        }
    }
    asked
}

/// True if a path is white: its stroke, or its fill if it has no stroke.
fn is_all_white(whites: &Whites, path: &Path) -> bool {
    let visible_stroke = path.stroke().filter(|stroke| stroke.opacity().get() > 0.0);
    let visible_fill = path.fill().filter(|fill| fill.opacity().get() > 0.0);
    let paints = [
        visible_stroke.map(usvg::Stroke::paint),
        visible_fill.map(usvg::Fill::paint),
    ];
    let mut paints = paints.into_iter().flatten().peekable();
    paints.peek().is_some() && paints.all(|paint| whites.is_white(paint))
}
