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
use crate::device::handlers::{Apply, Report, stored};
use crate::event::Refusal;

stored!(
    PtpJointParams in ptp_joint,
    PtpCoordinateParams in ptp_coordinate,
    PtpJump2Params in ptp_jump2,
    PtpCommonParams in ptp_common,
    PtpLParams in ptp_rail,
);

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

/// What a command asks for, apart from the outputs.
struct Destination {
    mode: PtpMode,
    numbers: [f32; 4],
    /// The rail's place or, in the incremental modes, its way, mm.
    rail: Option<f32>,
}

fn move_to(cx: &mut Context<'_>, to: &Destination, outputs: PoList) -> Effects {
    match request(cx, to.mode, to.numbers) {
        Some(request) => {
            let rail = rail_target(cx, to);
            Effect::Move(cx.view().plan_move(&request, rail, outputs)).into()
        }
        None => {
            let raise = Effects::from(Effect::Raise(Alarm::UndefinedInstruction));
            raise.and(Effect::Refuse(Refusal::UnknownMode))
        }
    }
}

/// Where on the rail an to leads; without the rail its number is ignored (model section 12).
fn rail_target(cx: &Context<'_>, to: &Destination) -> Option<f64> {
    let rail = f64::from(to.rail.filter(|_| cx.has_rail())?);
    Some(match to.mode {
        PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc => cx.rail() + rail,
        _ => rail,
    })
}

/// The commands that move to a point: where on the rail each leads, and what it switches on the way.
macro_rules! moves {
    ($($command:ident, $extra:expr;)+) => {$(
        impl Apply for $command {
            fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
                let extra: fn(&Self) -> (Option<f32>, PoList) = $extra;
                let (rail, outputs) = extra(self);
                let to = Destination {
                    mode: self.ptp_mode,
                    numbers: [self.x, self.y, self.z, self.r],
                    rail,
                };
                move_to(cx, &to, outputs)
            }
        }
    )+};
}

moves! {
    PtpCmd, |_| (None, PoList::default());
    PtpWithLCmd, |ptp| (Some(ptp.l), PoList::default());
    PtpPoCmd, |ptp| (None, ptp.po);
    PtpPoWithLCmd, |ptp| (Some(ptp.l), ptp.po);
}

impl Report for PtpJumpParams {
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.ptp_jump
    }
}

impl Apply for PtpJumpParams {
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
