//! Point-to-point motion (document 1.10, model section 7).

use magician_motion::{JointAngles, Move, MoveKind, Pose, Target, Transfer};
use magician_protocol::commands::{
    GetPtpTime, PtpCmd, PtpCommonParams, PtpCoordinateParams, PtpJointParams, PtpJump2Params,
    PtpJumpParams, PtpLParams, PtpPoCmd, PtpPoWithLCmd, PtpTime, PtpWithLCmd,
};
use magician_protocol::{Alarm, NoArgs, PoList, PtpMode};

use crate::convert::from_wire;
use crate::device::context::Context;
use crate::device::effect::{Effect, Effects, ExecMode};
use crate::device::handlers::motion::{beyond, cap, cap_joints};
use crate::device::handlers::{Apply, Report, stored};
use crate::event::Refusal;
use crate::fidelity::{Assumption, AssumptionSet};

stored! {
    PtpJointParams in ptp_joint: Parameters,
        capped |set, most| cap_joints(&mut set.velocity, &mut set.acceleration, most);
    PtpCoordinateParams in ptp_coordinate: Parameters, capped |set, most| cap(
        [
            &mut set.xyz_velocity,
            &mut set.r_velocity,
            &mut set.xyz_acceleration,
            &mut set.r_acceleration,
        ],
        [
            most.linear_velocity,
            most.rotation_velocity,
            most.linear_acceleration,
            most.rotation_acceleration,
        ],
    );
    PtpJump2Params in ptp_jump2: Parameters;
    PtpCommonParams in ptp_common: Parameters,
        beyond |set| beyond([set.velocity_ratio, set.acceleration_ratio], [100.0; 2]);
    PtpLParams in ptp_rail: Parameters, at first RailDefaults;
}

/// What a mode and its four numbers ask for; `None` for a mode that there is not (errata E28, model section 7).
fn request(cx: &Context<'_>, mode: PtpMode, numbers: [f32; 4]) -> Option<Move> {
    let numbers = from_wire(numbers);
    let (pose, joints) = (Pose::from(numbers), JointAngles::from(numbers));
    let jump = |transfer| MoveKind::Jump(cx.store.settings.jump_heights(), transfer);
    let (target, kind) = match mode {
        PtpMode::JumpXyz => (Target::Pose(pose), jump(Transfer::Joint)),
        PtpMode::MovjXyz => (Target::Pose(pose), MoveKind::Joint),
        PtpMode::MovlXyz => (Target::Pose(pose), MoveKind::Line),
        PtpMode::JumpAngle => (Target::Joints(joints), jump(Transfer::Joint)),
        PtpMode::MovjAngle => (Target::Joints(joints), MoveKind::Joint),
        PtpMode::MovlAngle => (Target::Joints(joints), MoveKind::Line),
        PtpMode::MovjAngleInc => (Target::JointIncrement(joints), MoveKind::Joint),
        PtpMode::MovlXyzInc => (Target::PoseIncrement(pose), MoveKind::Line),
        PtpMode::MovjXyzInc => (Target::PoseIncrement(pose), MoveKind::Joint),
        PtpMode::JumpMovlXyz => (Target::Pose(pose), jump(Transfer::Line)),
        PtpMode::Unknown(_) => return None,
    };
    Some(Move { target, kind })
}

/// What a command asks for.
struct Destination {
    mode: PtpMode,
    numbers: [f32; 4],
    /// The rail's place or, in the incremental modes, its way, mm.
    rail: Option<f32>,
    /// What is switched on the way, of the commands that can.
    outputs: Option<PoList>,
}

fn move_to(cx: &mut Context<'_>, to: &Destination) -> Effects {
    match request(cx, to.mode, to.numbers) {
        Some(request) => {
            let (rail, outputs) = (rail_target(cx, to), to.outputs.unwrap_or_default());
            Effect::Move(cx.view().plan_move(&request, rail, outputs)).into()
        }
        None => {
            let raise = Effects::from(Effect::Raise(Alarm::UndefinedInstruction));
            raise.and(Effect::Refuse(Refusal::UnknownMode))
        }
    }
}

/// Where on the rail a move leads; without the rail its number is ignored (model section 12).
fn rail_target(cx: &Context<'_>, to: &Destination) -> Option<f64> {
    let rail = f64::from(to.rail.filter(|_| cx.has_rail())?);
    Some(match to.mode {
        PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc => cx.rail() + rail,
        _ => rail,
    })
}

/// What a move rests on that is asked for so.
fn move_assumptions(cx: &Context<'_>, to: &Destination) -> AssumptionSet {
    let set = AssumptionSet::default()
        .and_if(to.outputs.is_some(), Assumption::OutputShare)
        .and_if(to.mode == PtpMode::MovlXyzInc, Assumption::ModeSeven)
        .and_if(to.mode == PtpMode::JumpMovlXyz, Assumption::ModeNine)
        .union(rail_assumptions(cx, to));
    match request(cx, to.mode, to.numbers) {
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
        Target::JointIncrement(_) => f64::NAN,
    };
    let above = cx.arm().pose.z.max(target) > heights.z_limit;
    AssumptionSet::from(Assumption::JumpPath)
        .and_if(heights.start != heights.end, Assumption::UnequalJump)
        .and_if(above, Assumption::JumpAboveLimit)
}

fn rail_assumptions(cx: &Context<'_>, to: &Destination) -> AssumptionSet {
    let Some(place) = rail_target(cx, to) else {
        return AssumptionSet::default().and_if(to.rail.is_some(), Assumption::RailIgnored);
    };
    let ends = 0.0..=cx.firmware.profile.rail.length;
    AssumptionSet::from(Assumption::RailWithArm)
        .and(Assumption::RailRamps)
        .and_if(!ends.contains(&place), Assumption::RailEnds)
}

/// The commands that move to a point: where on the rail each leads, and what it switches on the way.
macro_rules! moves {
    ($($command:ident, $extra:expr;)+) => {$(
        impl From<&$command> for Destination {
            fn from(ptp: &$command) -> Self {
                let extra: fn(&$command) -> (Option<f32>, Option<PoList>) = $extra;
                let (rail, outputs) = extra(ptp);
                Self {
                    mode: ptp.ptp_mode,
                    numbers: [ptp.x, ptp.y, ptp.z, ptp.r],
                    rail,
                    outputs,
                }
            }
        }

        impl Apply for $command {
            const RESTS_ON: Assumption = Assumption::PtpLaw;

            fn assumptions(&self, cx: &Context<'_>, mode: ExecMode) -> AssumptionSet {
                let to = Destination::from(self);
                AssumptionSet::from(Self::RESTS_ON)
                    .union(move_assumptions(cx, &to))
                    .union(cx.motion_assumptions(&to.numbers, mode))
            }

            fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
                move_to(cx, &self.into())
            }
        }
    )+};
}

moves! {
    PtpCmd, |_| (None, None);
    PtpWithLCmd, |ptp| (Some(ptp.l), None);
    PtpPoCmd, |ptp| (None, Some(ptp.po));
    PtpPoWithLCmd, |ptp| (Some(ptp.l), Some(ptp.po));
}

impl Report for PtpJumpParams {
    const RESTS_ON: Assumption = Assumption::Parameters;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.ptp_jump
    }
}

impl Apply for PtpJumpParams {
    const RESTS_ON: Assumption = Assumption::JumpSetsBoth;

    /// One height is both heights of the second set (model section 7).
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.ptp_jump = *self;
        cx.store.settings.ptp_jump2 = PtpJump2Params {
            start_jump_height: self.jump_height,
            end_jump_height: self.jump_height,
            z_limit: self.z_limit,
        };
        Effects::none()
    }
}

impl Report for PtpTime {
    const RESTS_ON: Assumption = Assumption::PtpTime;

    /// Rounded up; 0 for a move that would be refused.
    fn report(cx: &mut Context<'_>, query: &GetPtpTime) -> Self {
        let GetPtpTime {
            ptp_mode,
            x,
            y,
            z,
            r,
        } = *query;
        let plan = request(cx, ptp_mode, [x, y, z, r]).map(|request| cx.view().plan(&request));
        let lasting = match plan {
            Some(Ok(plan)) => plan.trajectory.duration_us().div_ceil(1000),
            _ => 0,
        };
        let ptp_time = u32::try_from(lasting).unwrap_or(u32::MAX);
        Self { ptp_time }
    }
}
