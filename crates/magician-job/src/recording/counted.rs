//! The tool that poses are counted for, which another program may change while the arm is recorded.
//!
//! A new bias moves the pose and not the arm: a recorder of poses has to know, or it records a motion that never
//! happened. Each pose tells its bias itself, beside the joints.

use magician::commands::{EndEffectorParams, Pose};
use magician::{Arm, Geometry, JointAngles, ToolBias};
use magician_program::Tool;

/// Biases that differ by less are the same: an arm's own geometry is known to 0.03 mm, and no two tools are so alike, mm.
const SAME: f64 = 0.5;

/// What poses are counted for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    tool: Tool,
    /// Whether this arm's poses and joints are those of the geometry that is known here.
    tells: Option<bool>,
}

impl Counted {
    pub(super) fn new(tool: Tool) -> Self {
        Self { tool, tells: None }
    }

    /// The tool that this pose is counted for; the arm is asked when it must be another one than before. Nothing if the arm
    /// does not say, or it was changed once more in between.
    pub(super) async fn of(&mut self, pose: &Pose, arm: &Arm) -> Option<Tool> {
        if self.is_another(pose) {
            let tool = Tool::from(&arm.get::<EndEffectorParams>().await.ok()?);
            if !same(tool.bias(), bias_of(pose)) {
                return None;
            }
            self.tool = tool;
        }
        Some(self.tool)
    }

    fn is_another(&mut self, pose: &Pose) -> bool {
        let agree = same(self.tool.bias(), bias_of(pose));
        *self.tells.get_or_insert(agree) && !agree
    }
}

/// This pose, counted for another tool.
pub(super) fn recounted(pose: &Pose, from: Tool, to: Tool) -> Pose {
    let (from, to) = (from.bias(), to.bias());
    let (x, y) = (to.x - from.x, to.y - from.y);
    let (sin, cos) = f64::from(pose.joint_angle[0]).to_radians().sin_cos();
    let moved = |at: f32, by: f64| (f64::from(at) + by) as f32;
    Pose {
        x: moved(pose.x, x * cos - y * sin),
        y: moved(pose.y, x * sin + y * cos),
        z: moved(pose.z, from.z - to.z),
        ..*pose
    }
}

fn same(one: ToolBias, other: ToolBias) -> bool {
    let apart = [one.x - other.x, one.y - other.y, one.z - other.z];
    apart.iter().all(|part| part.abs() < SAME)
}

/// The bias that lies between the wrist, where the joints have it, and the tip, where the pose has it.
fn bias_of(pose: &Pose) -> ToolBias {
    let joints = JointAngles::from(pose.joint_angle.map(f64::from));
    let wrist = Geometry::magician(ToolBias::NONE).forward(&joints);
    let (sin, cos) = joints.j1.to_radians().sin_cos();
    let (x, y) = (f64::from(pose.x) - wrist.x, f64::from(pose.y) - wrist.y);
    ToolBias::new(
        x * cos + y * sin,
        y * cos - x * sin,
        wrist.z - f64::from(pose.z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(joints: [f32; 4], tool: Tool) -> Pose {
        let geometry = Geometry::magician(tool.bias());
        let at = geometry.forward(&JointAngles::from(joints.map(f64::from)));
        let [x, y, z, r] = at.to_array().map(|part| part as f32);
        Pose {
            x,
            y,
            z,
            r,
            joint_angle: joints,
        }
    }

    #[test]
    fn a_pose_is_recounted_as_the_arm_would_count_it() {
        let joints = [-40.0, 50.0, 30.0, 20.0];
        let other = Tool::Bias([30.0, -12.0, 7.0]);
        let [was, wanted] = [pose(joints, Tool::Pen), pose(joints, other)];
        let is = recounted(&was, Tool::Pen, other);
        for (is, wanted) in [(is.x, wanted.x), (is.y, wanted.y), (is.z, wanted.z)] {
            assert!((is - wanted).abs() < 1e-3, "{is} {wanted}");
        }
        assert!(same(bias_of(&was), Tool::Pen.bias()) && same(bias_of(&wanted), other.bias()));
        assert!(!same(Tool::Pen.bias(), Tool::Suction.bias()));
    }

    #[test]
    fn another_tool_shows_in_a_pose_of_an_arm_whose_geometry_is_known() {
        let joints = [10.0, 40.0, 40.0, 0.0];
        let mut counted = Counted::new(Tool::None);
        assert!(!counted.is_another(&pose(joints, Tool::None)));
        assert!(counted.is_another(&pose(joints, Tool::Pen)));
        // One that has never agreed tells nothing.
        let mut counted = Counted::new(Tool::None);
        assert!(!counted.is_another(&pose(joints, Tool::Pen)));
        assert!(!counted.is_another(&pose(joints, Tool::Suction)));
    }
}
