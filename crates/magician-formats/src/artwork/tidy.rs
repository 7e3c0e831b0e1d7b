//! Lines of drawings tidied: ends that nearly meet are joined, lines that are there twice are drawn once, points that say nothing are
//! left out.

use std::collections::HashSet;

use super::order::join;
use super::{Artwork, Stroke};
use crate::FilledArea;
use crate::fill::Area;
use crate::simplify::simplified;

/// Corners of two lines no farther apart than about this are the same, mm.
const SAME: f64 = 1e-4;

/// How the lines of a drawing are tidied before they are put in order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Tidy {
    /// Ends that are no farther apart are joined, mm; none are with 0.
    pub merge: f64,
    /// Whether a line that is there twice is drawn once, wherever it begins and whichever way it goes.
    pub dedupe: bool,
    /// Points that are no farther from the line without them are left out, mm; none are with 0.
    pub simplify: f64,
}

impl Default for Tidy {
    /// Joined within 0.1 mm, once if it is there twice, thinned within 0.02 mm.
    fn default() -> Self {
        Self {
            merge: 0.1,
            dedupe: true,
            simplify: 0.02,
        }
    }
}

/// What tidying has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Tidied {
    /// How many lines were there before and are not drawn again.
    pub repeated: usize,
    /// How many lines go on from another one now.
    pub joined: usize,
}

impl Artwork {
    /// Its lines and areas with as few points as this distance, mm, allows, and its page; nothing else of it.
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

    /// Tidies its lines, those of each part by themselves. None of what is drawn then is farther from what was drawn before than `merge` and `simplify` together, nor
    /// the other way round. Strokes whose order has a meaning are thinned alone.
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

    /// Tidies lines that are drawn `scale` times as large: lengths count on the paper.
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
                strokes.retain(|stroke| known.insert(shape(stroke, SAME / scale)));
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

/// The same for lines of the same corners, whichever way they go; for closed ones wherever they begin.
fn shape(stroke: &Stroke, same: f64) -> Vec<[i64; 2]> {
    let near = |point: &[f64; 2]| point.map(|value| (value / same).round() as i64);
    let mut corners: Vec<[i64; 2]> = stroke.points.iter().map(near).collect();
    if stroke.is_closed() {
        corners.pop();
        let forth = from_the_least(corners.clone());
        corners.reverse();
        let mut least = forth.min(from_the_least(corners));
        // A closed line is another than the open one of its corners.
        least.extend(least.first().copied());
        return least;
    }
    let back = corners.iter().rev().copied().collect();
    corners.min(back)
}

/// The corners of a closed line, beginning at the least of them.
pub(crate) fn from_the_least<T: Ord>(mut corners: Vec<T>) -> Vec<T> {
    let least = { corners.iter().enumerate() }.min_by_key(|(_, corner)| *corner);
    let at = least.map_or(0, |(at, _)| at);
    corners.rotate_left(at);
    corners
}
