//! The edge of where the arm can be: its joint limits, followed round and turned into positions.
//!
//! Inside the limits the arm has no singularity (model section 5), so the edge of the allowed
//! joint angles is the edge of the reach.

use magician_motion::{Geometry, JointAngles, Limits};

/// Largest step along a limit, degrees.
const STEP: f64 = 2.0;

/// The section of the reach in a plane through the base axis: radius and z of the tool, all round.
pub(super) fn section(arm: &Geometry, limits: &Limits) -> Vec<(f64, f64)> {
    let corners = allowed(limits);
    let next = corners.iter().cycle().skip(1);
    corners
        .iter()
        .zip(next)
        .flat_map(|(a, b)| edge(arm, *a, *b))
        .collect()
}

/// The allowed pairs of J2 and J3, a convex polygon: the two ranges, cut by the coupled one.
fn allowed(limits: &Limits) -> Vec<(f64, f64)> {
    let (j2, j3, both) = (limits.j2, limits.j3, limits.j2_minus_j3);
    let square = vec![
        (j2.min, j3.min),
        (j2.max, j3.min),
        (j2.max, j3.max),
        (j2.min, j3.max),
    ];
    let below = clip(&square, |(a, b)| both.max - (a - b));
    clip(&below, |(a, b)| (a - b) - both.min)
}

/// The part of a convex polygon where `inside` is not negative.
fn clip(polygon: &[(f64, f64)], inside: impl Fn((f64, f64)) -> f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let next = polygon.iter().cycle().skip(1);
    for (a, b) in polygon.iter().zip(next) {
        let (from, to) = (inside(*a), inside(*b));
        if from >= 0.0 {
            kept.push(*a);
        }
        if (from < 0.0) != (to < 0.0) {
            let share = from / (from - to);
            kept.push((a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share));
        }
    }
    kept
}

fn edge(arm: &Geometry, a: (f64, f64), b: (f64, f64)) -> Vec<(f64, f64)> {
    let length = (b.0 - a.0).abs().max((b.1 - a.1).abs());
    let steps = (length / STEP).ceil().max(1.0) as u32;
    let at = |step: u32| {
        let share = f64::from(step) / f64::from(steps);
        let (j2, j3) = (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share);
        let pose = arm.forward(&JointAngles::new(0.0, j2, j3, 0.0));
        (pose.x.hypot(pose.y), pose.z)
    };
    (0..steps).map(at).collect()
}

/// Smallest and largest radius at a height, `None` where the arm cannot be.
pub(super) fn radii_at(section: &[(f64, f64)], z: f64) -> Option<(f64, f64)> {
    let next = section.iter().cycle().skip(1);
    let crossings = section
        .iter()
        .zip(next)
        .filter(|(a, b)| (a.1 < z) != (b.1 < z));
    let radii = crossings.map(|(a, b)| a.0 + (b.0 - a.0) * (z - a.1) / (b.1 - a.1));
    radii.fold(None, |range: Option<(f64, f64)>, radius| match range {
        None => Some((radius, radius)),
        Some((low, high)) => Some((low.min(radius), high.max(radius))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_motion::ToolBias;

    fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
        values.fold((f64::MAX, f64::MIN), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    }

    /// Figures of model section 5.
    #[test]
    fn the_section_has_the_known_extent() {
        let arm = Geometry::magician(ToolBias::NONE);
        let section = section(&arm, &Limits::CONTROLLER);
        let (near, far) = range(section.iter().map(|point| point.0));
        let (low, high) = range(section.iter().map(|point| point.1));
        for (found, known) in [(near, 46.2), (far, 269.0), (low, -147.0), (high, 173.0)] {
            assert!((found - known).abs() < 0.1, "{found} is not {known}");
        }
    }

    #[test]
    fn a_height_beyond_the_section_has_no_radii() {
        let section = section(&Geometry::magician(ToolBias::SUCTION), &Limits::CONTROLLER);
        assert!(radii_at(&section, 0.0).is_some());
        assert_eq!(radii_at(&section, 500.0), None);
    }
}
