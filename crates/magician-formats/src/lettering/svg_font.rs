//! SVG fonts (SVG 1.1, chapter 20). Open paths in their glyphs are single lines.

use magician_host::message;
use std::collections::HashMap;

use kurbo::{BezPath, PathEl};
use roxmltree::Node;

use super::hershey::Hershey;
use super::{BundledFont, Glyph, Glyphs};
use crate::Diagnostic;
use crate::curves::flatten;

/// Units per em if the font does not give them (20.8.3).
const DEFAULT_EM: f64 = 1000.0;
/// Smallest height of a capital, as a share of the em. Below it the font is unusable.
const MIN_CAP_SHARE: f64 = 0.01;
/// Height of a capital if the font has no H and does not state it, as a share of the em.
const DEFAULT_CAP_SHARE: f64 = 0.7;

/// Largest coordinate of a glyph, in squares of its font. A choice that rejects damaged files.
const MAX_COORDINATE: f64 = 100.0;

#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
pub(crate) struct SvgFont {
    glyphs: HashMap<char, Entry>,
    em: f64,
    cap_height: f64,
    single_line: bool,
}

#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
struct Entry {
    advance: f64,
    path: BezPath,
    /// True if the glyph was borrowed from another font.
    lent: bool,
}

#[cfg_attr(not(feature = "drawings"), allow(dead_code))]
impl SvgFont {
    /// Reads an element `font`.
    ///
    /// # Errors
    /// A [`Diagnostic`] if a glyph cannot be read or the font has no glyphs.
    pub(crate) fn of(font: &Node<'_, '_>) -> Result<Self, Diagnostic> {
        let face = font.children().find(|node| is(node, "font-face"));
        let of_face = |name| face.and_then(|face| number(&face, name));
        let usual = number(font, "horiz-adv-x");
        let em = of_face("units-per-em")
            .filter(|em| *em > 0.0)
            .unwrap_or(DEFAULT_EM);
        let mut glyphs = HashMap::new();
        for node in font.children().filter(|node| is(node, "glyph")) {
            let mut characters = node.attribute("unicode").unwrap_or_default().chars();
            // More than one character is a ligature, which single-line text does not use.
            let (Some(character), None) = (characters.next(), characters.next()) else {
                continue;
            };
            let path = path(node.attribute("d").unwrap_or_default(), character, em)?;
            let advance = number(&node, "horiz-adv-x").or(usual);
            let advance = advance.filter(|advance| advance.abs() <= MAX_COORDINATE * em);
            let advance = advance.unwrap_or(em / 2.0);
            // If a character occurs twice, the first glyph counts (20.4).
            glyphs.entry(character).or_insert(Entry {
                advance,
                path,
                lent: false,
            });
        }
        if glyphs.is_empty() {
            return Err(Diagnostic::of_file(message!("the font has no glyph")));
        }
        let mut font = Self {
            glyphs,
            em,
            cap_height: of_face("cap-height").unwrap_or(DEFAULT_CAP_SHARE * em),
            single_line: false,
        };
        let of_h = font
            .glyph('H', em / 1000.0)
            .and_then(|glyph| glyph.bounds());
        if let Some([_, most]) = of_h {
            font.cap_height = most[1];
        }
        let closed = |character: &char| font.is_closed(*character);
        font.single_line = !font.glyphs.keys().all(closed);
        if font.cap_height > MIN_CAP_SHARE * em {
            Ok(font)
        } else {
            Err(Diagnostic::of_file(message!("the font has no height")))
        }
    }

    /// Units per em.
    pub(crate) fn em(&self) -> f64 {
        self.em
    }

    /// Iterates over the characters with their advances.
    pub(crate) fn advances(&self) -> impl Iterator<Item = (char, f64)> + '_ {
        let glyphs = self.glyphs.iter();
        glyphs.map(|(character, entry)| (*character, entry.advance))
    }

    /// True if the font lacks the character, or [borrowed](Self::with_lacking) it.
    pub(crate) fn lacks(&self, character: char) -> bool {
        self.glyphs.get(&character).is_none_or(|entry| entry.lent)
    }

    /// True if all lines of a character are closed, so that they are the outline of a filled shape.
    pub(crate) fn is_closed(&self, character: char) -> bool {
        let entry = self.glyphs.get(&character);
        entry.is_some_and(|entry| {
            let elements = entry.path.elements();
            let parts = elements.chunk_by(|_, next| !matches!(next, PathEl::MoveTo(_)));
            { parts }.all(|part| {
                let ends = part.first().zip(part.last());
                ends.is_some_and(|(first, last)| {
                    matches!(last, PathEl::ClosePath) || first.end_point() == last.end_point()
                })
            })
        })
    }

    /// True if some glyphs of this font itself, not of its fallback, have single lines.
    pub(crate) fn is_single_line(&self) -> bool {
        self.single_line
    }

    /// Adds the characters that the font lacks from the fallback font, scaled to the same capital
    /// height.
    pub(crate) fn with_lacking(mut self, characters: impl IntoIterator<Item = char>) -> Self {
        let other = Hershey::of(BundledFont::Sans);
        let scale = self.cap_height / other.cap_height();
        for character in characters {
            if self.glyphs.contains_key(&character) {
                continue;
            }
            let Some(glyph) = other.glyph(character, other.cap_height() / 1000.0) else {
                continue;
            };
            let mut path = BezPath::new();
            for line in &glyph.lines {
                for (nth, [x, y]) in line.iter().enumerate() {
                    let point = (x * scale, y * scale);
                    match nth {
                        0 => path.move_to(point),
                        _ => path.line_to(point),
                    }
                }
            }
            let advance = glyph.advance * scale;
            let lent = Entry {
                advance,
                path,
                lent: true,
            };
            self.glyphs.insert(character, lent);
        }
        self
    }
}

/// Reads the first font of a file.
///
/// # Errors
/// Same as [`SvgFont::of`], and a [`Diagnostic`] if the file has no font.
#[cfg(feature = "font-files")]
pub(super) fn read(text: &str) -> Result<SvgFont, Diagnostic> {
    let document = super::files::document(text)?;
    let font = document.descendants().find(|node| is(node, "font"));
    let font = font.ok_or_else(|| Diagnostic::of_file(message!("the file has no font")))?;
    SvgFont::of(&font)
}

/// Parses the path of a glyph, and refuses coordinates that cannot be drawn.
pub(super) fn path(path: &str, character: char, square: f64) -> Result<BezPath, Diagnostic> {
    let path = BezPath::from_svg(path).map_err(|error| {
        Diagnostic::of_file(message!(
            "a path of '{character}' cannot be read: {error}",
            character,
            error = error.to_string()
        ))
    })?;
    within(path, character, square)
}

pub(super) fn within(path: BezPath, character: char, square: f64) -> Result<BezPath, Diagnostic> {
    let bounds = path.control_box();
    let sides = [bounds.x0, bounds.y0, bounds.x1, bounds.y1];
    let is_near = |side: f64| side.is_finite() && side.abs() <= MAX_COORDINATE * square;
    if path.elements().is_empty() || sides.into_iter().all(is_near) {
        Ok(path)
    } else {
        Err(Diagnostic::of_file(message!(
            "a line of '{character}' is too far away from it",
            character
        )))
    }
}

fn is(node: &Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

fn number(node: &Node<'_, '_>, name: &str) -> Option<f64> {
    let number: f64 = node.attribute(name)?.trim().parse().ok()?;
    number.is_finite().then_some(number)
}

impl Glyphs for SvgFont {
    fn cap_height(&self) -> f64 {
        self.cap_height
    }

    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph> {
        let entry = self.glyphs.get(&character)?;
        Some(Glyph {
            advance: entry.advance,
            lines: flatten(&entry.path, tolerance, false),
        })
    }
}
