//! Pose of the arm when this connection put its laser out. A burn that is cut short is resumed there.

use std::time::Duration;

use magician_protocol::commands::{EndEffectorLaser, Pose, QueuedCmdForceStopExec};
use magician_protocol::{Frame, Readable, Set, Writable};

use crate::connection::Micros;

/// The first pose that the arm told after the frame that put its laser out, or stopped it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LightsOut {
    /// The pose.
    pub pose: Pose,
    /// The longest time by which the laser may have gone out before: from the frame to the answer with the pose. It may have gone
    /// out later as well: the controller reports one pose for a period, while the arm goes on to the next.
    pub late: Duration,
    /// True if the frame stopped the arm. Otherwise the arm went on with what was under way, and perhaps with its laser: it is
    /// not known whether every firmware puts out the laser of a path before its end.
    pub stopped: bool,
}

/// State of the connection since it put the laser out.
#[derive(Clone, Copy, Debug)]
pub struct Darkness {
    /// When the first frame that puts the laser out began to go out, since the last command for the queue.
    sent: Micros,
    /// True if the pose was requested since.
    asked: bool,
    /// True if that frame was a forced stop.
    stopped: bool,
    seen: Option<LightsOut>,
}

impl Darkness {
    /// Begins with a frame that goes out now and puts the laser out without a forced stop, and a request for the pose
    /// behind it.
    #[must_use]
    pub const fn with_pose_asked(now: Micros) -> Self {
        Self {
            asked: true,
            ..Self::begins(now, false)
        }
    }

    const fn begins(now: Micros, stopped: bool) -> Self {
        Self {
            sent: now,
            asked: false,
            stopped,
            seen: None,
        }
    }

    /// The state when another frame goes out. A later frame that puts the laser out changes nothing, and a command for the
    /// queue ends it.
    pub(super) fn after(known: Option<Self>, now: Micros, request: &Frame<'_>) -> Option<Self> {
        if request.ctrl().queued() {
            return None;
        }
        match known {
            Some(known) => Some(Self {
                asked: known.asked || request.id() == <Pose as Readable>::ROW.id,
                ..known
            }),
            None => puts_out(request).map(|stopped| Self::begins(now, stopped)),
        }
    }

    /// The arm has told its pose.
    pub fn see(&mut self, now: Micros, pose: Pose) {
        if self.asked && self.seen.is_none() {
            let late = Duration::from_micros(now.saturating_sub(self.sent));
            let stopped = self.stopped;
            self.seen = Some(LightsOut {
                pose,
                late,
                stopped,
            });
        }
    }

    /// The pose, once the arm has told it.
    pub(super) const fn seen(&self) -> Option<LightsOut> {
        self.seen
    }
}

/// True for a forced stop, false for another frame that puts the laser out at once, `None` for all else.
fn puts_out(request: &Frame<'_>) -> Option<bool> {
    if !request.ctrl().write() {
        return None;
    }
    if request.id() == QueuedCmdForceStopExec::ROW.id {
        return Some(true);
    }
    if request.id() != <EndEffectorLaser as Readable>::ROW.id {
        return None;
    }
    match Set::decode(request.id(), request.params()) {
        Ok(Set::SetEndEffectorLaser(laser)) => {
            (!(laser.enable_ctrl.is_on() && laser.on.is_on())).then_some(false)
        }
        _ => None,
    }
}
