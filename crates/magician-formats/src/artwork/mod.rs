//! Artwork: polylines and filled areas on a sheet, before the arm is involved.
//!
//! A drawing goes through these steps, each in a module here: clean-up of duplicates (`tidy`),
//! division into parts (`parts`), filling ([`Artwork::fill`]), ordering for short travel (`order`),
//! placing in front of the arm (`place`), and conversion to a plan (`mark`).

mod clip;
mod mark;
mod order;
mod parts;
mod place;
mod tidy;

pub use mark::Marking;
pub use order::{Order, Saving};
#[cfg(feature = "drawings")]
pub(crate) use parts::index_or_push;
pub use parts::{DrawingPart, Layer, PartPen, Style};
pub use place::{FitFailure, rotated, rounded};
pub use place::{Layout, PlacedArtwork, Sheet, WouldFit};
pub(crate) use tidy::from_the_least;
pub use tidy::{Tidied, Tidy};

use crate::fill::{Area, Fill, FillMode};
use crate::formats::Curves;
use crate::{Color, Origin};

/// Polylines and areas on a sheet. Coordinates are the sheet's, mm: x to the right, y up, from its
/// lower left corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Artwork {
    /// Title.
    pub title: String,
    /// Width and height of the sheet, mm; `None` if the file has none.
    pub page: Option<[f64; 2]>,
    /// Strokes, in the order of the file.
    pub strokes: Vec<Stroke>,
    /// Filled areas in the order of painting. Empty unless [requested](crate::Fills::Areas).
    pub areas: Vec<FilledArea>,
    /// Names that origins refer to.
    pub names: Vec<String>,
    /// Layers, or pens of a plot, in the order of first appearance.
    pub layers: Vec<Layer>,
    /// Colours, in the order of first appearance.
    pub colors: Vec<Color>,
    /// Parts, once the artwork is divided. Parts that are left out have no strokes.
    pub parts: Vec<DrawingPart>,
    /// True if the order of the strokes must stay, as within a handwritten character.
    pub in_order: bool,
    /// The file behind flattened curves.
    pub curves: Curves,
}

/// A polyline drawn without a break. A single point is a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Vertices. A closed stroke repeats its first vertex at the end.
    pub points: Vec<[f64; 2]>,
    /// Place in the source file.
    pub origin: Origin,
    /// Layer, colour and part.
    pub style: Style,
}

/// A filled shape of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct FilledArea {
    /// Shape.
    pub area: Area,
    /// Place in the source file.
    pub origin: Origin,
    /// Layer, colour and part.
    pub style: Style,
}

impl Stroke {
    /// Creates a stroke without layer and colour.
    #[must_use]
    pub fn new(points: Vec<[f64; 2]>, origin: Origin) -> Self {
        Self {
            points,
            origin,
            style: Style::default(),
        }
    }

    /// True if all coordinates are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.points.iter().flatten().all(|value| value.is_finite())
    }

    /// True if the stroke is closed, so that it may begin at any vertex.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }

    /// Length, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().skip(1));
        pairs.map(|(from, to)| distance(*from, *to)).sum()
    }
}

impl Artwork {
    /// Returns the edge of a sheet of this size, mm, as one closed stroke, clockwise from its upper
    /// left corner.
    #[must_use]
    pub fn frame(page: [f64; 2]) -> Self {
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
                style: Style::default(),
            }],
            ..Self::default()
        }
    }

    /// Converts areas to the lines that fill them, drawn before all other strokes of their part.
    /// Areas of an unfilled part become their outlines.
    ///
    /// Returns the number of areas that are too small for any line.
    pub fn fill(&mut self, fill: &Fill) -> usize {
        let mut bare = 0;
        let mut strokes = Vec::new();
        for filled in std::mem::take(&mut self.areas) {
            let FilledArea {
                area,
                origin,
                style,
            } = filled;
            let part = (style.part as usize).checked_sub(1);
            let part = part.and_then(|at| self.parts.get(at));
            let mode = part.and_then(|part| part.pen.fill).unwrap_or(fill.mode);
            let lines = match mode {
                FillMode::None => area.rings.into_iter().map(closed).collect(),
                mode => Fill { mode, ..*fill }.lines(&area),
            };
            let before = strokes.len();
            strokes.extend(lines.into_iter().map(|points| Stroke {
                points,
                origin,
                style,
            }));
            bare += usize::from(strokes.len() == before);
        }
        strokes.append(&mut self.strokes);
        strokes.sort_by_key(|stroke| stroke.style.part);
        self.strokes = strokes;
        bare
    }

    /// Iterates over the vertices of strokes and areas.
    fn points(&self) -> impl Iterator<Item = &[f64; 2]> {
        let edges = self.areas.iter().flat_map(|filled| &filled.area.rings);
        let lines = self.strokes.iter().map(|stroke| &stroke.points);
        lines.chain(edges).flatten()
    }

    /// Bounding box of strokes and areas (smallest and largest corner), or `None` if there are
    /// none.
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

    /// Total length of the strokes, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.strokes.iter().map(Stroke::length).sum()
    }
}

/// Closes a ring by repeating its first vertex.
fn closed(mut ring: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if ring.first() != ring.last() {
        ring.extend(ring.first().copied());
    }
    ring
}

/// Returns the centre of the circle through three points, and the angle from the first through the
/// second to the third, degrees, positive counter-clockwise. `None` if they are collinear.
#[must_use]
pub fn circle_through(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<([f64; 2], f64)> {
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

/// Distance between two points.
#[must_use]
pub fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    libm::hypot(other[0] - one[0], other[1] - one[1])
}
