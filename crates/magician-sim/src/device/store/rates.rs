//! What the settings mean to the planner: tool, speeds, heights.

use magician_motion::{
    ArmModel, CpSpeeds, Geometry, JogAxis, JumpHeights, KinematicLimits, Pose, Speeds, Target,
    ToolBias,
};
use magician_protocol::{Flag, commands};

use super::settings::Settings;
use crate::convert::{capped, from_wire};

impl Settings {
    /// The tool bias that is set now.
    pub(crate) fn tool(&self) -> ToolBias {
        let bias = &self.bias;
        let [x, y, z] = from_wire([bias.x_bias, bias.y_bias, bias.z_bias]);
        ToolBias::new(x, y, z)
    }

    /// The arm with the tool bias that is set now.
    pub(crate) fn geometry(&self, model: &ArmModel) -> Geometry {
        model.geometry(self.tool())
    }

    /// Whether the controller was told of a rail.
    pub(crate) fn has_rail(&self) -> bool {
        self.with_rail.with_l.is_on()
    }

    /// The speeds of point-to-point moves and arcs that are set now; the planner knows their ceilings.
    pub(crate) fn ptp_speeds(&self) -> Speeds {
        let (joint, space, ratio) = (&self.ptp_joint, &self.ptp_coordinate, &self.ptp_common);
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

    /// The speeds of continuous paths that are set now.
    pub(crate) fn cp_speeds(&self, model: &ArmModel) -> CpSpeeds {
        let real_time = self.cp.real_time_track != Flag::OFF;
        let own = &model.power_up.path;
        CpSpeeds {
            plan_acceleration: self.cp.plan_acc.into(),
            junction_velocity: self.cp.junction_vel.into(),
            period_s: if real_time {
                f64::from(self.cp.acc_or_period) / 1000.0
            } else {
                own.period_s
            },
            real_time,
        }
    }

    /// The speeds of jogging an axis, each up to its ceiling: the ratio scales the velocity and not the
    /// acceleration. A ratio that is none leaves no speed.
    pub(crate) fn jog_rates(&self, model: &ArmModel, axis: JogAxis) -> KinematicLimits {
        let (joint, space) = (&self.jog_joint, &self.jog_coordinate);
        let ([v1, v2, v3, v4], [a1, a2, a3, a4]) = (joint.velocity, joint.acceleration);
        let ([vx, vy, vz, vr], [ax, ay, az, ar]) = (space.velocity, space.acceleration);
        let most = &model.ceilings;
        let ([m1, m2, m3, m4], [n1, n2, n3, n4]) = (most.joint_velocity, most.joint_acceleration);
        let (along, linear) = (most.linear_velocity, most.linear_acceleration);
        let (round, rotation) = (most.rotation_velocity, most.rotation_acceleration);
        let (velocity, fastest, acceleration, steepest) = match axis {
            JogAxis::J1 => (v1, m1, a1, n1),
            JogAxis::J2 => (v2, m2, a2, n2),
            JogAxis::J3 => (v3, m3, a3, n3),
            JogAxis::J4 => (v4, m4, a4, n4),
            JogAxis::X => (vx, along, ax, linear),
            JogAxis::Y => (vy, along, ay, linear),
            JogAxis::Z => (vz, along, az, linear),
            JogAxis::R => (vr, round, ar, rotation),
        };
        let ratio = capped(self.jog_common.velocity_ratio.into(), 100.0) / 100.0;
        let ratio = if ratio > 0.0 { ratio } else { f64::NAN };
        KinematicLimits {
            velocity: capped(velocity.into(), fastest) * ratio,
            acceleration: capped(acceleration.into(), steepest),
        }
    }

    /// Speeds of moves on the rail; `None` for what is no speed.
    pub(crate) fn rail_rates(&self) -> Option<KinematicLimits> {
        let (speeds, ratios) = (&self.ptp_rail, &self.ptp_common);
        rates(
            [speeds.velocity, speeds.acceleration],
            [ratios.velocity_ratio, ratios.acceleration_ratio],
        )
    }

    /// Speeds of jogs on the rail; the acceleration of a jog has no ratio (model section 6).
    pub(crate) fn rail_jog_rates(&self) -> Option<KinematicLimits> {
        let (speeds, ratios) = (&self.jog_rail, &self.jog_common);
        rates(
            [speeds.velocity, speeds.acceleration],
            [ratios.velocity_ratio, 100.0],
        )
    }

    /// The home point that was set, if one was.
    pub(crate) fn home_point(&self) -> Option<Target> {
        let commands::HomeParams { x, y, z, r } = self.home?;
        Some(Target::Pose(Pose::from(from_wire([x, y, z, r]))))
    }

    /// How high jumps go now.
    pub(crate) fn jump_heights(&self) -> JumpHeights {
        let heights = &self.ptp_jump2;
        JumpHeights {
            start: heights.start_jump_height.into(),
            end: heights.end_jump_height.into(),
            z_limit: heights.z_limit.into(),
        }
    }
}

/// Velocity and acceleration that are set, with their ratios in percent up to 100; `None` for what is no speed.
fn rates([velocity, acceleration]: [f32; 2], ratios: [f32; 2]) -> Option<KinematicLimits> {
    let [velocity_ratio, acceleration_ratio] =
        ratios.map(|ratio| f64::from(ratio).min(100.0) / 100.0);
    let (velocity, acceleration) = (f64::from(velocity), f64::from(acceleration));
    let parts = [velocity, velocity_ratio, acceleration, acceleration_ratio];
    // NaN is not above 0; f64::min would hide one.
    let sensible =
        parts.iter().all(|part| *part > 0.0) && !ratios.iter().any(|ratio| ratio.is_nan());
    sensible.then_some(KinematicLimits {
        velocity: velocity * velocity_ratio,
        acceleration: acceleration * acceleration_ratio,
    })
}
