//! A circle through three points, by the length gone along it.
//!
//! The place after a way is the start, plus `radius sin` along the tangent there, plus `radius (1 - cos)` towards
//! the centre. Both terms keep their digits however large the radius: nearly straight arcs lose nothing, and the
//! centre, which may be far away, is never asked for.

use crate::angle::{DEGREES_PER_RADIAN, atan2, sin_cos};
use crate::move_segment::SHORTEST_MOVE;
use crate::roots::quadratic;
use crate::{MotionError, Pose, Unreachable};

/// A circular arc in any plane; it begins at the first of three points and turns towards the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    start: [f64; 3],
    tangent: [f64; 3],
    inwards: [f64; 3],
    radius: f64,
    length: f64,
}

/// A point of the arc with its first and second derivative by the length of way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) at: [f64; 3],
    pub(crate) along: [f64; 3],
    pub(crate) bend: [f64; 3],
}

impl Arc {
    /// The arc from the first point through the second to the third; rotations do not matter.
    ///
    /// Two points nearer than the shortest move are the same to the arm, and so is a triangle flatter than that to a
    /// straight line.
    pub(crate) fn through(from: &Pose, via: &Pose, to: &Pose) -> Result<Self, MotionError> {
        let [start, middle, end] = [from, via, to].map(|pose| [pose.x, pose.y, pose.z]);
        if ![start, middle, end]
            .as_flattened()
            .iter()
            .all(|value| value.is_finite())
        {
            return Err(Unreachable::NotFinite.into());
        }
        let (first, whole) = (difference(middle, start), difference(end, start));
        let second = difference(end, middle);
        let sides = [first, second, whole].map(norm);
        if sides.iter().any(|side| *side < SHORTEST_MOVE) {
            return Err(MotionError::Coincident);
        }
        let normal = cross(first, whole);
        let doubled_area = norm(normal);
        let longest = sides.into_iter().fold(0.0, f64::max);
        let [first_side, second_side, chord] = sides;
        let radius = first_side * second_side * (chord / (2.0 * doubled_area));
        // Asked this way round, numbers too large to be multiplied are refused as well.
        if !(doubled_area >= SHORTEST_MOVE * longest && radius.is_finite()) {
            return Err(MotionError::Collinear);
        }
        // The angle by which the way turns at the middle point is half the sweep; the chord is turned by as much
        // against the tangent at the start.
        let straight_on = dot(first, second);
        let half_sweep = atan2(doubled_area, straight_on);
        let (sin, cos) = {
            let scale = 1.0 / (first_side * second_side);
            (doubled_area * scale, straight_on * scale)
        };
        let chord_direction = scaled(whole, 1.0 / chord);
        let left = cross(scaled(normal, 1.0 / doubled_area), chord_direction);
        Ok(Self {
            start,
            tangent: sum(scaled(chord_direction, cos), scaled(left, -sin)),
            inwards: sum(scaled(chord_direction, sin), scaled(left, cos)),
            radius,
            length: radius * (2.0 * half_sweep / DEGREES_PER_RADIAN),
        })
    }

    /// The way from the first point to the third.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// The way once round.
    pub(crate) fn turn(&self) -> f64 {
        self.radius * (360.0 / DEGREES_PER_RADIAN)
    }

    pub(crate) fn curvature(&self) -> f64 {
        1.0 / self.radius
    }

    /// No two points of a way of this length are further apart.
    pub(crate) fn widest(&self, way: f64) -> f64 {
        way.min(2.0 * self.radius)
    }

    pub(crate) fn place(&self, way: f64) -> Place {
        let turns = libm::floor(way / self.turn());
        let half = (way - turns * self.turn()) / self.radius * (0.5 * DEGREES_PER_RADIAN);
        let (sin_half, cos_half) = sin_cos(half);
        let (sin, bulge) = (2.0 * sin_half * cos_half, 2.0 * sin_half * sin_half);
        let cos = 1.0 - bulge;
        let mix = |ahead, aside| sum(scaled(self.tangent, ahead), scaled(self.inwards, aside));
        Place {
            at: sum(self.start, mix(self.radius * sin, self.radius * bulge)),
            along: mix(cos, sin),
            bend: mix(-sin / self.radius, cos / self.radius),
        }
    }

    /// Where the circle meets the plane of all points whose product with `normal` is `offset`: ways from the start,
    /// less than once round. The half angle's tangent is the root of a quadratic.
    pub(crate) fn plane_cuts(&self, normal: [f64; 3], offset: f64, report: &mut impl FnMut(f64)) {
        let height = dot(normal, self.start) - offset;
        let ahead = 2.0 * self.radius * dot(normal, self.tangent);
        let opposite = height + 2.0 * self.radius * dot(normal, self.inwards);
        for tangent in quadratic(opposite, ahead, height) {
            let half = atan2(tangent, 1.0);
            let degrees = if half < 0.0 {
                2.0 * half + 360.0
            } else {
                2.0 * half
            };
            report(self.radius * (degrees / DEGREES_PER_RADIAN));
        }
        if opposite == 0.0 {
            report(0.5 * self.turn());
        }
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ax - bx, ay - by, az - bz]
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ax + bx, ay + by, az + bz]
}

fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    a.map(|component| component * factor)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    ax * bx + ay * by + az * bz
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

fn norm(a: [f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}
