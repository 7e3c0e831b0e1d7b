//! Runs a mode on a virtual arm and samples its state every few milliseconds.

use std::time::Duration;

use magician_motion::{JointAngles, Pose};
use magician_protocol::{Ctrl, FrameBuf, Set};
use magician_sim::{ArmInstant, Controller, ControllerState, LinkId};

use super::modes::{Mode, Step};

/// Interval of samples.
const SAMPLE_INTERVAL: Duration = Duration::from_millis(2);
/// Largest number of samples in a picture.
const MAX_SAMPLES: usize = 400;
/// Longest run. A longer one means that the mode never ends, which is a mistake in it.
const MAX_DURATION: Duration = Duration::from_secs(120);

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
    pub(super) samples: Vec<Sample>,
}

impl Run {
    /// Returns the duration of the motion, s.
    pub(super) fn seconds(&self) -> f64 {
        self.samples.last().map_or(0.0, |last| last.at)
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
    wait_for_rest(&mut arm);
    let began = arm.now();
    let mut samples = vec![sample(&arm.state(), began)];
    for step in (mode.steps)() {
        match step {
            Step::Queue(set) => send(&mut arm, &set, Ctrl::QUEUED),
            Step::Now(set) => send(&mut arm, &set, Ctrl::SET),
            Step::Pass(span) => take_samples(&mut arm, began, Some(span), &mut samples),
        }
    }
    take_samples(&mut arm, began, None, &mut samples);
    Run {
        samples: thin_out(&samples),
    }
}

/// Reduces samples to the number that a picture can show, keeping the first and the last.
fn thin_out(samples: &[Sample]) -> Vec<Sample> {
    let step = samples.len() / MAX_SAMPLES + 1;
    let last = samples.len().saturating_sub(1);
    let keep = |at: &usize| at.is_multiple_of(step) || *at == last;
    let kept = samples.iter().enumerate().filter(|(at, _)| keep(at));
    kept.map(|(_, sample)| *sample).collect()
}

fn wait_for_rest(arm: &mut Controller) {
    while let Some(at) = arm.poll_timeout() {
        arm.advance(at);
    }
}

/// Samples for a span, or until nothing is scheduled any more.
fn take_samples(
    arm: &mut Controller,
    began: ArmInstant,
    span: Option<Duration>,
    samples: &mut Vec<Sample>,
) {
    let end = arm.now() + span.unwrap_or(MAX_DURATION);
    while arm.now() < end && (span.is_some() || arm.poll_timeout().is_some()) {
        let next = arm.now() + SAMPLE_INTERVAL;
        arm.advance(next.min(end));
        samples.push(sample(&arm.state(), began));
    }
}

fn sample(state: &ControllerState, began: ArmInstant) -> Sample {
    Sample {
        at: (state.now - began).as_secs_f64(),
        pose: state.pose,
        joints: state.joints,
        // Without a rail the carriage stands at 0.
        rail: state.rail.unwrap_or(0.0),
    }
}
