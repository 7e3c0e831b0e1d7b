//! Parts of a drawing: its layers, pens or colours, each drawn with a pen of its own.

use super::{Artwork, Stroke};
use crate::fill::FillMode;
use crate::{Color, Part};

/// The layer, colour and part of a line or an area: numbers from 1 into the lists of its [`Artwork`], 0 without one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Style {
    /// Its layer or pen, in [`Artwork::layers`].
    pub layer: u32,
    /// Its colour, in [`Artwork::colors`].
    pub color: u32,
    /// Its part, in [`Artwork::parts`].
    pub part: u32,
}

/// A layer of a drawing, or a pen of a plot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layer {
    /// Its name; none for what is outside of all layers.
    pub name: Option<String>,
    /// Whether it is one of Inkscape's, whose name may carry commands to a plotter.
    pub inkscape: bool,
}

/// A part of a drawing, and how it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DrawingPart {
    /// Number, name and colour.
    pub part: Part,
    /// The job waits for a person before it, whatever comes before.
    pub waits: bool,
    /// It is left out.
    pub skipped: bool,
    /// Others were asked for: it is not drawn, but lies where it would, so that all come to lie in one drawing.
    pub unasked: bool,
    /// How often it is drawn.
    pub passes: u32,
    /// What its pen needs.
    pub pen: PartPen,
}

/// What the pen of a part needs, where that is not as for all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartPen {
    /// How much higher its surface is, mm.
    pub surface_offset: f64,
    /// How far it is lifted, mm.
    pub lift: Option<f64>,
    /// Speed along its lines, mm/s.
    pub speed: Option<f64>,
    /// Power along its lines, percent.
    pub power: Option<f64>,
    /// How its shapes are filled.
    pub fill: Option<FillMode>,
}

impl Artwork {
    /// The place of a layer in the list of layers, from 1; it is added if it is new.
    #[cfg(feature = "drawings")]
    pub(crate) fn layer(&mut self, layer: &Layer) -> u32 {
        numbered(&mut self.layers, layer)
    }

    /// The strokes of each part, in the order of the parts, with its number.
    pub(crate) fn by_part(&self) -> impl Iterator<Item = (usize, &[Stroke])> {
        let runs = self
            .strokes
            .chunk_by(|one, next| one.style.part == next.style.part);
        runs.filter_map(|run| Some((run.first()?.style.part as usize, run)))
    }

    /// Changes the strokes of each part by itself; they come to stand part by part.
    pub(super) fn change_parts(&mut self, mut change: impl FnMut(&mut Vec<Stroke>)) {
        let mut rest = std::mem::take(&mut self.strokes);
        rest.sort_by_key(|stroke| stroke.style.part);
        while let Some(part) = rest.first().map(|stroke| stroke.style.part) {
            let end = rest.partition_point(|stroke| stroke.style.part <= part);
            let others = rest.split_off(end);
            change(&mut rest);
            if self.strokes.is_empty() {
                self.strokes = rest;
            } else {
                self.strokes.append(&mut rest);
            }
            rest = others;
        }
    }
}

/// The place of a value in a list, from 1; it is added if it is new.
#[cfg(feature = "drawings")]
pub(crate) fn numbered<T: Clone + PartialEq>(list: &mut Vec<T>, value: &T) -> u32 {
    let place = list.iter().position(|known| known == value);
    let place = place.unwrap_or_else(|| {
        list.push(value.clone());
        list.len() - 1
    });
    u32::try_from(place + 1).unwrap_or(0)
}

impl DrawingPart {
    /// Whether a person means it: by its name, its colour, or its number.
    #[must_use]
    pub fn has_name(&self, name: &str) -> bool {
        self.part.name.as_deref() == Some(name)
    }

    /// Whether it has this colour.
    #[must_use]
    pub fn has_color(&self, color: Option<Color>) -> bool {
        color.is_some() && self.part.color == color
    }
}
