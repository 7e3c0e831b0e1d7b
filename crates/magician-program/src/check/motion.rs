//! Length and bounds of the motion of a command.

use std::f64::consts::{PI, TAU};

use magician_host::{ArmState, Set};

type Point = [f64; 3];

/// Position of the tool.
pub(super) fn point(arm: &ArmState) -> Point {
    [arm.pose.x, arm.pose.y, arm.pose.z]
}

/// Length of a command's motion, mm; joint moves and jumps count as straight.
pub(super) fn length(command: &Set, from: &ArmState, to: &ArmState) -> f64 {
    match Arc::of(command, from) {
        Some(arc) => arc.radius * arc.sweep,
        None => from.pose.distance_to(&to.pose),
    }
}

/// Points whose bounding box contains the whole motion of a command.
pub(super) fn corners(command: &Set, from: &ArmState, to: &ArmState) -> Vec<Point> {
    let mut corners = vec![point(from), point(to)];
    if let Some(arc) = Arc::of(command, from) {
        corners.extend(arc.extremes());
    }
    corners
}

/// Circle, and the angle that the motion covers, rad.
struct Arc {
    centre: Point,
    radius: f64,
    sweep: f64,
    /// Vectors from the centre to the first point, and to the point a quarter turn on.
    axes: [Point; 2],
}

impl Arc {
    /// Arc or circle of a command; `None` for other commands.
    fn of(command: &Set, from: &ArmState) -> Option<Self> {
        let xyz = |[x, y, z, _]: [f32; 4]| [x, y, z].map(f64::from);
        match command {
            Set::ArcCmd(arc) => Self::through(point(from), xyz(arc.cir_point), xyz(arc.to_point)),
            Set::CircleCmd(circle) => {
                let arc = Self::through(point(from), xyz(circle.cir_point), xyz(circle.to_point));
                arc.map(|arc| Self {
                    sweep: TAU * f64::from(circle.count),
                    ..arc
                })
            }
            _ => None,
        }
    }

    /// Arc from the first through the second to the third point; `None` if they are on a straight
    /// line.
    fn through(from: Point, via: Point, to: Point) -> Option<Self> {
        let (first, second) = (difference(from, via), difference(via, to));
        let normal = cross(first, second);
        // The directions of the two chords differ by half of the arc's angle (inscribed angle).
        let half_angle = libm::atan2(norm(normal), dot(first, second));
        let chord = difference(from, to);
        let radius = norm(chord) / (2.0 * libm::sin(half_angle));
        if half_angle <= 0.0 || !radius.is_finite() {
            return None;
        }
        let normal = scaled(normal, 1.0 / norm(normal));
        // The centre lies to the left of the chord's midpoint, or to the right if the arc is more
        // than half a turn: the cosine is then negative.
        let left = cross(normal, scaled(chord, 1.0 / norm(chord)));
        let middle = sum(from, scaled(chord, 0.5));
        let centre = sum(middle, scaled(left, radius * libm::cos(half_angle)));
        let start = difference(centre, from);
        Some(Self {
            centre,
            radius,
            sweep: 2.0 * half_angle,
            axes: [start, cross(normal, start)],
        })
    }

    /// Points of the arc with an extreme coordinate.
    fn extremes(&self) -> impl Iterator<Item = Point> {
        let [[ax, ay, az], [bx, by, bz]] = self.axes;
        let angles = [
            libm::atan2(bx, ax),
            libm::atan2(by, ay),
            libm::atan2(bz, az),
        ];
        let angles = angles.into_iter().flat_map(|angle| [angle, angle + PI]);
        let angles = angles.map(|angle| angle.rem_euclid(TAU));
        angles.filter(|angle| *angle <= self.sweep).map(|angle| {
            let [first, second] = self.axes;
            let (sin, cos) = libm::sincos(angle);
            sum(self.centre, sum(scaled(first, cos), scaled(second, sin)))
        })
    }
}

fn difference([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [x - a, y - b, z - c]
}

fn sum([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [a + x, b + y, c + z]
}

fn scaled(vector: Point, by: f64) -> Point {
    vector.map(|value| value * by)
}

fn dot([a, b, c]: Point, [x, y, z]: Point) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn norm(vector: Point) -> f64 {
    dot(vector, vector).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arc_length_is_radius_times_angle() {
        for degrees in [1.0f64, 45.0, 180.0, 270.0, 359.0] {
            // A tilted plane: two perpendicular directions, one of them rising.
            let at = |share: f64| {
                let (sin, cos) = libm::sincos(share * degrees.to_radians());
                [200.0 + 30.0 * cos, 24.0 * sin, 18.0 * sin]
            };
            let arc = Arc::through(at(0.0), at(0.3), at(1.0)).unwrap();
            let length = 30.0 * degrees.to_radians();
            assert!((arc.radius * arc.sweep - length).abs() < 1e-6, "{degrees}");
            for (found, centre) in arc.centre.into_iter().zip([200.0, 0.0, 0.0]) {
                assert!((found - centre).abs() < 1e-6, "{degrees} {:?}", arc.centre);
            }
            // Compare with the extremes of many sampled points.
            for axis in 0..3 {
                let all = (0..=3600).map(|nth| at(f64::from(nth) / 3600.0)[axis]);
                let (least, most) = all.fold((f64::MAX, f64::MIN), |(least, most), value| {
                    (least.min(value), most.max(value))
                });
                let ends = [at(0.0), at(1.0)];
                let found: Vec<f64> = (arc.extremes().chain(ends)).map(|at| at[axis]).collect();
                let extreme = found.iter().copied().fold(f64::MAX, f64::min);
                assert!((extreme - least).abs() < 1e-4, "{degrees} {axis}");
                let extreme = found.iter().copied().fold(f64::MIN, f64::max);
                assert!((extreme - most).abs() < 1e-4, "{degrees} {axis}");
            }
        }
        assert!(Arc::through([0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]).is_none());
        assert!(Arc::through([0.0; 3], [0.0; 3], [0.0; 3]).is_none());
    }
}
