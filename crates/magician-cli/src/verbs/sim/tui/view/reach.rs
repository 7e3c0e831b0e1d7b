//! Area that the tool can reach.

use magician_motion::{Geometry, JointAngles, Limits, Range, ToolBias};

use crate::verbs::sim::tui::arm_view::Figure;

/// Samples of a curve.
const SAMPLES: u32 = 48;

/// Returns the smallest and largest distance from the base's axis that the tool can reach at a
/// height, mm; `None` if it reaches none.
pub(super) fn ring(z: f64, tool: ToolBias, limits: &Limits) -> Option<[f64; 2]> {
    let Geometry {
        rear_arm, forearm, ..
    } = Geometry::magician(tool);
    let steps = SAMPLES * 4;
    let along = |range: Range| {
        let part = move |step: u32| f64::from(step) / f64::from(steps);
        (0..=steps).map(move |step| range.min + (range.max - range.min) * part(step))
    };
    // Each joint follows from the other; both are sampled, because where one hardly turns the other
    // does.
    let by_rear_arm = along(limits.j2).map(|j2| {
        let down = (rear_arm * j2.to_radians().cos() - tool.z - z) / forearm;
        (j2, down.asin().to_degrees())
    });
    let by_forearm = along(limits.j3).flat_map(|j3| {
        let up = (z + tool.z + forearm * j3.to_radians().sin()) / rear_arm;
        let j2 = up.acos().to_degrees();
        [(j2, j3), (-j2, j3)]
    });
    let mut ring: Option<[f64; 2]> = None;
    for (j2, j3) in by_rear_arm.chain(by_forearm) {
        let joints = JointAngles::new(0.0, j2, j3, 0.0);
        if !joints.is_finite() || limits.check(&joints).is_err() {
            continue;
        }
        let r = Figure::of(&joints, tool, 0.0).tip[0];
        ring = Some(ring.map_or([r, r], |[near, far]| [near.min(r), far.max(r)]));
    }
    ring
}

/// Returns the outline of the reachable area from the side, as r, z.
pub(super) fn outline(tool: ToolBias, limits: &Limits) -> Vec<[f64; 2]> {
    let (j2, j3, gap) = (limits.j2, limits.j3, limits.j2_minus_j3);
    let at = |j2: f64, j3: f64| Figure::of(&JointAngles::new(0.0, j2, j3, 0.0), tool, 0.0).tip;
    let along = |step: u32| j2.min + (j2.max - j2.min) * f64::from(step) / f64::from(SAMPLES);
    let low = |j2: f64| at(j2, j3.min.max(j2 - gap.max));
    let high = |j2: f64| at(j2, j3.max.min(j2 - gap.min));
    let there = (0..=SAMPLES).map(|step| low(along(step)));
    let back = (0..=SAMPLES).rev().map(|step| high(along(step)));
    let ends = [j2.max, j2.min].map(|end| {
        let from = j3.min.max(end - gap.max);
        let to = j3.max.min(end - gap.min);
        let part = |step: u32| from + (to - from) * f64::from(step) / f64::from(SAMPLES);
        (0..=SAMPLES)
            .map(|step| at(end, part(step)))
            .collect::<Vec<_>>()
    });
    let [far, near] = ends;
    there
        .chain(far)
        .chain(back)
        .chain(near.into_iter().rev())
        .collect()
}

#[cfg(test)]
mod tests {
    use magician_motion::ArmModel;
    use magician_motion::Pose;

    use super::*;

    #[test]
    fn ring_contains_exactly_the_reachable_distances() {
        let (tool, limits) = (ToolBias::SUCTION, ArmModel::MAGICIAN.certain);
        let reaches = |r: f64, z: f64| {
            let there = Pose::new(r, 0.0, z, 0.0);
            let arm = Geometry::magician(tool);
            arm.inverse_within(&there, &limits).is_ok()
        };
        for z in [-100.0, -50.0, 0.0, 50.0, 120.0] {
            let [near, far] = ring(z, tool, &limits).unwrap();
            assert!(reaches(near + 0.1, z) && reaches(far - 0.1, z), "{z}");
            // The tolerance is that of the sampling.
            assert!(!reaches(near - 3.0, z) && !reaches(far + 3.0, z), "{z}");
        }
        assert_eq!(ring(400.0, tool, &limits), None);
    }

    #[test]
    fn outline_is_closed_and_reachable() {
        let limits = ArmModel::MAGICIAN.certain;
        let outline = outline(ToolBias::NONE, &limits);
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 20.0;
        assert!(outline.windows(2).all(|pair| near(pair[0], pair[1])));
        assert!(near(outline[0], outline[outline.len() - 1]));
        for [r, z] in outline {
            let there = Pose::new(r, 0.0, z, 0.0);
            let joints = Geometry::default().inverse(&there).unwrap();
            let within =
                |range: Range, angle: f64| (range.min - 1e-6..=range.max + 1e-6).contains(&angle);
            assert!(within(limits.j2, joints.j2) && within(limits.j3, joints.j3));
            assert!(within(limits.j2_minus_j3, joints.j2 - joints.j3));
        }
    }
}
