//! Flattening of circular and elliptic arcs.

use kurbo::{Affine, Point, Vec2};

use crate::formats::Chords;

/// Largest number of chords per curve. It bounds memory for huge radii.
const MAX_PIECES: f64 = 100_000.0;

/// An elliptic arc `centre + cos t * one + sin t * other`; t starts at `from` and covers `sweep`,
/// radians.
pub(super) struct Ellipse {
    pub(super) centre: Point,
    pub(super) one: Vec2,
    pub(super) other: Vec2,
    pub(super) from: f64,
    pub(super) sweep: f64,
}

impl Ellipse {
    /// Creates a circular arc, counter-clockwise, after a transform.
    pub(super) fn circle(map: &Affine, centre: Point, radius: f64, from: f64, sweep: f64) -> Self {
        let whole = *map * centre;
        Self {
            centre: whole,
            one: *map * (centre + Vec2::new(radius, 0.0)) - whole,
            other: *map * (centre + Vec2::new(0.0, radius)) - whole,
            from,
            sweep,
        }
    }

    fn at(&self, t: f64) -> Point {
        self.centre + self.one * libm::cos(t) + self.other * libm::sin(t)
    }

    /// Length of the longer semi-axis.
    fn radius(&self) -> f64 {
        let (one, other) = (self.one.hypot2(), self.other.hypot2());
        let half = (one - other) / 2.0;
        ((one + other) / 2.0 + libm::hypot(half, self.one.dot(self.other))).sqrt()
    }

    /// Returns points along the arc, including both ends, so that chords stay within the tolerance.
    /// A full ellipse ends exactly where it begins.
    pub(super) fn points(&self, chords: &Chords) -> Vec<Point> {
        let tolerance = chords.for_curve();
        // On a circle a chord over an angle a deviates by r (1 - cos(a / 2)). An ellipse is a
        // squeezed circle, so the bound holds with its longer semi-axis.
        let step = 4.0 * libm::asin((tolerance / (2.0 * self.radius())).sqrt().min(0.19));
        let pieces = (self.sweep.abs() / step).ceil().clamp(1.0, MAX_PIECES);
        let mut points: Vec<Point> = (0..=pieces as u32)
            .map(|nth| self.at(self.from + self.sweep * f64::from(nth) / pieces))
            .collect();
        if self.sweep.abs() >= std::f64::consts::TAU
            && let (Some(first), Some(last)) = (points.first().copied(), points.last_mut())
        {
            *last = first;
        }
        points
    }
}

/// Normalises the sweep between two angles to above 0 and up to 2 pi; equal angles are a full turn.
pub(super) fn sweep(from: f64, to: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let sweep = (to - from).rem_euclid(turn);
    // Ends meant to be equal may differ by rounding.
    if sweep < 1e-9 || turn - sweep < 1e-9 {
        turn
    } else {
        sweep
    }
}

/// Adds a segment of a polyline except its first point: straight, or an arc. The bulge is the
/// tangent of a quarter of the arc's angle, positive to the left.
pub(super) fn bulge(
    points: &mut Vec<Point>,
    map: &Affine,
    [from, to]: [Point; 2],
    bulge: f64,
    chords: &Chords,
) {
    let chord = to - from;
    if bulge != 0.0 && from != to {
        let left = Vec2::new(-chord.y, chord.x);
        let centre = from.midpoint(to) + left * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let spoke = from - centre;
        let middle = *map * centre;
        let arc = Ellipse {
            centre: middle,
            one: *map * from - middle,
            other: *map * (centre + Vec2::new(-spoke.y, spoke.x)) - middle,
            from: 0.0,
            sweep: 4.0 * libm::atan(bulge),
        };
        let inner = arc.points(chords);
        let count = inner.len().saturating_sub(2);
        points.extend(inner.into_iter().skip(1).take(count));
    }
    points.push(*map * to);
}
