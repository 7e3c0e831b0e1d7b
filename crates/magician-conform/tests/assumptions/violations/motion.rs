//! Violations of the assumptions about point-to-point moves, the rail, continuous paths, arcs and
//! jogs.

use std::cell::Cell;

use magician_protocol::commands::*;
use magician_protocol::{CpMode, FrameBuf, JogCommand, PoCmd, PoList, PtpMode, Request};
use magician_sim::fidelity::Assumption as A;
use magician_sim::{Controller, ExternalEvent};

use super::{
    after, current_index, hides, ignores, ignores_ids, profile, ptp, replies, reports, sets,
};
use crate::arm::{Violation, ask, tell};

const FORCE_STOP: Set = Set::QueuedCmdForceStopExec(QueuedCmdForceStopExec {});

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        // Ramps longer than at the configured acceleration, because the ceilings are lower.
        A::PtpLaw => profile(|profile| {
            profile.ceilings.joint_acceleration = 50.0;
            profile.ceilings.linear_acceleration = 50.0;
        }),
        // Ignores settings that arrive while a move waits in the queue.
        A::PlannedAtStart => ignores(|arm, set, queued| {
            !queued && matches!(set.row().id, 80..=83 | 87) && arm.state().queue.waiting > 0
        }),
        A::ReplacedMotion => ignores(|arm, set, queued| {
            !queued && matches!(set, Set::PtpCmd(_)) && arm.state().moving
        }),
        A::QueueMeanwhile => after(|arm, request| {
            if matches!(request, Request::Set(Set::PtpCmd(_))) && arm.state().queue.started {
                tell(arm, &Set::QueuedCmdStopExec(QueuedCmdStopExec {}));
            }
        }),
        A::UnknownMode => hides(&[0x01]),
        A::ModeSeven => modes(&[(PtpMode::MovlXyzInc, PtpMode::MovjAngleInc)]),
        A::ModeNine => modes(&[(PtpMode::JumpMovlXyz, PtpMode::MovlXyzInc)]),
        A::JumpPath => modes(&[
            (PtpMode::JumpXyz, PtpMode::MovjXyz),
            (PtpMode::JumpAngle, PtpMode::MovjAngle),
            (PtpMode::JumpMovlXyz, PtpMode::MovlXyz),
        ]),
        A::JumpAboveLimit => after(|arm, request| {
            let PtpJump2Params { z_limit, .. } = ask(arm);
            let jump = |mode| matches!(mode, PtpMode::JumpXyz | PtpMode::JumpMovlXyz);
            if let Request::Queue(Set::PtpCmd(PtpCmd { ptp_mode, z, .. })) = *request
                && jump(ptp_mode)
                && z > z_limit
            {
                arm.inject(ExternalEvent::Alarm(0x15));
            }
        }),
        A::UnequalJump => sets(|_, set, _| {
            if let Set::PtpJump2Params(heights) = set {
                heights.end_jump_height = heights.start_jump_height;
            }
        }),
        A::ShortMove => sets(|arm, set, _| {
            let joints = arm.state().joints.to_array().map(|angle| angle as f32);
            if let Some(PtpCmd {
                ptp_mode: PtpMode::MovjAngle,
                x,
                y,
                z,
                r,
            }) = ptp(set).copied()
                && [x, y, z, r] == joints
            {
                arm.inject(ExternalEvent::Alarm(0x13));
            }
        }),
        A::OutputShare => sets(|_, set, _| {
            if let Set::PtpPoCmd(moves) = set {
                let half_ratio = |output: &PoCmd| PoCmd {
                    ratio: output.ratio / 2,
                    ..*output
                };
                let outputs: Vec<PoCmd> = moves.po.as_slice().iter().map(half_ratio).collect();
                moves.po = PoList::new(&outputs).expect("as many as before");
            }
        }),
        A::RailSwitch => ignores_ids(&[3]),
        A::RailIgnored => {
            ignores(|arm, set, _| matches!(set, Set::PtpWithLCmd(_)) && arm.state().rail.is_none())
        }
        A::RailPose => reports::<PoseL>(|_, pose| pose.pose_l += 1.0),
        // The rail begins after the arm has finished.
        A::RailWithArm => reports::<PoseL>(|arm, pose| {
            if arm.state().moving {
                pose.pose_l = 0.0;
            }
        }),
        A::RailRamps => profile(|profile| profile.defaults.ptp.rail_velocity = 50.0),
        A::RailHome => reports::<PoseL>(|arm, pose| {
            if arm.state().homed {
                pose.pose_l = 100.0;
            }
        }),
        A::RailEnds => ignores(|_, set, _| match set {
            Set::PtpWithLCmd(PtpWithLCmd { l, .. }) => *l > 1000.0,
            _ => false,
        }),
        // `CpLaw`: each segment ends at rest. `CpFollows`: only a segment that arrives while the
        // arm moves.
        A::CpLaw => segments(|_| true),
        A::CpFollows => segments(|arm| arm.state().moving),
        // J4 turns against J1 along a path, so that r stays 0.
        A::CpRotation => {
            let on_a_path = Cell::new(false);
            replies(move |_, reply| {
                let frame = reply.frame();
                match (frame.id(), frame.read::<Pose>()) {
                    (91, _) => on_a_path.set(true),
                    (84, _) => on_a_path.set(false),
                    (10, Ok(pose)) if on_a_path.get() => {
                        let kept = Pose { r: 0.0, ..pose };
                        return FrameBuf::encode(10, frame.ctrl(), &kept).expect("fits");
                    }
                    _ => {}
                }
                reply
            })
        }
        A::CpLaser => sets(|_, set, _| {
            if let Set::CpLeCmd(segment) = set {
                segment.velocity_or_power /= 2.0;
            }
        }),
        A::CpTimes => profile(|profile| profile.motion.period = 0.0),
        A::CpStops => sets(|_, set, _| {
            if let Set::QueuedCmdStopExec(_) = set {
                *set = FORCE_STOP;
            }
        }),
        A::ArcPath => sets(|_, set, _| {
            if let Set::ArcCmd(ArcCmd {
                to_point: [x, y, z, r],
                ..
            }) = *set
            {
                let ptp_mode = PtpMode::MovlXyz;
                *set = Set::PtpCmd(PtpCmd {
                    ptp_mode,
                    x,
                    y,
                    z,
                    r,
                });
            }
        }),
        A::ArcPoints => hides(&[0x13, 0x14]),
        A::ArcSpeeds => sets(|arm, set, _| {
            if let Set::ArcCmd(_) = set {
                with_arc_speeds(arm);
            }
        }),
        A::ArcRatio => ignores_ids(&[103]),
        A::CircleTurns => sets(|_, set, _| {
            if let Set::CircleCmd(CircleCmd {
                cir_point,
                to_point,
                ..
            }) = *set
            {
                *set = Set::ArcCmd(ArcCmd {
                    cir_point,
                    to_point,
                });
            }
        }),
        A::Jog => sets(|arm, set, _| {
            if matches!(
                set,
                Set::JogCmd(JogCmd {
                    cmd: JogCommand::Stop,
                    ..
                })
            ) && arm.jogging()
            {
                tell(arm, &FORCE_STOP);
            }
        }),
        // A jog of another axis is ignored, and the current axis continues.
        A::JogAxisChange => {
            let first = Cell::new(None);
            ignores(move |arm, set, _| {
                let Set::JogCmd(JogCmd { cmd, .. }) = set else {
                    return false;
                };
                let axis = u8::from(*cmd).div_ceil(2);
                let changes = arm.jogging() && axis > 0 && first.get() != Some(axis);
                first.set(Some(first.get().filter(|_| changes).unwrap_or(axis)));
                changes
            })
        }
        A::UnknownJog => ignores(|_, set, _| match set {
            Set::JogCmd(JogCmd { cmd, .. }) => matches!(cmd, JogCommand::Unknown(_)),
            _ => false,
        }),
        A::QueuedJog => current_index(|arm, index| *index -= u64::from(arm.jogging())),
        _ => return None,
    })
}

/// Executes moves of one mode in another.
fn modes(pairs: &'static [(PtpMode, PtpMode)]) -> Violation {
    sets(|_, set, _| {
        if let Some(ptp) = ptp(set) {
            let other = pairs.iter().find(|(from, _)| *from == ptp.ptp_mode);
            ptp.ptp_mode = other.map_or(ptp.ptp_mode, |(_, to)| *to);
        }
    })
}

/// Turns some segments of a path into separate moves.
fn segments(selects: fn(&mut Controller) -> bool) -> Violation {
    sets(move |arm, set, _| {
        if let Set::CpCmd(CpCmd {
            cp_mode, x, y, z, ..
        }) = *set
            && selects(arm)
        {
            let ptp_mode = straight_mode(cp_mode);
            let r = 0.0;
            *set = Set::PtpCmd(PtpCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
            });
        }
    })
}

fn straight_mode(mode: CpMode) -> PtpMode {
    match mode {
        CpMode::Relative => PtpMode::MovlXyzInc,
        _ => PtpMode::MovlXyz,
    }
}

/// Copies the speeds and ratios of arcs to those of point-to-point moves, which the virtual arm
/// uses for arcs.
fn with_arc_speeds(arm: &mut Controller) {
    let ArcParams {
        xyz_velocity,
        r_velocity,
        xyz_acceleration,
        r_acceleration,
    } = ask(arm);
    let ArcCommonParams {
        velocity_ratio,
        acceleration_ratio,
    } = ask(arm);
    tell(
        arm,
        &Set::PtpCoordinateParams(PtpCoordinateParams {
            xyz_velocity,
            r_velocity,
            xyz_acceleration,
            r_acceleration,
        }),
    );
    tell(
        arm,
        &Set::PtpCommonParams(PtpCommonParams {
            velocity_ratio,
            acceleration_ratio,
        }),
    );
}
