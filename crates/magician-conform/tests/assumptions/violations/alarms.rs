//! Violations of the assumptions about alarms and limits, lost steps, teaching by hand, keys, and
//! programs in the flash.

use std::cell::Cell;

use magician_protocol::commands::*;
use magician_protocol::{AlarmSet, FrameBuf, PtpMode, Request};
use magician_sim::fidelity::Assumption as A;
use magician_sim::world::Press;
use magician_sim::{Controller, ExternalEvent, LimitChoice};

use super::{
    after, current_index, events, hides, ignores, ignores_ids, profile, ptp, replies, reports,
    requests, time,
};
use crate::arm::{Fate, Violation, tell};

pub(super) fn violation(assumption: A) -> Option<Violation> {
    Some(match assumption {
        A::AlarmBits => replies(|_, reply| {
            let frame = reply.frame();
            if frame.id() != 20 {
                return reply;
            }
            let turned: Vec<u8> = frame
                .params()
                .iter()
                .map(|byte| byte.reverse_bits())
                .collect();
            FrameBuf::new(frame.id(), frame.ctrl(), &turned).expect("as long as before")
        }),
        A::ClearAlarms => ignores_ids(&[20]),
        A::ClearBy21 => ignores_ids(&[21]),
        A::AlarmHold => profile(|profile| profile.queue.alarms_hold = false),
        A::QuietAlarms => after(|arm, _| {
            if arm.state().alarms.codes().any(|code| code < 8) {
                tell(arm, &Set::QueuedCmdStopExec(QueuedCmdStopExec {}));
            }
        }),
        A::LatchedHold => time(|arm| {
            let state = arm.state();
            if state.queue.held && state.alarms.codes().next().is_none() {
                tell(arm, &Set::ClearAlarmsState(ClearAlarmsState {}));
            }
        }),
        A::LimitDrops => {
            let latched = Cell::new(AlarmSet::default());
            replies(move |_, reply| {
                let frame = reply.frame();
                if ![20, 21].contains(&frame.id()) {
                    return reply;
                }
                let Ok(AlarmsState { alarms_state }) = frame.read() else {
                    latched.set(AlarmSet::default());
                    return reply;
                };
                latched.set(latched.get().codes().chain(alarms_state.codes()).collect());
                let alarms_state = latched.get();
                let told = AlarmsState { alarms_state };
                FrameBuf::encode(frame.id(), frame.ctrl(), &told).expect("as long as before")
            })
        }
        A::ImmediateWhileHeld => ignores(|arm, set, queued| {
            !queued && matches!(set, Set::PtpCmd(_)) && arm.state().queue.held
        }),
        A::JogWhileHeld => {
            ignores(|arm, set, _| matches!(set, Set::JogCmd(_)) && arm.state().queue.held)
        }
        A::HomeWhileHeld => {
            ignores(|arm, set, _| matches!(set, Set::HomeCmd(_)) && arm.state().queue.held)
        }
        A::TargetChecked => reports_other_codes(&[(0x11, 0x21), (0x12, 0x22)]),
        A::PathChecked => reports_other_codes(&[(0x21, 0x11), (0x22, 0x12)]),
        // Joint targets are checked before the arm moves.
        A::JointTargets => ignores(|arm, set, _| {
            let Some(PtpCmd {
                ptp_mode: PtpMode::MovjAngle,
                x,
                y,
                z,
                r,
            }) = ptp(&mut set.clone()).copied()
            else {
                return false;
            };
            let joints = [x, y, z, r].map(f64::from).into();
            let outside = arm.arm_model().limits.check(&joints).is_err();
            if outside {
                arm.inject(ExternalEvent::Alarm(0x12));
            }
            outside
        }),
        A::SoftLimits => profile(|profile| profile.limits.in_force = LimitChoice::Guaranteed),
        A::RefusedFinishes => {
            current_index(|arm, index| *index -= u64::from(arm.state().queue.held))
        }
        A::NotFinite => ignores(|_, set, _| match *set {
            Set::PtpCmd(PtpCmd { x, y, z, r, .. }) => {
                [x, y, z, r].iter().any(|number| !number.is_finite())
            }
            _ => false,
        }),
        A::NoSpeed => hides(&[0x1A]),
        A::LostSteps => ignores_ids(&[171]),
        A::LostBase => hides(&[0x50]),
        A::TeachKey => {
            events(|_, event| !matches!(event, ExternalEvent::Unlock(_) | ExternalEvent::Guide(_)))
        }
        A::TeachSettings => ignores_ids(&[40, 41]),
        A::PointCleared => {
            let seen = Cell::new(false);
            reports::<HhtTrigOutput>(move |_, point| {
                seen.set(seen.get() || point.is_triggered.is_on());
                point.is_triggered = seen.get().into();
            })
        }
        A::TeachPeriod => profile(|profile| profile.teach.period = 0.8),
        A::MotionWhileUnlocked => current_index(|arm, index| {
            let state = arm.state();
            if state.unlocked {
                *index += state.queue.waiting as u64;
            }
        }),
        A::BaseKey => events(|_, event| event != ExternalEvent::Key(Press::Short)),
        A::BaseKeyHeld => events(|_, event| event != ExternalEvent::Key(Press::Long)),
        A::OfflineProgram => ignores_ids(&[243, 244]),
        A::OfflineMismatch => drops_mismatched(),
        A::OfflineBusy => requests(|arm, frame| {
            if frame.frame().id() == 243 && arm.state().program {
                arm.inject(ExternalEvent::Key(Press::Short));
            }
            Fate::Taken
        }),
        A::StoredLineIndex => {
            let downloading = Cell::new(false);
            replies(move |_, reply| {
                let frame = reply.frame();
                match frame.id() {
                    243 => downloading.set(true),
                    244 => downloading.set(false),
                    _ if downloading.get() && frame.ctrl().queued() => {
                        return FrameBuf::new(frame.id(), frame.ctrl(), &[0; 8]).expect("fits");
                    }
                    _ => {}
                }
                reply
            })
        }
        _ => return None,
    })
}

/// Reports alarms under other codes.
fn reports_other_codes(codes: &'static [(u8, u8)]) -> Violation {
    reports::<AlarmsState>(|_, alarms| {
        let other = |code| {
            codes
                .iter()
                .find(|(from, _)| *from == code)
                .map_or(code, |(_, to)| *to)
        };
        alarms.alarms_state = alarms.alarms_state.codes().map(other).collect();
    })
}

/// Drops a program whose length differs from the announced one.
fn drops_mismatched() -> Violation {
    let (announced, lines) = (Cell::new(0), Cell::new(0));
    after(move |arm, request| match request {
        Request::Set(Set::QueuedCmdStartDownload(start)) => {
            announced.set(start.line_per_loop);
            lines.set(0);
        }
        Request::Queue(_) => lines.set(lines.get() + 1),
        Request::Set(Set::QueuedCmdStopDownload(_)) if lines.get() != announced.get() => {
            store_nothing(arm);
        }
        _ => {}
    })
}

fn store_nothing(arm: &mut Controller) {
    let start = QueuedCmdStartDownload {
        total_loop: 0,
        line_per_loop: 0,
    };
    tell(arm, &Set::QueuedCmdStartDownload(start));
    tell(arm, &Set::QueuedCmdStopDownload(QueuedCmdStopDownload {}));
}
