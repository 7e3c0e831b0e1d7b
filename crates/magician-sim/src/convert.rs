//! The one place where the wire's 32-bit numbers become the planner's 64-bit ones, and are rounded back.

use magician_motion::{ArmState, Geometry, JumpHeights, Pose, Speeds, Target, ToolBias};
use magician_protocol::commands;

use crate::device::Device;

/// Rounds once, to the nearest number that the wire has.
pub(crate) fn to_wire<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|value| value as f32)
}

/// Widens; exact.
pub(crate) fn from_wire<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// The answer to GetPose.
pub(crate) fn pose_to_wire(arm: &ArmState) -> commands::Pose {
    let [x, y, z, r] = to_wire(arm.pose.to_array());
    let joint_angle = to_wire(arm.joints.to_array());
    commands::Pose {
        x,
        y,
        z,
        r,
        joint_angle,
    }
}

/// The bias of a tool as a host sets it.
pub(crate) fn tool_to_wire(tool: ToolBias) -> commands::EndEffectorParams {
    let [x_bias, y_bias, z_bias] = to_wire([tool.x, tool.y, tool.z]);
    commands::EndEffectorParams {
        x_bias,
        y_bias,
        z_bias,
    }
}

impl Device {
    /// The tool bias that is set now.
    pub(crate) fn tool(&self) -> ToolBias {
        let bias = &self.settings.bias;
        let [x, y, z] = from_wire([bias.x_bias, bias.y_bias, bias.z_bias]);
        ToolBias::new(x, y, z)
    }

    /// The arm with the tool bias that is set now.
    pub(crate) fn geometry(&self) -> Geometry {
        self.model.geometry(self.tool())
    }

    /// The point-to-point speeds that are set now; the planner knows their ceilings.
    pub(crate) fn ptp_speeds(&self) -> Speeds {
        let (joint, space) = (&self.settings.ptp_joint, &self.settings.ptp_coordinate);
        let ratio = &self.settings.ptp_common;
        Speeds {
            joint_velocity: from_wire(joint.velocity),
            joint_acceleration: from_wire(joint.acceleration),
            linear_velocity: space.xyz_velocity.into(),
            linear_acceleration: space.xyz_acceleration.into(),
            rotation_velocity: space.r_velocity.into(),
            rotation_acceleration: space.r_acceleration.into(),
            velocity_ratio: ratio.velocity_ratio.into(),
            acceleration_ratio: ratio.acceleration_ratio.into(),
        }
    }

    /// The speeds of arcs that are set now; no joint moves by itself.
    pub(crate) fn arc_speeds(&self) -> Speeds {
        let (arc, ratio) = (&self.settings.arc, &self.settings.arc_common);
        Speeds {
            linear_velocity: arc.xyz_velocity.into(),
            linear_acceleration: arc.xyz_acceleration.into(),
            rotation_velocity: arc.r_velocity.into(),
            rotation_acceleration: arc.r_acceleration.into(),
            velocity_ratio: ratio.velocity_ratio.into(),
            acceleration_ratio: ratio.acceleration_ratio.into(),
            ..self.ptp_speeds()
        }
    }

    /// The home point that was set, if one was.
    pub(crate) fn home_point(&self) -> Option<Target> {
        let commands::HomeParams { x, y, z, r } = self.settings.home?;
        Some(Target::Pose(Pose::from(from_wire([x, y, z, r]))))
    }

    /// How high jumps go now.
    pub(crate) fn jump_heights(&self) -> JumpHeights {
        let heights = &self.settings.ptp_jump2;
        JumpHeights {
            start: heights.start_jump_height.into(),
            end: heights.end_jump_height.into(),
            z_limit: heights.z_limit.into(),
        }
    }
}

/// The value, no more than the ceiling; what is not a number stays so, for the planner to refuse.
pub(crate) fn capped(value: f64, ceiling: f64) -> f64 {
    if value > ceiling { ceiling } else { value }
}

/// Seconds as whole microseconds, to the nearest; what is no such time is 0 or the end of time.
pub(crate) fn micros(seconds: f64) -> crate::Micros {
    // A cast of a float saturates, and takes NaN to 0.
    (seconds * 1e6).round() as crate::Micros
}
