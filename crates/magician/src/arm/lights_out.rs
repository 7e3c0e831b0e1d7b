//! Where the arm was when this connection put its laser out: a burn that ends before its end goes on there.

use std::time::Duration;

use magician_protocol::commands::{EndEffectorLaser, Pose};
use magician_protocol::{Frame, Readable, Set};

use super::Arm;
use crate::connection::Micros;

/// The first pose that the arm told after the frame that put its laser out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightsOut {
    /// The pose. The laser went out there or before.
    pub pose: Pose,
    /// The longest time by which it went out before: from the frame to the answer with the pose.
    pub late: Duration,
}

/// What is known of it so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Darkness {
    /// When the first frame that puts the laser out began to go out, since the last command for the queue.
    sent: Micros,
    /// The pose was asked for since.
    asked: bool,
    seen: Option<LightsOut>,
}

impl Darkness {
    /// One that begins with a frame which goes out now.
    pub(super) const fn begins(now: Micros) -> Self {
        Self {
            sent: now,
            asked: false,
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
            None => puts_out(request).then(|| Self::begins(now)),
        }
    }

    /// The arm has told where it is.
    pub(super) fn sees(&mut self, now: Micros, pose: Pose) {
        if self.asked && self.seen.is_none() {
            let late = Duration::from_micros(now.saturating_sub(self.sent));
            self.seen = Some(LightsOut { pose, late });
        }
    }

    pub(super) const fn asks(mut self) -> Self {
        self.asked = true;
        self
    }

    /// The pose, once the arm has told it.
    pub(super) const fn seen(&self) -> Option<LightsOut> {
        self.seen
    }
}

/// True if a frame puts the laser out at once.
fn puts_out(request: &Frame<'_>) -> bool {
    if request.id() != <EndEffectorLaser as Readable>::ROW.id || !request.ctrl().write() {
        return false;
    }
    match Set::decode(request.id(), request.params()) {
        Ok(Set::SetEndEffectorLaser(laser)) => !(laser.enable_ctrl.is_on() && laser.on.is_on()),
        _ => false,
    }
}

impl Arm {
    /// Returns where the arm was when this connection put its laser out, if no command was queued since and the arm has told
    /// its pose. A stop asks for the pose directly behind the frame that puts the laser out; no frame is sent here.
    #[must_use]
    pub fn lights_out(&self) -> Option<LightsOut> {
        let darkness = self.inner.shared.known().darkness;
        darkness.and_then(|darkness| darkness.seen())
    }
}
