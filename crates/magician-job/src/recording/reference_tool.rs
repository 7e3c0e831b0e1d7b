//! Tool that recorded poses refer to, which another program may change during a recording.
//!
//! A new bias changes the pose without any motion: a recorder that misses it records a motion that
//! never happened. The bias can be computed from every pose, because a pose also contains the joint
//! angles.

use magician::commands::{EndEffectorParams, Pose};
use magician::{Arm, Geometry, JointAngles, ToolBias};
use magician_program::Tool;

/// Smallest difference between two biases that counts, mm. An arm's own geometry is known to 0.03
/// mm, and no two tools are this similar.
const MIN_BIAS_DIFFERENCE: f64 = 0.5;

/// Tool that the poses of an arm refer to.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReferenceTool {
    tool: Tool,
    /// True if the arm's poses and joints agree with the geometry known here; `None` before the
    /// first pose.
    is_comparable: Option<bool>,
}

impl ReferenceTool {
    pub(super) fn new(tool: Tool) -> Self {
        Self {
            tool,
            is_comparable: None,
        }
    }

    /// Tool that `pose` refers to. Reads it from the arm if the pose shows a change. `None` if the
    /// arm does not answer, or the tool has changed once more since.
    pub(super) async fn of(&mut self, pose: &Pose, arm: &Arm) -> Option<Tool> {
        if self.is_another(pose) {
            let tool = Tool::from(&arm.get::<EndEffectorParams>().await.ok()?);
            if !is_same_bias(tool.bias(), bias_of(pose)) {
                return None;
            }
            self.tool = tool;
        }
        Some(self.tool)
    }

    fn is_another(&mut self, pose: &Pose) -> bool {
        let agree = is_same_bias(self.tool.bias(), bias_of(pose));
        *self.is_comparable.get_or_insert(agree) && !agree
    }
}

/// The same pose of the arm, expressed for another tool.
pub(super) fn with_tool(pose: &Pose, from: Tool, to: Tool) -> Pose {
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

fn is_same_bias(one: ToolBias, other: ToolBias) -> bool {
    let apart = [one.x - other.x, one.y - other.y, one.z - other.z];
    apart.iter().all(|part| part.abs() < MIN_BIAS_DIFFERENCE)
}

/// Bias between the wrist, computed from the joints, and the tip, given by the pose.
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
    fn pose_converted_to_another_tool_equals_the_arms_pose() {
        let joints = [-40.0, 50.0, 30.0, 20.0];
        let other = Tool::Bias([30.0, -12.0, 7.0]);
        let [was, wanted] = [pose(joints, Tool::Pen), pose(joints, other)];
        let is = with_tool(&was, Tool::Pen, other);
        for (is, wanted) in [(is.x, wanted.x), (is.y, wanted.y), (is.z, wanted.z)] {
            assert!((is - wanted).abs() < 1e-3, "{is} {wanted}");
        }
        assert!(
            is_same_bias(bias_of(&was), Tool::Pen.bias())
                && is_same_bias(bias_of(&wanted), other.bias())
        );
        assert!(!is_same_bias(Tool::Pen.bias(), Tool::Suction.bias()));
    }

    #[test]
    fn tool_change_is_detected_from_the_pose() {
        let joints = [10.0, 40.0, 40.0, 0.0];
        let mut reference_tool = ReferenceTool::new(Tool::None);
        assert!(!reference_tool.is_another(&pose(joints, Tool::None)));
        assert!(reference_tool.is_another(&pose(joints, Tool::Pen)));
        // An arm that never agreed with the geometry shows nothing.
        let mut reference_tool = ReferenceTool::new(Tool::None);
        assert!(!reference_tool.is_another(&pose(joints, Tool::Pen)));
        assert!(!reference_tool.is_another(&pose(joints, Tool::Suction)));
    }
}
