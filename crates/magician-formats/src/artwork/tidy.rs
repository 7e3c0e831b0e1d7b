//! Clean-up of strokes: ends that nearly meet are joined, duplicates are drawn once, and redundant
//! points are removed.

use std::collections::HashSet;

use super::order::join;
use super::{Artwork, Stroke};
use crate::FilledArea;
use crate::fill::Area;
use crate::simplify::simplified;

/// Distance below which vertices of two strokes count as equal, mm.
const VERTEX_TOLERANCE: f64 = 1e-4;

/// Options for cleaning up the strokes of a drawing before they are ordered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tidy {
    /// Largest gap to join, mm; 0 joins none.
    pub merge: f64,
    /// True if duplicates are drawn once, regardless of start and direction.
    pub dedupe: bool,
    /// Tolerance for removing points, mm; 0 removes none.
    pub simplify: f64,
}

impl Default for Tidy {
    /// Joins gaps up to 0.1 mm, removes duplicates, and simplifies within 0.02 mm.
    fn default() -> Self {
        Self {
            merge: 0.1,
            dedupe: true,
            simplify: 0.02,
        }
    }
}

/// Effect of the clean-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Tidied {
    /// Number of duplicates removed.
    pub repeated: usize,
    /// Number of strokes that now continue another one.
    pub joined: usize,
}

impl Artwork {
    /// Returns only the page, and the strokes and areas simplified within `distance`, mm.
    #[must_use]
    pub fn thinned(&self, distance: f64) -> Self {
        let strokes = self.strokes.iter().map(|stroke| Stroke {
            points: simplified(&stroke.points, distance),
            ..*stroke
        });
        let areas = self.areas.iter().map(|filled| FilledArea {
            area: Area {
                rings: { filled.area.rings.iter() }
                    .map(|ring| simplified(ring, distance))
                    .collect(),
                rule: filled.area.rule,
            },
            ..*filled
        });
        Self {
            page: self.page,
            strokes: strokes.collect(),
            areas: areas.collect(),
            ..Self::default()
        }
    }

    /// Cleans up the strokes of each part.
    ///
    /// Everything drawn afterwards is within `merge + simplify` of something drawn before, and vice
    /// versa. Artwork whose order must stay is only simplified.
    ///
    /// ```
    /// use magician_formats::artwork::Tidy;
    /// use magician_formats::{Artwork, Origin, Stroke};
    ///
    /// let line = |points: &[[f64; 2]]| Stroke::new(points.to_vec(), Origin::NONE);
    /// let mut drawing = Artwork::default();
    /// drawing.strokes = vec![
    ///     line(&[[0.0, 0.0], [10.0, 0.0]]),
    ///     line(&[[10.0, 0.05], [20.0, 0.05]]),
    ///     line(&[[10.0, 0.0], [0.0, 0.0]]),
    /// ];
    /// let tidied = drawing.tidy(&Tidy::default());
    /// assert_eq!((tidied.repeated, tidied.joined, drawing.strokes.len()), (1, 1, 1));
    /// ```
    pub fn tidy(&mut self, tidy: &Tidy) -> Tidied {
        self.tidy_to_draw(tidy, 1.0)
    }

    /// Cleans up strokes that are drawn `scale` times as large. The lengths in `tidy` count on
    /// paper.
    pub fn tidy_to_draw(&mut self, tidy: &Tidy, scale: f64) -> Tidied {
        let mut tidied = Tidied::default();
        if !self.strokes.iter().all(Stroke::is_finite) {
            return tidied;
        }
        let (dedupe, merge) = (
            tidy.dedupe && !self.in_order,
            tidy.merge > 0.0 && !self.in_order,
        );
        self.change_parts(|strokes| {
            if dedupe {
                let count = strokes.len();
                let mut known = HashSet::new();
                strokes.retain(|stroke| known.insert(shape(stroke, VERTEX_TOLERANCE / scale)));
                tidied.repeated += count - strokes.len();
            }
            if merge {
                tidied.joined += join::join(strokes, tidy.merge / scale);
            }
        });
        if tidy.simplify > 0.0 {
            for stroke in &mut self.strokes {
                stroke.points = simplified(&stroke.points, tidy.simplify / scale);
            }
        }
        tidied
    }
}

/// Returns a key that is equal for duplicates: independent of direction, and for closed strokes of
/// the start.
fn shape(stroke: &Stroke, same: f64) -> Vec<[i64; 2]> {
    let near = |point: &[f64; 2]| point.map(|value| (value / same).round() as i64);
    let mut corners: Vec<[i64; 2]> = stroke.points.iter().map(near).collect();
    if stroke.is_closed() {
        corners.pop();
        let forth = from_the_least(corners.clone());
        corners.reverse();
        let mut least = forth.min(from_the_least(corners));
        // Without the extra vertex, a closed stroke would equal the open one along its vertices.
        least.extend(least.first().copied());
        return least;
    }
    let back = corners.iter().rev().copied().collect();
    corners.min(back)
}

/// Rotates the vertices of a closed line to begin at the smallest.
pub(crate) fn from_the_least<T: Ord>(mut corners: Vec<T>) -> Vec<T> {
    let least = { corners.iter().enumerate() }.min_by_key(|(_, corner)| *corner);
    let at = least.map_or(0, |(at, _)| at);
    corners.rotate_left(at);
    corners
}
