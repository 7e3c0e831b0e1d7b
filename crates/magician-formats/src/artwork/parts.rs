//! Parts of a drawing: its layers, pens or colours, each drawn with its own pen.

use super::{Artwork, Stroke};
use crate::fill::FillMode;
use crate::{Color, Part};

/// Layer, colour and part of a stroke or an area, as indices from 1 into the lists of its
/// [`Artwork`]; 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Style {
    /// Layer or pen, in [`Artwork::layers`].
    pub layer: u32,
    /// Colour, in [`Artwork::colors`].
    pub color: u32,
    /// Part, in [`Artwork::parts`].
    pub part: u32,
}

/// A layer of a drawing, or a pen of a plot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layer {
    /// Name; `None` for elements outside all layers.
    pub name: Option<String>,
    /// True for a layer of Inkscape, whose name may carry commands for a plotter.
    pub inkscape: bool,
}

/// A part of a drawing, and how to draw it.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DrawingPart {
    /// Number, name and colour.
    pub part: Part,
    /// True if the job pauses before this part even if nothing was drawn before.
    pub waits: bool,
    /// True if the part is left out.
    pub skipped: bool,
    /// True if only other parts were requested. The part is not drawn, but still counts for the
    /// placing, so that parts drawn in separate runs fit together.
    pub unasked: bool,
    /// Number of passes.
    pub passes: u32,
    /// Pen settings.
    pub pen: PartPen,
}

/// Pen settings of a part that differ from those of the drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartPen {
    /// Height of its surface above that of the drawing, mm.
    pub surface_offset: f64,
    /// Lift, mm; `None` for that of the drawing.
    pub lift: Option<f64>,
    /// Speed along strokes, mm/s; `None` for that of the drawing.
    pub speed: Option<f64>,
    /// Laser power along strokes, percent; `None` for that of the drawing.
    pub power: Option<f64>,
    /// Fill mode; `None` for that of the drawing.
    pub fill: Option<FillMode>,
}

impl Artwork {
    /// Returns the index (from 1) of a layer. Adds the layer if it is new.
    #[cfg(feature = "drawings")]
    pub(crate) fn layer(&mut self, layer: &Layer) -> u32 {
        index_or_push(&mut self.layers, layer)
    }

    /// Iterates over the strokes of each part, in the order of the parts, with the part's index.
    pub(crate) fn by_part(&self) -> impl Iterator<Item = (usize, &[Stroke])> {
        let runs = self
            .strokes
            .chunk_by(|one, next| one.style.part == next.style.part);
        runs.filter_map(|run| Some((run.first()?.style.part as usize, run)))
    }

    /// Applies a change to the strokes of each part. Afterwards strokes are sorted by part.
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

/// Returns the index (from 1) of a value in a list. Appends the value if it is new.
#[cfg(feature = "drawings")]
pub(crate) fn index_or_push<T: Clone + PartialEq>(list: &mut Vec<T>, value: &T) -> u32 {
    let place = list.iter().position(|known| known == value);
    let place = place.unwrap_or_else(|| {
        list.push(value.clone());
        list.len() - 1
    });
    u32::try_from(place + 1).unwrap_or(0)
}

impl DrawingPart {
    /// True if the part has this name.
    #[must_use]
    pub fn has_name(&self, name: &str) -> bool {
        self.part.name.as_deref() == Some(name)
    }

    /// True if the part has this colour. False for `None`.
    #[must_use]
    pub fn has_color(&self, color: Option<Color>) -> bool {
        color.is_some() && self.part.color == color
    }
}
