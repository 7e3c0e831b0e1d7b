//! Where the cubes lie and where they go.
//!
//! Heights are those of the wrist axis, which is what the arm reports with a suction cup (bias z
//! 0): at [`TABLE`] the cup touches the table. Lengths in mm.

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};

/// Edge of a cube.
pub(super) const CUBE: f64 = 25.0;
/// Height at which the cup touches the table.
pub(super) const TABLE: f64 = -60.0;
/// Height at which it touches a cube's upper side.
pub(super) const TOP: f64 = TABLE + CUBE;
/// How far the arm lifts a cube above the higher end of its way.
pub(super) const LIFT: f64 = 70.0;
/// The tool.
pub(super) const TOOL: ToolBias = ToolBias::SUCTION;
/// The cubes.
pub(super) const CUBES: [Errand; 6] = [
    Errand::new((150.0, 105.0), (270.0, -70.0)),
    Errand::new((180.0, 105.0), (270.0, -110.0)),
    Errand::new((210.0, 105.0), (230.0, -70.0)),
    Errand::new((240.0, 105.0), (230.0, -110.0)),
    Errand::new((270.0, 105.0), (190.0, -70.0)),
    Errand::new((300.0, 105.0), (190.0, -110.0)),
];

/// A cube's way over the table, x and y of its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errand {
    pub(super) from: (f64, f64),
    pub(super) to: (f64, f64),
}

impl Errand {
    const fn new(from: (f64, f64), to: (f64, f64)) -> Self {
        Self { from, to }
    }
}

/// The arm with the demonstration's tool.
pub(super) const ARM: Geometry = Geometry::magician(TOOL);

/// Where the joints are after homing, and at the end.
pub(super) const JOINTS_AT_END: [f32; 4] = [0.0, 45.0, 45.0, 0.0];

/// Where the tool is after homing.
pub(super) fn home() -> Pose {
    ARM.forward(&JointAngles::HOME)
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_motion::ArmModel;

    #[test]
    fn every_place_and_the_point_above_it_is_within_the_guaranteed_reach() {
        for errand in CUBES {
            for (x, y) in [errand.from, errand.to] {
                for z in [TOP, TOP + LIFT] {
                    let pose = Pose::new(x, y, z, 0.0);
                    let joints = ARM.inverse_within(&pose, &ArmModel::MAGICIAN.guaranteed);
                    assert!(joints.is_ok(), "{pose:?}: {joints:?}");
                }
            }
        }
    }

    #[test]
    fn no_two_cubes_share_a_place() {
        let places: Vec<_> = CUBES
            .iter()
            .flat_map(|errand| [errand.from, errand.to])
            .collect();
        for (at, one) in places.iter().enumerate() {
            for other in &places[at + 1..] {
                let apart = (one.0 - other.0).abs().max((one.1 - other.1).abs());
                assert!(apart > CUBE, "{one:?} {other:?}");
            }
        }
    }
}
