//! Runs a mode on a virtual arm and samples its state every few milliseconds.

use std::time::Duration;

use magician_motion::{JointAngles, Pose};
use magician_protocol::{Ctrl, FrameBuf, Set};
use magician_sim::{ArmInstant, Controller, ControllerState, LinkId};

use super::modes::{Act, Mode};

/// Interval of samples.
const LOOK: Duration = Duration::from_millis(2);
/// Largest number of samples in a picture.
const MOST_LOOKS: usize = 400;
/// Longest run. A longer one means that the mode never ends, which is a mistake in it.
const LONGEST: Duration = Duration::from_secs(120);

const USB: LinkId = LinkId(0);

/// State of the arm at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) at: f64,
    pub(super) pose: Pose,
    pub(super) joints: JointAngles,
    pub(super) rail: f64,
}

/// Samples in order.
pub(super) struct Run {
    pub(super) looks: Vec<Sample>,
}

impl Run {
    /// Returns the duration of the motion, s.
    pub(super) fn seconds(&self) -> f64 {
        self.looks.last().map_or(0.0, |last| last.at)
    }
}

fn send(arm: &mut Controller, set: &Set, ctrl: Ctrl) {
    let frame = FrameBuf::set(set, ctrl).expect("the modes hold what fits a frame");
    arm.exchange(USB, frame.bytes());
}

/// Runs a mode until everything rests.
pub(super) fn run(mode: &Mode) -> Run {
    // The pictures show the wrist, so no tool is mounted.
    let mut arm = Controller::default().with_tool(magician_motion::ToolBias::NONE);
    let clear = Set::ClearAllAlarmsState(magician_protocol::commands::ClearAllAlarmsState {});
    send(&mut arm, &clear, Ctrl::SET);
    let start = Set::QueuedCmdStartExec(magician_protocol::commands::QueuedCmdStartExec {});
    send(&mut arm, &start, Ctrl::SET);
    for set in (mode.before)() {
        send(&mut arm, &set, Ctrl::QUEUED);
    }
    rest(&mut arm);
    let began = arm.now();
    let mut looks = vec![look(&arm.state(), began)];
    for act in (mode.acts)() {
        match act {
            Act::Queue(set) => send(&mut arm, &set, Ctrl::QUEUED),
            Act::Now(set) => send(&mut arm, &set, Ctrl::SET),
            Act::Pass(span) => watch(&mut arm, began, Some(span), &mut looks),
        }
    }
    watch(&mut arm, began, None, &mut looks);
    Run {
        looks: thinned(&looks),
    }
}

/// Reduces samples to the number that a picture can show, keeping the first and the last.
fn thinned(looks: &[Sample]) -> Vec<Sample> {
    let step = looks.len() / MOST_LOOKS + 1;
    let last = looks.len().saturating_sub(1);
    let keep = |at: &usize| at.is_multiple_of(step) || *at == last;
    let kept = looks.iter().enumerate().filter(|(at, _)| keep(at));
    kept.map(|(_, look)| *look).collect()
}

fn rest(arm: &mut Controller) {
    while let Some(at) = arm.poll_timeout() {
        arm.advance(at);
    }
}

/// Samples for a span, or until nothing is scheduled any more.
fn watch(arm: &mut Controller, began: ArmInstant, span: Option<Duration>, looks: &mut Vec<Sample>) {
    let end = arm.now() + span.unwrap_or(LONGEST);
    while arm.now() < end && (span.is_some() || arm.poll_timeout().is_some()) {
        let next = arm.now() + LOOK;
        arm.advance(next.min(end));
        looks.push(look(&arm.state(), began));
    }
}

fn look(state: &ControllerState, began: ArmInstant) -> Sample {
    Sample {
        at: (state.now - began).as_secs_f64(),
        pose: state.pose,
        joints: state.joints,
        // Without a rail the carriage stands at 0.
        rail: state.rail.unwrap_or(0.0),
    }
}
