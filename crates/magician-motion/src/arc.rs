//! A circle through three points, parametrised by the length along it.
//!
//! The position is the start plus `radius sin` along its tangent plus `radius (1 - cos)` towards
//! the centre. Both terms keep their digits for any radius, so nearly straight arcs lose no
//! precision. The centre, which may be far away, is never computed.

use crate::angle::{DEGREES_PER_RADIAN, atan2, sin_cos};
use crate::move_segment::SHORTEST_MOVE;
use crate::roots::quadratic;
use crate::{MotionError, Pose, Unreachable};

/// A circular arc in any plane. It begins at the first of three points and turns towards the
/// second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    start: [f64; 3],
    tangent: [f64; 3],
    inwards: [f64; 3],
    radius: f64,
    length: f64,
}

/// A point of the arc, with the first and second derivative by arc length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcPoint {
    pub(crate) at: [f64; 3],
    pub(crate) along: [f64; 3],
    pub(crate) bend: [f64; 3],
}

impl Arc {
    /// Computes the arc from the first point through the second to the third; rotations are
    /// ignored.
    ///
    /// Points closer than the shortest move coincide for the arm. A triangle flatter than that is a
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
        // The negated form also refuses values that overflow to infinity or NaN.
        if !(doubled_area >= SHORTEST_MOVE * longest && radius.is_finite()) {
            return Err(MotionError::Collinear);
        }
        // The polyline from start over middle to end turns by half of the sweep. The chord makes
        // the same angle with the tangent at the start.
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

    /// Length from the first point to the third.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Length of a full circle.
    pub(crate) fn circumference(&self) -> f64 {
        self.radius * (360.0 / DEGREES_PER_RADIAN)
    }

    pub(crate) fn curvature(&self) -> f64 {
        1.0 / self.radius
    }

    /// Greatest distance between two points on an arc of this length.
    pub(crate) fn max_chord(&self, length: f64) -> f64 {
        length.min(2.0 * self.radius)
    }

    pub(crate) fn point_at(&self, length: f64) -> ArcPoint {
        let turns = libm::floor(length / self.circumference());
        let half =
            (length - turns * self.circumference()) / self.radius * (0.5 * DEGREES_PER_RADIAN);
        let (sin_half, cos_half) = sin_cos(half);
        let (sin, bulge) = (2.0 * sin_half * cos_half, 2.0 * sin_half * sin_half);
        let cos = 1.0 - bulge;
        let mix = |ahead, aside| sum(scaled(self.tangent, ahead), scaled(self.inwards, aside));
        ArcPoint {
            at: sum(self.start, mix(self.radius * sin, self.radius * bulge)),
            along: mix(cos, sin),
            bend: mix(-sin / self.radius, cos / self.radius),
        }
    }

    /// Reports the arc lengths from the start, within one full circle, at which the circle meets
    /// the plane `normal * x = offset`.
    ///
    /// The tangent of the half angle is the root of a quadratic.
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
        // The half angle is 90 degrees and its tangent infinite, so the quadratic misses this root.
        if opposite == 0.0 {
            report(0.5 * self.circumference());
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
