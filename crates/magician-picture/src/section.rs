//! What the arm reaches in a plane through its base axis: the edge of what its joint limits allow, as positions.
//!
//! Within the limits the arm has no singularity (model section 5), so the edge of the one is the edge of the other.

use magician_host::{Geometry, JointAngles, Limits};

/// Largest step along a limit, degrees.
const STEP: f64 = 2.0;

/// What the arm reaches in a plane through the axis of its base: the edge of it, all round, as distance of the tool from the axis
/// and z, mm.
#[must_use]
pub fn section(arm: &Geometry, limits: &Limits) -> Vec<[f64; 2]> {
    let corners = allowed(limits);
    let next = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(next);
    edges.flat_map(|(from, to)| edge(arm, *from, *to)).collect()
}

/// The allowed pairs of J2 and J3, a convex polygon: the two ranges, cut by that of their difference.
fn allowed(limits: &Limits) -> Vec<[f64; 2]> {
    let (j2, j3, both) = (limits.j2, limits.j3, limits.j2_minus_j3);
    let all = vec![
        [j2.min, j3.min],
        [j2.max, j3.min],
        [j2.max, j3.max],
        [j2.min, j3.max],
    ];
    let below = clipped(&all, |[j2, j3]| both.max - (j2 - j3));
    clipped(&below, |[j2, j3]| (j2 - j3) - both.min)
}

/// The part of a convex polygon where `inside` is not negative.
fn clipped(polygon: &[[f64; 2]], inside: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    let next = polygon.iter().cycle().skip(1);
    for (a, b) in polygon.iter().zip(next) {
        let (from, to) = (inside(*a), inside(*b));
        if from >= 0.0 {
            kept.push(*a);
        }
        if (from < 0.0) != (to < 0.0) {
            let share = from / (from - to);
            kept.push([0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * share));
        }
    }
    kept
}

fn edge(arm: &Geometry, a: [f64; 2], b: [f64; 2]) -> Vec<[f64; 2]> {
    let length = (b[0] - a[0]).abs().max((b[1] - a[1]).abs());
    let steps = (length / STEP).ceil().max(1.0) as u32;
    let at = |step: u32| {
        let share = f64::from(step) / f64::from(steps);
        let [j2, j3] = [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * share);
        let pose = arm.forward(&JointAngles::new(0.0, j2, j3, 0.0));
        [libm::hypot(pose.x, pose.y), pose.z]
    };
    (0..steps).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_host::ToolBias;
    use magician_motion::ArmModel;

    /// Figures of model section 5.
    #[test]
    fn the_section_has_the_known_extent() {
        let section = section(
            &Geometry::magician(ToolBias::NONE),
            &ArmModel::MAGICIAN.certain,
        );
        let extent = |axis: usize| {
            let values = section.iter().map(|point| point[axis]);
            values.fold((f64::MAX, f64::MIN), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        let ((near, far), (low, high)) = (extent(0), extent(1));
        for (found, known) in [(near, 46.2), (far, 269.0), (low, -147.0), (high, 173.0)] {
            assert!((found - known).abs() < 0.1, "{found} is not {known}");
        }
    }
}
