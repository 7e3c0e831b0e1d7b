//! Places of the cubes before and after the demo.
//!
//! Heights are those of the wrist axis, which the arm reports with a suction cup (bias z 0): at
//! [`TABLE_Z`] the cup touches the table. Lengths in mm.

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};

/// Edge of a cube, mm.
pub(super) const CUBE_SIZE: f64 = 25.0;
/// Height at which the cup touches the table, mm.
pub(super) const TABLE_Z: f64 = -60.0;
/// Height at which the cup touches the top of a cube, mm.
pub(super) const CUBE_TOP_Z: f64 = TABLE_Z + CUBE_SIZE;
/// Lift above the higher end of a move, mm.
pub(super) const LIFT_HEIGHT: f64 = 70.0;
/// Tool of the demo.
pub(super) const TOOL: ToolBias = ToolBias::SUCTION;
/// Start and destination of each cube.
pub(super) const CUBES: [CubeMove; 6] = [
    CubeMove::new((150.0, 105.0), (270.0, -70.0)),
    CubeMove::new((180.0, 105.0), (270.0, -110.0)),
    CubeMove::new((210.0, 105.0), (230.0, -70.0)),
    CubeMove::new((240.0, 105.0), (230.0, -110.0)),
    CubeMove::new((270.0, 105.0), (190.0, -70.0)),
    CubeMove::new((300.0, 105.0), (190.0, -110.0)),
];

/// Start and destination of a cube: x and y of its centre, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct CubeMove {
    pub(super) from: (f64, f64),
    pub(super) to: (f64, f64),
}

impl CubeMove {
    const fn new(from: (f64, f64), to: (f64, f64)) -> Self {
        Self { from, to }
    }
}

/// Geometry of the arm with the demo's tool.
pub(super) const ARM: Geometry = Geometry::magician(TOOL);

/// Joint angles after homing and at the end of the demo, deg.
pub(super) const JOINTS_AT_END: [f32; 4] = [0.0, 45.0, 45.0, 0.0];

/// Returns the pose of the tool after homing.
pub(super) fn home() -> Pose {
    ARM.forward(&JointAngles::HOME)
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_motion::ArmModel;

    #[test]
    fn every_place_and_the_point_above_it_is_within_the_guaranteed_reach() {
        for cube in CUBES {
            for (x, y) in [cube.from, cube.to] {
                for z in [CUBE_TOP_Z, CUBE_TOP_Z + LIFT_HEIGHT] {
                    let pose = Pose::new(x, y, z, 0.0);
                    let joints = ARM.inverse_within(&pose, &ArmModel::MAGICIAN.guaranteed);
                    assert!(joints.is_ok(), "{pose:?}: {joints:?}");
                }
            }
        }
    }

    #[test]
    fn no_two_cubes_share_a_place() {
        let places: Vec<_> = CUBES.iter().flat_map(|cube| [cube.from, cube.to]).collect();
        for (at, one) in places.iter().enumerate() {
            for other in &places[at + 1..] {
                let apart = (one.0 - other.0).abs().max((one.1 - other.1).abs());
                assert!(apart > CUBE_SIZE, "{one:?} {other:?}");
            }
        }
    }
}
