//! Point-to-point motion (document 1.10, model section 7).

use magician_model::{Capped, PtpMove};
use magician_motion::{Move, MoveKind, Target};
use magician_protocol::commands::{
    GetPtpTime, PtpCmd, PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpJump2Params,
    PtpJumpParams, PtpLParams, PtpPoCmd, PtpPoWithLCmd, PtpTime, PtpWithLCmd,
};
use magician_protocol::{Alarm, NoArgs, PtpMode, Set};

use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::motion::beyond;
use crate::device::handlers::{Apply, Report, stored};
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

stored! {
    // Values above a ceiling are stored as the ceiling; ratios are stored as sent (model section
    // 6).
    PtpJointParams in motion.ptp_joint: Parameters,
        capped |set, ceilings| set.cap(ceilings);
    PtpCoordinateParams in motion.ptp_coordinate: Parameters,
        capped |set, ceilings| set.cap(ceilings);
    PtpJump2Params in motion.ptp_jump2: Parameters;
    PtpCommonParams in motion.ptp_common: Parameters,
        beyond |set| beyond([set.velocity_ratio, set.acceleration_ratio], [100.0; 2]);
    PtpLParams in motion.ptp_rail: Parameters, at first RailDefaults;
}

fn move_to(cx: &mut Context<'_>, to: &PtpMove) -> Effects {
    match request(cx, to) {
        Some(request) => {
            // Planned at the start of the move, with whatever has been set by then (model section
            // 7).
            let (rail, outputs) = (rail_target(cx, to), to.outputs.unwrap_or_default());
            Effect::Move(cx.view().plan_move(&request, rail, outputs)).into()
        }
        // A mode above 9 is consumed without motion (model section 15a).
        None => {
            let raise = Effects::from(Effect::Raise(Alarm::UndefinedInstruction));
            raise.and(Effect::Refuse(Refusal::UnknownMode))
        }
    }
}

/// Request for the planner; `None` for an unknown mode (errata E28).
fn request(cx: &Context<'_>, to: &PtpMove) -> Option<Move> {
    to.request(cx.store.settings.motion.jump())
}

/// Target on the rail, mm; `None` without a rail, because the arm then ignores the target (model
/// section 12).
fn rail_target(cx: &Context<'_>, to: &PtpMove) -> Option<f64> {
    let rail = f64::from(to.rail.filter(|_| cx.has_rail())?);
    Some(if to.mode.is_relative() {
        cx.rail() + rail
    } else {
        rail
    })
}

/// Assumptions of a move.
fn move_assumptions(cx: &Context<'_>, to: &PtpMove) -> AssumptionSet {
    let set = AssumptionSet::default()
        .and_if(to.outputs.is_some(), Assumption::OutputShare)
        .and_if(to.mode == PtpMode::MovlXyzInc, Assumption::ModeSeven)
        .and_if(to.mode == PtpMode::JumpMovlXyz, Assumption::ModeNine)
        .union(rail_assumptions(cx, to));
    match request(cx, to) {
        None => set.and(Assumption::UnknownMode),
        Some(request) => set.union(jump_assumptions(cx, &request)),
    }
}

fn jump_assumptions(cx: &Context<'_>, request: &Move) -> AssumptionSet {
    let MoveKind::Jump(heights, _) = request.kind else {
        return AssumptionSet::default();
    };
    let target = match request.target {
        Target::Joints(joints) => cx.geometry().forward(&joints).z,
        Target::Pose(pose) | Target::PoseIncrement(pose) => pose.z,
        // No jump mode has a joint increment as its target (E28).
        Target::JointIncrement(_) => f64::NAN,
    };
    let above = cx.arm().pose.z.max(target) > heights.z_limit;
    AssumptionSet::from(Assumption::JumpPath)
        .and_if(heights.start != heights.end, Assumption::UnequalJump)
        .and_if(above, Assumption::JumpAboveLimit)
}

fn rail_assumptions(cx: &Context<'_>, to: &PtpMove) -> AssumptionSet {
    let Some(place) = rail_target(cx, to) else {
        return AssumptionSet::default().and_if(to.rail.is_some(), Assumption::RailIgnored);
    };
    let ends = 0.0..=cx.firmware.model.rail.length;
    AssumptionSet::from(Assumption::RailWithArm)
        .and(Assumption::RailRamps)
        .and_if(!ends.contains(&place), Assumption::RailEnds)
}

macro_rules! moves {
    ($($command:ident)+) => {$(
        impl Apply for $command {
            const ASSUMPTION: Assumption = Assumption::PtpLaw;

            fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
                let to = PtpMove::from(self);
                AssumptionSet::from(Self::ASSUMPTION)
                    .union(move_assumptions(cx, &to))
                    .union(cx.motion_assumptions(&to.numbers, mode))
            }

            fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
                move_to(cx, &self.into())
            }
        }
    )+};
}

moves! { PtpCmd PtpWithLCmd PtpPoCmd PtpPoWithLCmd }

impl Report for PtpJumpParams {
    const ASSUMPTION: Assumption = Assumption::Parameters;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.motion.ptp_jump
    }
}

// Also sets both heights of PTPJump2Params, as the vendor's code does (E27).
impl Apply for PtpJumpParams {
    const ASSUMPTION: Assumption = Assumption::JumpSetsBoth;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.motion.apply(&Set::from(*self));
        Effects::none()
    }
}

impl Report for PtpTime {
    const ASSUMPTION: Assumption = Assumption::PtpTime;

    /// Duration in ms, rounded up; 0 for a move that would be refused.
    fn report(cx: &mut Context<'_>, query: &GetPtpTime) -> Self {
        let GetPtpTime {
            ptp_mode,
            x,
            y,
            z,
            r,
        } = *query;
        let to = PtpMove::from(&PtpCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
        });
        let plan = request(cx, &to).map(|request| cx.view().plan(&request));
        let duration_ms = match plan {
            Some(Ok(plan)) => plan.trajectory.duration_us().div_ceil(1000),
            _ => 0,
        };
        let ptp_time = u32::try_from(duration_ms).unwrap_or(u32::MAX);
        Self { ptp_time }
    }
}
