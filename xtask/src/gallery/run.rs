//! Runs a mode on a virtual arm and looks at it every few milliseconds.

use std::time::Duration;

use magician_motion::{JointAngles, Pose};
use magician_protocol::{Ctrl, FrameBuf, Set};
use magician_sim::{ArmInstant, Controller, ControllerState, LinkId};

use super::modes::{Act, Mode};

/// Between two looks.
const LOOK: Duration = Duration::from_millis(2);
/// Looks in a picture.
const MOST_LOOKS: usize = 400;
/// The longest run; one that never ends is a mistake in the mode.
const LONGEST: Duration = Duration::from_secs(120);

const USB: LinkId = LinkId(0);

/// The arm at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) at: f64,
    pub(super) pose: Pose,
    pub(super) joints: JointAngles,
    pub(super) rail: f64,
}

/// What was seen, in order.
pub(super) struct Run {
    pub(super) looks: Vec<Sample>,
}

impl Run {
    /// How long the arm moved.
    pub(super) fn seconds(&self) -> f64 {
        self.looks.last().map_or(0.0, |last| last.at)
    }
}

fn send(arm: &mut Controller, set: &Set, ctrl: Ctrl) {
    let frame = FrameBuf::set(set, ctrl).expect("the modes hold what fits a frame");
    arm.exchange(USB, frame.bytes());
}

/// Runs it from its start to where everything rests.
pub(super) fn run(mode: &Mode) -> Run {
    // The pictures show the wrist.
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

/// As many looks as a picture can show, the first and the last among them.
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

/// Looks on for a span, or until nothing is scheduled any more.
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
        // Without one it stands still.
        rail: state.rail.unwrap_or(0.0),
    }
}
