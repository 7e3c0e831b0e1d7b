//! Distance from a place to the nearest one within reach.
//!
//! The search goes outwards in circles of 1 mm steps: the reach has no simple shape, but testing
//! one place is cheap.

use std::f64::consts::TAU;

use magician_host::Geometry;
use magician_motion::Limits;

/// Farthest place whose distance is searched, mm. Bounds the work for absurd coordinates.
const MAX_DISTANCE: f64 = 1e6;
/// Margin on the sum of link lengths and tool, mm, for rounding.
const LENGTH_MARGIN: f64 = 1.0;
/// Number of directions searched around the place.
const DIRECTIONS: u32 = 240;

/// Distance at the same height to the nearest place in reach, rounded up to mm; `None` if the place
/// is in reach, or nothing in reach is near.
pub(super) fn beyond(geometry: &Geometry, limits: &Limits, [x, y, z]: [f64; 3]) -> Option<f64> {
    if geometry.reaches([x, y, z], limits) {
        return None;
    }
    let tool = geometry.tool;
    let longest = geometry.rear_arm + geometry.forearm + tool.x.abs() + tool.y.abs();
    let nearest = (libm::hypot(x, y) - longest - LENGTH_MARGIN).max(0.0);
    // Also keeps the loop below finite: it advances by 1 mm, which is lost on huge numbers.
    if nearest.is_nan() || nearest >= MAX_DISTANCE {
        return None;
    }
    // Begin at the outer circle of the arm, because no nearer point can be in reach.
    let mut distance = nearest.floor() + 1.0;
    while distance <= nearest + 2.0 * longest {
        let mut ring = (0..DIRECTIONS).map(|nth| {
            let (sin, cos) = libm::sincos(TAU * f64::from(nth) / f64::from(DIRECTIONS));
            [x + distance * cos, y + distance * sin, z]
        });
        if ring.any(|place| geometry.reaches(place, limits)) {
            return Some(distance);
        }
        distance += 1.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use magician_host::ToolBias;

    use super::*;

    const LIMITS: Limits = magician_motion::ArmModel::MAGICIAN.limits;

    #[test]
    fn distance_is_to_the_nearest_reachable_position() {
        let arm = Geometry::magician(ToolBias::PEN);
        let edge = |heading: f64| {
            let (sin, cos) = libm::sincos(heading.to_radians());
            let mut radius = 250.0;
            while arm.reaches([radius * cos, radius * sin, -40.0], &LIMITS) {
                radius += 0.01;
            }
            radius
        };
        for heading in [0.0, 40.0, -90.0, 130.0] {
            let (sin, cos) = libm::sincos(f64::to_radians(heading));
            let far = edge(heading) + 117.4;
            assert_eq!(
                beyond(&arm, &LIMITS, [far * cos, far * sin, -40.0]),
                Some(118.0)
            );
        }
        assert_eq!(beyond(&arm, &LIMITS, [240.0, 0.0, -40.0]), None);
        // Behind the base the nearest place is at its side.
        let behind = beyond(&arm, &LIMITS, [-200.0, 0.0, -40.0]).unwrap();
        assert!((141.0..=142.0).contains(&behind), "{behind}");
        assert_eq!(beyond(&arm, &LIMITS, [240.0, 0.0, 900.0]), None);
        assert_eq!(beyond(&arm, &LIMITS, [f64::NAN, 0.0, 0.0]), None);
        assert_eq!(beyond(&arm, &LIMITS, [1e30, 0.0, 0.0]), None);
    }
}
