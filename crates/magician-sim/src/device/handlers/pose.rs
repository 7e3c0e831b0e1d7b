//! Pose of the arm (document 1.4).

use magician_motion::JointAngles;
use magician_protocol::commands::*;
use magician_protocol::{NoArgs, Writable};

use crate::convert::{from_wire, pose_to_wire, to_wire};
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::{Apply, Report, stored};
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

stored! { ArmOrientation in orientation: StoredWithoutEffect; }

/// Angles accepted by ResetPose, deg: a full turn either way. A choice; NaN and absurd values are
/// refused.
const SENSIBLE: std::ops::RangeInclusive<f64> = -360.0..=360.0;

impl Report for Pose {
    const ASSUMPTION: Assumption = Assumption::CommandedPose;

    fn assumptions(cx: &mut Context<'_>, _: &NoArgs) -> AssumptionSet {
        let homed = cx.motion.is_homed();
        AssumptionSet::from(Self::ASSUMPTION)
            .and_if(!homed, Assumption::BaseUnknown)
            .and_if(!homed, Assumption::PowerUpPose)
            .and_if(
                !cx.store.settings.motion.tool.is_zero(),
                Assumption::ToolBias,
            )
            .and_if(cx.has_tool_of_power_up(), Assumption::PowerUpTool)
    }

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        // The commanded pose: steppers run open-loop, so the controller knows no other (model
        // section 1).
        pose_to_wire(&cx.arm())
    }
}

impl Report for PoseL {
    const ASSUMPTION: Assumption = Assumption::RailPose;

    /// Commanded position of the carriage; without a rail its last one.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let [pose_l] = to_wire([cx.rail()]);
        Self { pose_l }
    }
}

impl Report for Kinematics {
    const ASSUMPTION: Assumption = Assumption::Zeros;

    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            velocity: 0.0,
            acceleration: 0.0,
        }
    }
}

impl Apply for ResetPose {
    const ASSUMPTION: Assumption = Assumption::ResetPose;

    /// Sets the reported J2 and J3: to the given angles, or to their sensors if manual is 0. The
    /// arm does not move.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let read = cx.true_joints();
        let [j2, j3] = if self.manual.is_on() {
            from_wire([self.rear_arm_angle, self.front_arm_angle])
        } else {
            [read.j2, read.j3]
        };
        let sensible = SENSIBLE.contains(&j2) && SENSIBLE.contains(&j3);
        // During a motion the reported joints are a function of time, and cannot be set.
        if cx.motion.is_moving() || !sensible {
            return if cx
                .record
                .allows(Self::ROW.id, Assumption::UntimelyResetPose)
            {
                Effect::Refuse(Refusal::Pose).into()
            } else {
                Effects::none()
            };
        }
        let joints = cx.arm().joints;
        Effect::SetReported(JointAngles { j2, j3, ..joints }).into()
    }
}
