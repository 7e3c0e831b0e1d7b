//! The end of the arm's own jog.
//!
//! The driver repeats the stop until it is certain: past the queue, again when it is not answered, then positions, the stop again
//! while they differ, until they are those of an arm at rest. A line that is lost meanwhile does not end that.

use magician_protocol::commands::{JogCmd, Pose, PoseL};
use magician_protocol::{Flag, FrameBuf, JogCommand, Layout};

use super::PATIENCE;
use super::looks::place_request;
use crate::arm::driver::{Driver, To};
use crate::build::Axis;
use crate::connection::{Micros, Priority, Request};
use crate::{REST_READ_INTERVAL, RestDetector, Result};

/// Pause after something that failed at once.
const PAUSE: Micros = 50_000;
/// A stop that was answered and has no effect for so long is said again.
const AGAIN: Micros = 500_000;
/// An arm that still moves so long after it answered the stop is moved by something else.
const BRAKING: Micros = 5_000_000;

/// How far an end has come.
#[derive(Default)]
pub(super) struct Ending {
    /// True if the rail has to come to rest, which the pose does not show.
    rail: bool,
    /// A stop or a look is out.
    under_way: bool,
    /// The stop was not answered. A read comes before the next one: its answer proves that none to the lost stop can
    /// come, so that the next answer is known for what it is.
    unheard: bool,
    /// When to do the next thing.
    at: Micros,
    /// When the stop was answered last, and for the first time.
    said: Option<Micros>,
    first: Option<Micros>,
    rest: RestDetector,
}

impl Ending {
    /// The end of a jog of this axis.
    pub(super) fn of(axis: Axis) -> Self {
        Self {
            rail: axis == Axis::L,
            ..Self::default()
        }
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        (!self.under_way).then_some(self.at)
    }

    /// Forgets what was said: it has to be said again.
    fn unsay(&mut self) {
        *self = Self {
            rail: self.rail,
            first: self.first,
            ..Self::default()
        };
    }

    /// What was read of the arm; for the rail its position stands for the pose.
    fn pose(&self, answer: Result<FrameBuf>) -> Option<Pose> {
        let reply = answer.ok()?;
        let reply = reply.frame();
        if self.rail {
            let rail = PoseL::decode(reply.params()).ok()?;
            Some(Pose {
                x: rail.pose_l,
                y: 0.0,
                z: 0.0,
                r: 0.0,
                joint_angle: [0.0; 4],
            })
        } else {
            Pose::decode(reply.params()).ok()
        }
    }
}

impl Driver {
    pub(super) fn go_on_ending(&mut self, now: Micros) {
        let ending = self.jogging.ending.as_mut();
        let Some(ending) = ending.filter(|ending| !ending.under_way && ending.at <= now) else {
            return;
        };
        ending.under_way = true;
        let look = ending.said.is_some() || ending.unheard;
        let rail = ending.rail;
        let deadline = self.at(now.saturating_add(PATIENCE));
        let (request, to) = if look {
            (place_request(rail), To::JogPose)
        } else {
            (stop().ok(), To::JogStop)
        };
        if let Some(request) = request {
            self.submit(request, deadline, to);
        }
    }

    /// The stop of a jog was answered, or not.
    pub(in crate::arm::driver) fn jog_stopped(&mut self, answer: Result<FrameBuf>) {
        let now = self.now();
        let Some(ending) = &mut self.jogging.ending else {
            return;
        };
        ending.under_way = false;
        match answer {
            Ok(_) => {
                ending.said = Some(now);
                ending.first.get_or_insert(now);
                ending.at = now;
            }
            Err(_) => {
                ending.unheard = true;
                ending.at = now.saturating_add(PAUSE);
            }
        }
    }

    /// A look at where the arm is has ended.
    pub(in crate::arm::driver) fn jog_pose(&mut self, answer: Result<FrameBuf>) {
        let now = self.now();
        let Some(ending) = &mut self.jogging.ending else {
            return;
        };
        ending.under_way = false;
        let Some(pose) = ending.pose(answer) else {
            // Perhaps the stop gets through.
            ending.unheard = false;
            ending.at = now.saturating_add(PAUSE);
            return;
        };
        if ending.said.is_none() {
            (ending.unheard, ending.at) = (false, now);
            return;
        }
        if ending.rest.see(now, pose) {
            return self.jog_is_over(true);
        }
        let since = |at: Option<Micros>| at.map_or(0, |at| now.saturating_sub(at));
        if since(ending.first) >= BRAKING {
            tracing::warn!(
                "{}: the arm still moves after a jog was stopped",
                self.shared.name
            );
            return self.jog_is_over(false);
        }
        if since(ending.said) >= AGAIN {
            ending.unsay();
        }
        ending.at = now.saturating_add(REST_READ_INTERVAL);
    }

    fn jog_is_over(&mut self, seen: bool) {
        if seen {
            let stops = self.shared.picture().motion().stops();
            self.shared.stood_after(stops);
        }
        self.shared.gate().rested(seen);
        self.carry_out_gate();
    }
}

/// The end of a jog, past the queue: a queued one would sit behind an alarm while the arm moves on.
fn stop() -> Result<Request, magician_protocol::EncodeError> {
    let stop = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Stop,
    };
    Ok(Request::set(&stop)?.priority(Priority::Stop))
}
