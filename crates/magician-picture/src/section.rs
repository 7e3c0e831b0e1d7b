//! Reach of the arm in a plane through its base axis.
//!
//! Within the joint limits the arm has no singularity (model section 5). So the boundary of the
//! reach is the image of the boundary of the allowed joint angles, and tracing the latter is
//! enough.

use magician_host::{Geometry, JointAngles, Limits};
use magician_motion::ArmModel;

use crate::panel::Panel;
use crate::svg::palette::{REACH, REACH_EDGE};
use crate::svg::{Svg, path};

/// Largest step along a limit, degrees.
const MAX_STEP: f64 = 2.0;

/// Returns the boundary of the reach in a plane through the base axis, as distance of the tool from
/// the axis and z, mm.
pub(super) fn section(arm: &Geometry, limits: &Limits) -> Vec<[f64; 2]> {
    let corners = allowed_j2_j3(limits);
    let next = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(next);
    edges.flat_map(|(from, to)| edge(arm, *from, *to)).collect()
}

/// Draws the section in a view from the side.
pub(super) fn draw(svg: &mut Svg, panel: &Panel, arm: &Geometry) {
    let edge = section(arm, &ArmModel::MAGICIAN.certain).into_iter();
    let look = [
        ("fill", REACH),
        ("stroke", REACH_EDGE),
        ("stroke-width", "0.3"),
    ];
    svg.path(&path(edge.map(|point| panel.at(point)), true), &look);
}

/// Outline of the reach over all heights, seen from above: between the smallest and the largest
/// radius of the section, over the range of J1.
pub(super) fn sector(arm: &Geometry, limits: &Limits) -> Vec<[f64; 2]> {
    let radii = section(arm, limits).into_iter().map(|[radius, _]| radius);
    let [near, far] = radii.fold([f64::MAX, 0.0_f64], |[near, far], radius| {
        [near.min(radius), far.max(radius)]
    });
    let steps = ((limits.j1.max - limits.j1.min) / MAX_STEP).ceil().max(1.0) as u32;
    let on = |radius: f64, step: u32| {
        let share = f64::from(step) / f64::from(steps);
        let j1 = limits.j1.min + (limits.j1.max - limits.j1.min) * share;
        let (sin, cos) = libm::sincos(j1.to_radians());
        [radius * cos, radius * sin]
    };
    let outer = (0..=steps).map(|step| on(far, step));
    outer
        .chain((0..=steps).rev().map(|step| on(near, step)))
        .collect()
}

/// Allowed pairs of J2 and J3 as a convex polygon: both ranges, clipped by the range of their
/// difference.
fn allowed_j2_j3(limits: &Limits) -> Vec<[f64; 2]> {
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

/// Clips a convex polygon to the half-plane where `inside` is not negative.
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
    let steps = (length / MAX_STEP).ceil().max(1.0) as u32;
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

    /// Figures of model section 5.
    #[test]
    fn section_has_the_known_extent() {
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

    #[test]
    fn sector_spans_the_radius_range_over_the_range_of_j1() {
        let limits = ArmModel::MAGICIAN.certain;
        let sector = sector(&Geometry::magician(ToolBias::NONE), &limits);
        let radii = sector.iter().map(|[x, y]| libm::hypot(*x, *y));
        let [near, far] = radii.fold([f64::MAX, 0.0_f64], |[near, far], radius| {
            [near.min(radius), far.max(radius)]
        });
        assert!(
            (near - 46.2).abs() < 0.1 && (far - 269.0).abs() < 0.1,
            "{near} {far}"
        );
        let ends = [0, sector.len() / 2 - 1].map(|at| sector[at]);
        let turned = ends.map(|[x, y]| libm::atan2(y, x).to_degrees());
        assert!((turned[0] - limits.j1.min).abs() < 1e-9);
        assert!((turned[1] - limits.j1.max).abs() < 1e-9);
    }
}
