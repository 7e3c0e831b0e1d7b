//! Centre lines of the dark lines of an image: thinned to a skeleton, whose branches become
//! strokes.
//!
//! The image is reduced and thresholded, thinned to lines one pixel wide (`thin`), converted to a
//! graph of branches and junctions (`graph`), and cleaned of the artefacts of thinning (`strokes`).
//! Artefacts are short compared with the thickness of the original lines; details are not.

mod graph;
mod strokes;
mod thin;

use super::{Raster, Trace, specks};
use crate::{Origin, Stroke};
use magician_formats::simplify::simplified;

/// Largest side in pixels that is processed: more than A4 at 300 dpi. Larger images are reduced
/// first.
const MAX_SIDE: usize = 4000;
/// Smallest useful pixel, mm: finer detail cannot be drawn by a pen.
const MIN_PIXEL_SIZE: f64 = 0.04;
/// Largest half thickness of a line, mm. Thicker shapes are areas: their skeleton is drawn as it
/// is, with its branches.
const MAX_HALF_THICKNESS: f64 = 1.0;
/// Share of the tolerance spent on leaving out points; the rest is for the pixels.
const SIMPLIFY_SHARE: f64 = 0.5;

/// Returns the strokes, and the number of specks left out.
pub(super) fn strokes(image: &Raster, page: [f64; 2], trace: &Trace) -> (Vec<Stroke>, usize) {
    let mut small = super::trace::reduced(image, page, MIN_PIXEL_SIZE, MAX_SIDE);
    let pixel = [page[0] / small.width as f64, page[1] / small.height as f64];
    let left_out = specks::whiten(&mut small, pixel, trace.level, trace.despeckle);
    let mask = thin::Mask::new(&small, trace.level);
    let thickness = mask.thickness();
    let line = (MAX_HALF_THICKNESS / pixel[0].max(pixel[1])).max(1.0);
    let graph = graph::Graph::of(&mask.thinned(), &thickness, line);
    let rows = image.height as f64 / small.height as f64;
    let strokes = strokes::of(graph).into_iter().map(|points| {
        let row = points.first().map_or(0.0, |[_, y]| y * rows);
        let on_sheet = |[x, y]: [f64; 2]| [x * pixel[0], page[1] - y * pixel[1]];
        let points: Vec<_> = points.into_iter().map(on_sheet).collect();
        Stroke {
            points: simplified(&points, trace.tolerance * SIMPLIFY_SHARE),
            origin: Origin {
                line: (row as u32).saturating_add(1).min(image.height as u32),
                ..Origin::NONE
            },
            style: crate::artwork::Style::default(),
        }
    });
    (strokes.collect(), left_out)
}
