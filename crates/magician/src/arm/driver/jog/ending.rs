//! Ending the arm's own jog.
//!
//! The driver repeats the stop until rest is confirmed. It sends a JOGCmd stop that bypasses the
//! queue, and repeats it if unanswered. Then it reads positions, and sends the stop again while
//! they still differ, until they are those of an arm at rest. A lost line does not end this: it
//! continues on the next one.

use magician_protocol::commands::{JogCmd, Pose, PoseL};
use magician_protocol::{Flag, FrameBuf, JogCommand, Layout};

use super::ANSWER_TIMEOUT;
use super::looks::place_request;
use crate::arm::driver::{Driver, ReplyTarget};
use crate::build::Axis;
use crate::connection::{Micros, Priority, Request};
use crate::{REST_READ_INTERVAL, RestDetector, Result};

/// Pause after a request that failed immediately. Choice, against a busy loop.
const RETRY_PAUSE: Micros = 50_000;
/// Time after which an answered stop without effect is sent again.
const STOP_REPEAT_INTERVAL: Micros = 500_000;
/// Time after the first answer at which motion has another cause. Choice: as the braking time of
/// any stop.
const MAX_BRAKING_TIME: Micros = 5_000_000;

/// Progress of ending a jog.
#[derive(Default)]
pub(super) struct Ending {
    /// True if the rail has to come to rest, which the pose does not show.
    rail: bool,
    /// True while a stop or a read is in flight.
    under_way: bool,
    /// True if the stop was not answered. A read then precedes the next stop: its answer proves
    /// that no reply to the lost stop can arrive, so the next reply belongs to the next stop.
    unheard: bool,
    /// Time of the next action.
    at: Micros,
    /// Time of the last answered stop, and of the first.
    said: Option<Micros>,
    first: Option<Micros>,
    rest: RestDetector,
}

impl Ending {
    /// Creates the ending of a jog on this axis.
    pub(super) fn of(axis: Axis) -> Self {
        Self {
            rail: axis == Axis::L,
            ..Self::default()
        }
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        (!self.under_way).then_some(self.at)
    }

    /// Forgets the answered stop, so that it is sent again.
    fn mark_unsent(&mut self) {
        *self = Self {
            rail: self.rail,
            first: self.first,
            ..Self::default()
        };
    }

    /// Decodes a position. For the rail, its position takes the place of x in a pose, so that one
    /// detector serves both.
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
        // After an unanswered stop too: see `unheard`.
        let look = ending.said.is_some() || ending.unheard;
        let rail = ending.rail;
        let deadline = self.at(now.saturating_add(ANSWER_TIMEOUT));
        let (request, to) = if look {
            (place_request(rail), ReplyTarget::JogPose)
        } else {
            (stop().ok(), ReplyTarget::JogStop)
        };
        if let Some(request) = request {
            self.submit(request, deadline, to);
        }
    }

    /// Handles the end of a stop request.
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
            // No answer: its reply may still come, and must not be taken for that of the next stop.
            Err(_) => {
                ending.unheard = true;
                ending.at = now.saturating_add(RETRY_PAUSE);
            }
        }
    }

    /// Handles the end of a position read.
    pub(in crate::arm::driver) fn jog_pose(&mut self, answer: Result<FrameBuf>) {
        let now = self.now();
        let Some(ending) = &mut self.jogging.ending else {
            return;
        };
        ending.under_way = false;
        let Some(pose) = ending.pose(answer) else {
            // The read failed as well, so skip it: perhaps the stop gets through.
            ending.unheard = false;
            ending.at = now.saturating_add(RETRY_PAUSE);
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
        if since(ending.first) >= MAX_BRAKING_TIME {
            tracing::warn!(
                "{}: the arm still moves after a jog was stopped",
                self.shared.name
            );
            // The stop was answered; the motion belongs to another program or to a hand.
            return self.jog_is_over(false);
        }
        if since(ending.said) >= STOP_REPEAT_INTERVAL {
            ending.mark_unsent();
        }
        ending.at = now.saturating_add(REST_READ_INTERVAL);
    }

    fn jog_is_over(&mut self, seen: bool) {
        if seen {
            let stops = self.shared.picture().motion().stops();
            self.shared.stood_after(stops);
        }
        self.shared.gate().finish_stop(seen);
        self.carry_out_gate();
    }
}

/// Returns the stop of a jog. It bypasses the queue: a queued one would wait behind an alarm while
/// the arm moves on.
fn stop() -> Result<Request, magician_protocol::EncodeError> {
    let stop = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Stop,
    };
    Ok(Request::set(&stop)?.priority(Priority::Stop))
}
