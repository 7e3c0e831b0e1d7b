//! Violations of the assumptions about pose and identity of the arm, and about values that are set
//! and read back.

use std::cell::Cell;

use magician_motion::ToolBias;
use magician_protocol::commands::*;
use magician_protocol::{Alarm, FrameBuf, PtpMode, Readable, Request};
use magician_sim::fidelity::Assumption as A;
use magician_sim::{Controller, ExternalEvent};

use super::{after, events, ignores, ignores_ids, profile, replies, reports, sets};
use crate::arm::{Violation, ask, ask_with, tell};

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        A::CommandedPose => reports::<Pose>(|arm, pose| {
            pose.joint_angle = arm.state().true_joints.to_array().map(|angle| angle as f32);
        }),
        A::BaseUnknown => reports::<Pose>(|arm, pose| {
            pose.joint_angle[0] = arm.state().true_joints.j1 as f32;
        }),
        A::PowerUpPose => profile(|profile| profile.power_up.joints = [0.0, 40.0, 45.0, 0.0]),
        A::PowerUpTool => profile(|profile| profile.power_up.tool = ToolBias::NONE),
        A::ToolBias => reports::<Pose>(|arm, pose| {
            let bias: EndEffectorParams = ask(arm);
            let (sin, cos) = pose.joint_angle[0].to_radians().sin_cos();
            pose.x -= bias.x_bias * cos - bias.y_bias * sin;
            pose.y -= bias.x_bias * sin + bias.y_bias * cos;
            pose.z += bias.z_bias;
        }),
        A::Zeros => replies(|_, reply| {
            let frame = reply.frame();
            if ![6, 12, 181, 220, 231].contains(&frame.id()) {
                return reply;
            }
            let ones = vec![1; frame.params().len()];
            FrameBuf::new(frame.id(), frame.ctrl(), &ones).expect("as long as before")
        }),
        A::ResetPose => ignores_ids(&[11]),
        A::UntimelyResetPose => sets(|arm, set, _| {
            if let Set::ResetPose(reset) = set {
                reset.rear_arm_angle %= 360.0;
                tell(arm, &Set::QueuedCmdForceStopExec(QueuedCmdForceStopExec {}));
                arm.advance(arm.now().after_micros(1_000_000));
            }
        }),
        A::Identity => replies(|_, reply| {
            let frame = reply.frame();
            let name = frame.params();
            if frame.id() > 1 || name.len() < 4 {
                return reply;
            }
            let cut = [&name[..3], &[0]].concat();
            FrameBuf::new(frame.id(), frame.ctrl(), &cut).expect("shorter")
        }),
        A::Version => profile(|profile| profile.identity.version[2] = 15),
        A::Clock => {
            reports::<DeviceTime>(|arm, time| time.g_systick = arm.now().as_micros() as u32)
        }
        A::DeviceIdWords => profile(|profile| profile.identity.device_id_seed += 1),
        A::FlashKeeps => {
            let ratios = Cell::new(None);
            events(move |arm, event| {
                if event == ExternalEvent::Reset {
                    ratios.set(Some(ask::<PtpCommonParams>(arm)));
                    arm.inject(event);
                    tell(arm, &Set::PtpCommonParams(ratios.take().expect("asked")));
                    return false;
                }
                true
            })
        }
        A::ResetAlarm => profile(|profile| profile.power_up.reset_alarm = false),
        A::Parameters => profile(|profile| {
            profile.defaults.ptp.joint_velocity[2] = 201.0;
            profile.defaults.ptp.z_limit = 101.0;
            profile.defaults.ptp.velocity_ratio = 51.0;
            profile.defaults.jog.coordinate_velocity[0] = 61.0;
            profile.defaults.jog.joint_velocity[0] = 16.0;
            profile.defaults.cp.junction_velocity = 99.0;
            profile.defaults.arc.linear_velocity = 201.0;
        }),
        A::CappedWhenSet => profile(|profile| profile.ceilings.linear_velocity = 2000.0),
        A::BeyondCeilings => sets(|_, set, _| {
            if let Set::PtpCommonParams(ratios) = set {
                ratios.velocity_ratio = ratios.velocity_ratio.min(100.0);
            }
        }),
        A::RailDefaults => profile(|profile| {
            profile.defaults.ptp.rail_velocity = 50.0;
            profile.defaults.jog.rail_velocity = 50.0;
        }),
        A::JumpSetsBoth => sets(|arm, set, _| {
            if let Set::PtpJumpParams(PtpJumpParams { jump_height, .. }) = *set {
                let before: PtpJump2Params = ask(arm);
                *set = Set::PtpJump2Params(PtpJump2Params {
                    start_jump_height: jump_height,
                    ..before
                });
            }
        }),
        A::StoredWithoutEffect => ignores_ids(&[32, 50, 93, 94, 140, 141, 142]),
        A::OutsideTheDocument => ignores_ids(&[161, 182, 191]),
        A::PtpTime => reports::<PtpTime>(|_, time| time.ptp_time *= 2),
        A::MotionFinish => reports::<QueuedCmdMotionFinish>(|_, finish| {
            finish.is_finish = (!finish.is_finish.is_on()).into();
        }),
        A::WifiSettings => ignores_ids(&[150, 151, 152, 153, 154, 155, 156]),
        A::WifiDefaults => profile(|profile| {
            profile.defaults.wifi.dhcp = false;
            profile.defaults.wifi.netmask = [255, 255, 255, 0];
        }),
        A::WifiStatus => profile(|profile| profile.wifi.association = 100.0),
        A::HomePoint => sets(|_, set, _| {
            if let Set::HomeParams(home) = set {
                home.y += 5.0;
            }
        }),
        A::HomeUnset => {
            let is_home_set = Cell::new(false);
            replies(move |_, reply| {
                let frame = reply.frame();
                if frame.id() != HomeParams::ROW.id {
                    return reply;
                }
                is_home_set.set(is_home_set.get() || frame.ctrl().write());
                if is_home_set.get() {
                    return reply;
                }
                let zeros = vec![0; frame.params().len()];
                FrameBuf::new(frame.id(), frame.ctrl(), &zeros).expect("as long as before")
            })
        }
        A::HomeUnchecked => ignores(|arm, set, _| match *set {
            Set::HomeParams(HomeParams { x, y, z, r }) => !is_reached(arm, [x, y, z, r]),
            _ => false,
        }),
        A::HomeOutOfReach => after(|arm, request| {
            let HomeParams { x, y, z, r } = ask(arm);
            let homes = matches!(request, Request::Queue(Set::HomeCmd(_)));
            if homes && !is_reached(arm, [x, y, z, r]) {
                arm.inject(ExternalEvent::Alarm(Alarm::PlanInvCalc));
            }
        }),
        A::HomingSequence => sets(|_, set, _| {
            if let Set::HomeCmd(_) = set {
                *set = Set::PtpCmd(PtpCmd {
                    ptp_mode: PtpMode::MovjAngle,
                    x: 0.0,
                    y: 45.0,
                    z: 45.0,
                    r: 0.0,
                });
            }
        }),
        A::HomingFigures => profile(|profile| profile.home.back_off = 3.0),
        _ => return None,
    })
}

/// True if a pose can be reached. For any other pose the arm reports a move of 0 ms.
fn is_reached(arm: &mut Controller, [x, y, z, r]: [f32; 4]) -> bool {
    let ptp_mode = PtpMode::MovjXyz;
    let query = GetPtpTime {
        ptp_mode,
        x,
        y,
        z,
        r,
    };
    ask_with::<PtpTime>(arm, &query).ptp_time > 0
}
