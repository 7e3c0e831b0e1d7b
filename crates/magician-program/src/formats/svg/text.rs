//! Texts, as the outlines of their letters.

use kurbo::{Affine, BezPath, PathEl};
use usvg::{Group, Node, Text};

use super::font;
use super::lines::{curves, flatten};
use super::walk::{Place, Walk, matrix};
use crate::{NoteCode, Problem};

impl Walk<'_> {
    pub(super) fn text(&mut self, text: &Text, outer: &Place) -> Result<(), Problem> {
        let place = self.inner(text.id(), outer);
        for character in font::missing(text).chars() {
            let code = u32::from(character);
            let remark = format!(
                "U+{code:04X} '{character}' is left out: the font {} does not have it",
                font::NAME
            );
            let help = "turn the text into paths in the program that it was drawn with";
            let note = place.element.problem(remark).help(help);
            self.notes.add(note.coded(NoteCode::LeftOut));
        }
        for wish in font::differences(text) {
            let remark = format!(
                "text is written in {} Regular instead of {wish}",
                font::NAME
            );
            self.notes
                .add(place.element.problem(remark).coded(NoteCode::Assumed));
        }
        self.letters(text.flattened(), &place, font::speck(text))
    }

    /// The outlines of a text's letters, whatever is done with other fills, but for those that are smaller than a speck.
    fn letters(&mut self, group: &Group, outer: &Place, speck: f64) -> Result<(), Problem> {
        let to = outer.to * matrix(group.transform());
        let place = Place {
            to,
            ..outer.clone()
        };
        for node in group.children() {
            match node {
                Node::Group(group) => self.letters(group, &place, speck)?,
                Node::Path(path) if path.is_visible() => {
                    let placed = self.curves(path, &place)?;
                    // Specks are known by their size in the text's own units, before any transform.
                    let own = curves(path.data(), Affine::IDENTITY);
                    let outlines = outlines(&own).zip(outlines(&placed));
                    let letters = outlines.filter(|(own, _)| extent(own) > speck);
                    let letters: BezPath =
                        letters.flat_map(|(_, placed)| placed).copied().collect();
                    let white = self.whites.is_all_white(path);
                    self.add(flatten(&letters, self.tolerance, true), &place, white)?;
                    self.whites
                        .paint(path, place.to, &place.clips, self.tolerance);
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The parts of a path, each from where the pen is put down.
fn outlines(path: &BezPath) -> impl Iterator<Item = &[PathEl]> {
    let elements = path.elements();
    elements.chunk_by(|_, next| !matches!(next, PathEl::MoveTo(_)))
}

/// The longer side of what holds it.
fn extent(outline: &[PathEl]) -> f64 {
    let path = BezPath::from_vec(outline.to_vec());
    path.control_box().size().max_side()
}
