//! How long ways are.

use std::f64::consts::TAU;

use magician::{ArmState, Set};

type Point = [f64; 3];

/// How long the way of a command is, mm; that of joints and of a jump as if it were straight.
pub(super) fn length(command: &Set, from: &ArmState, to: &ArmState) -> f64 {
    let start = [from.pose.x, from.pose.y, from.pose.z];
    let point = |[x, y, z, _]: [f32; 4]| [x, y, z].map(f64::from);
    let round = match command {
        Set::ArcCmd(arc) => {
            let arc = Arc::through(start, point(arc.cir_point), point(arc.to_point));
            arc.map(|arc| arc.radius * arc.sweep)
        }
        Set::CircleCmd(circle) => {
            let arc = Arc::through(start, point(circle.cir_point), point(circle.to_point));
            arc.map(|arc| arc.radius * TAU * f64::from(circle.count))
        }
        _ => None,
    };
    round.unwrap_or_else(|| from.pose.distance_to(&to.pose))
}

/// A circle, and how far round it three points go, rad.
struct Arc {
    radius: f64,
    sweep: f64,
}

impl Arc {
    /// From the first through the second to the third; nothing for points on a straight line.
    fn through(from: Point, via: Point, to: Point) -> Option<Self> {
        let (first, second) = (way(from, via), way(via, to));
        // At the second point the way has turned by half of what it turns in all.
        let half = norm(cross(first, second)).atan2(dot(first, second));
        let radius = norm(way(from, to)) / (2.0 * half.sin());
        (half > 0.0 && radius.is_finite()).then_some(Self {
            radius,
            sweep: 2.0 * half,
        })
    }
}

fn way([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [x - a, y - b, z - c]
}

fn dot([a, b, c]: Point, [x, y, z]: Point) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn norm(way: Point) -> f64 {
    dot(way, way).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_are_as_long_as_they_are() {
        for degrees in [1.0f64, 45.0, 180.0, 270.0, 359.0] {
            // On a slant: two directions at right angles, one of them up and across.
            let at = |share: f64| {
                let (sin, cos) = (share * degrees.to_radians()).sin_cos();
                [200.0 + 30.0 * cos, 24.0 * sin, 18.0 * sin]
            };
            let arc = Arc::through(at(0.0), at(0.3), at(1.0)).unwrap();
            let length = 30.0 * degrees.to_radians();
            assert!((arc.radius * arc.sweep - length).abs() < 1e-6, "{degrees}");
        }
        assert!(Arc::through([0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]).is_none());
        assert!(Arc::through([0.0; 3], [0.0; 3], [0.0; 3]).is_none());
    }
}
