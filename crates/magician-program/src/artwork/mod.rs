//! Lines on a sheet, wherever they came from, and how they become what the arm does.

mod clip;
mod mark;
mod order;
mod place;
mod tidy;

pub use mark::Marking;
pub use order::{Order, Saving};
pub(crate) use place::{FitFailure, rotated, rounded};
pub use place::{Layout, PlacedArtwork, Sheet, WouldFit};
pub use tidy::{Tidied, Tidy};

use crate::Origin;
use crate::fill::{Area, Fill};

/// Lines on a sheet. Coordinates are those of the sheet, mm: x to the right, y up, from its lower left corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Artwork {
    /// What it is called.
    pub title: String,
    /// Width and height of the sheet, where the file says so, mm.
    pub page: Option<[f64; 2]>,
    /// The lines, in the order of the file.
    pub strokes: Vec<Stroke>,
    /// What is filled, in the order in which it is painted; only where it was [asked for](crate::Fills::Areas).
    pub areas: Vec<FilledArea>,
    /// Names that origins refer to.
    pub names: Vec<String>,
    /// Whether the lines are drawn in this order, because it has a meaning: that of the strokes of a character.
    pub in_order: bool,
}

/// One line without a break; one of a single point is a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Its corners; a closed one ends where it begins, with the same point.
    pub points: Vec<[f64; 2]>,
    /// Where it came from.
    pub origin: Origin,
}

/// A filled shape of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledArea {
    /// Its shape.
    pub area: Area,
    /// Where it came from.
    pub origin: Origin,
}

impl Stroke {
    /// Whether all of its corners are somewhere.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.points.iter().flatten().all(|value| value.is_finite())
    }

    /// Whether it ends where it begins, so that it may begin anywhere.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }

    /// How long it is, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().skip(1));
        pairs.map(|(from, to)| distance(*from, *to)).sum()
    }
}

impl Artwork {
    /// The edge of a sheet of this size, from its upper left corner clockwise.
    pub(crate) fn frame(page: [f64; 2]) -> Self {
        let [width, height] = page;
        let corners = [
            [0.0, height],
            [width, height],
            [width, 0.0],
            [0.0, 0.0],
            [0.0, height],
        ];
        Self {
            page: Some(page),
            strokes: vec![Stroke {
                points: corners.to_vec(),
                origin: Origin::NONE,
            }],
            ..Self::default()
        }
    }

    /// Its areas as the lines that fill them, drawn before all others; how many of them are too small for any line.
    pub(crate) fn fill(&mut self, fill: &Fill) -> usize {
        let mut bare = 0;
        let mut strokes = Vec::new();
        for FilledArea { area, origin } in std::mem::take(&mut self.areas) {
            let lines = fill.lines(&area).into_iter();
            let before = strokes.len();
            strokes.extend(lines.map(|points| Stroke { points, origin }));
            bare += usize::from(strokes.len() == before);
        }
        strokes.append(&mut self.strokes);
        self.strokes = strokes;
        bare
    }

    /// The points of its lines, and of the edges of its areas.
    fn points(&self) -> impl Iterator<Item = &[f64; 2]> {
        let edges = self.areas.iter().flat_map(|filled| &filled.area.rings);
        let lines = self.strokes.iter().map(|stroke| &stroke.points);
        lines.chain(edges).flatten()
    }

    /// The least and the greatest corner of its lines and areas.
    #[must_use]
    pub fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let mut points = self.points();
        let first = *points.next()?;
        Some(points.fold([first, first], |[least, most], [x, y]| {
            [
                [least[0].min(*x), least[1].min(*y)],
                [most[0].max(*x), most[1].max(*y)],
            ]
        }))
    }

    /// How long its lines are together, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.strokes.iter().map(Stroke::length).sum()
    }
}

/// The centre of the circle through three points, and by how many degrees it goes round from the first through the second to the
/// third, counter-clockwise above 0. None for points on a line.
pub(crate) fn circle_through(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<([f64; 2], f64)> {
    let [b, c] = [b, c].map(|point| [point[0] - a[0], point[1] - a[1]]);
    let turn = 2.0 * (b[0] * c[1] - b[1] * c[0]);
    let [to_b, to_c] = [b, c].map(|[x, y]| x * x + y * y);
    let centre = [
        (c[1] * to_b - b[1] * to_c) / turn,
        (b[0] * to_c - c[0] * to_b) / turn,
    ];
    if !centre.iter().all(|side| side.is_finite()) {
        return None;
    }
    let angle = |[x, y]: [f64; 2]| libm::atan2(y - centre[1], x - centre[0]).to_degrees();
    let round = (angle(c) - angle([0.0; 2])).rem_euclid(360.0);
    let sweep = if turn > 0.0 { round } else { round - 360.0 };
    Some(([a[0] + centre[0], a[1] + centre[1]], sweep))
}

/// Between two points.
pub(crate) fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    libm::hypot(other[0] - one[0], other[1] - one[1])
}
