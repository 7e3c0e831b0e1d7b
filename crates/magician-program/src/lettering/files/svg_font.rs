//! Fonts of SVG (SVG 1.1, chapter 20), whose open paths are single lines.

use std::collections::HashMap;

use kurbo::BezPath;
use roxmltree::Node;

use crate::Diagnostic;
use crate::curves::flatten;
use crate::lettering::{Glyph, Glyphs};

/// Units of the em where the font does not say it (20.8.3).
const USUAL_EM: f64 = 1000.0;
/// No capital is lower, of its em.
const LEAST_CAP: f64 = 0.01;
/// How high a capital is where the font has no H and does not say it, of its em.
const USUAL_CAP: f64 = 0.7;

pub(super) struct SvgFont {
    glyphs: HashMap<char, Entry>,
    cap_height: f64,
}

struct Entry {
    advance: f64,
    path: BezPath,
}

pub(super) fn read(text: &str) -> Result<SvgFont, Diagnostic> {
    let document = super::document(text)?;
    let font = document.descendants().find(|node| is(node, "font"));
    let font = font.ok_or_else(|| Diagnostic::of_file("the file has no font"))?;
    let face = font.children().find(|node| is(node, "font-face"));
    let of_face = |name| face.and_then(|face| number(&face, name));
    let usual = number(&font, "horiz-adv-x");
    let em = of_face("units-per-em")
        .filter(|em| *em > 0.0)
        .unwrap_or(USUAL_EM);
    let mut glyphs = HashMap::new();
    for node in font.children().filter(|node| is(node, "glyph")) {
        let mut characters = node.attribute("unicode").unwrap_or_default().chars();
        // More than one is a ligature.
        let (Some(character), None) = (characters.next(), characters.next()) else {
            continue;
        };
        let path = super::path(node.attribute("d").unwrap_or_default(), character, em)?;
        let advance = number(&node, "horiz-adv-x").or(usual);
        let advance = advance.filter(|advance| advance.abs() <= super::FARTHEST * em);
        let advance = advance.unwrap_or(em / 2.0);
        // The first one counts (20.4).
        glyphs.entry(character).or_insert(Entry { advance, path });
    }
    if glyphs.is_empty() {
        return Err(Diagnostic::of_file("the font has no glyph"));
    }
    let mut font = SvgFont {
        glyphs,
        cap_height: of_face("cap-height").unwrap_or(USUAL_CAP * em),
    };
    let of_h = font
        .glyph('H', em / 1000.0)
        .and_then(|glyph| glyph.bounds());
    if let Some([_, most]) = of_h {
        font.cap_height = most[1];
    }
    match font.cap_height > LEAST_CAP * em {
        true => Ok(font),
        false => Err(Diagnostic::of_file("the font has no height")),
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
