//! Pose at which this connection switched the laser off. A burn that was cut short resumes there.

use std::time::Duration;

use magician_protocol::commands::{EndEffectorLaser, Pose, QueuedCmdForceStopExec};
use magician_protocol::{Frame, Readable, Set, Writable};

use crate::connection::Micros;

/// First pose reported after the frame that switched the laser off, or stopped the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LaserOffPose {
    /// Pose of the arm.
    pub pose: Pose,
    /// Longest possible time between the laser going out and this pose: from sending the frame to
    /// the reply with the pose.
    ///
    /// The laser may also have gone out after this pose, because the controller reports one pose
    /// for a whole period while the arm moves on.
    pub late: Duration,
    /// True if the frame stopped the arm. Otherwise the arm continued its current command, and if
    /// that is a path with laser power the laser may have stayed on: it is not known whether every
    /// firmware obeys such a frame before the end of the path.
    pub stopped: bool,
}

/// State of the connection since it switched the laser off.
#[derive(Clone, Copy, Debug)]
pub struct LaserOffTracker {
    /// Instant at which the first frame that switches the laser off was sent, since the last
    /// command for the queue.
    sent: Micros,
    /// True if the pose was requested since.
    asked: bool,
    /// True if that frame was a forced stop.
    stopped: bool,
    seen: Option<LaserOffPose>,
}

impl LaserOffTracker {
    /// Creates the state for a frame that is sent now and switches the laser off without a forced
    /// stop, followed by a request for the pose.
    #[must_use]
    pub const fn with_pose_asked(now: Micros) -> Self {
        Self {
            asked: true,
            ..Self::started(now, false)
        }
    }

    const fn started(now: Micros, stopped: bool) -> Self {
        Self {
            sent: now,
            asked: false,
            stopped,
            seen: None,
        }
    }

    /// State after another frame is sent. Further frames that switch the laser off change nothing;
    /// a command for the queue ends the state.
    pub(super) fn after(known: Option<Self>, now: Micros, request: &Frame<'_>) -> Option<Self> {
        // A queued command may light the laser again at any time.
        if request.ctrl().queued() {
            return None;
        }
        match known {
            Some(known) => Some(Self {
                asked: known.asked || request.id() == <Pose as Readable>::ROW.id,
                ..known
            }),
            None => switches_off(request).map(|stopped| Self::started(now, stopped)),
        }
    }

    /// Processes a pose.
    // A pose requested before the frame may be from before it.
    pub fn see(&mut self, now: Micros, pose: Pose) {
        if self.asked && self.seen.is_none() {
            let late = Duration::from_micros(now.saturating_sub(self.sent));
            let stopped = self.stopped;
            self.seen = Some(LaserOffPose {
                pose,
                late,
                stopped,
            });
        }
    }

    /// Pose at which the laser went out. `None` before the arm has reported one.
    pub(super) const fn seen(&self) -> Option<LaserOffPose> {
        self.seen
    }
}

/// True for a forced stop, false for another frame that switches the laser off immediately. `None`
/// for all others.
fn switches_off(request: &Frame<'_>) -> Option<bool> {
    if !request.ctrl().write() {
        return None;
    }
    // A forced stop ends the path, and with it the laser's power.
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
