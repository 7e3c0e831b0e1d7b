//! Shutdown: the last frames after the last handle is gone.

use std::sync::atomic::Ordering;
use std::time::Duration;

use tokio::time::Instant;

use super::{Driver, ReplyTarget, command_name};
use crate::Error;
use crate::arm::gate::motors_off;
use crate::arm::link::Link;
use crate::connection::Request;

/// Time for the arm to confirm the stop of an ending connection. Choice: dropping the last handle
/// of a blocking arm waits this long at most.
pub(crate) const SHUTDOWN: Duration = Duration::from_millis(500);

impl Driver {
    /// Queues the frames that stop this connection's motion; false if there is nothing to send, or
    /// no line.
    pub(super) fn say_farewell(&mut self) -> bool {
        self.leaving = true;
        self.messages.close();
        let deadline = Instant::now() + SHUTDOWN;
        let requests = if self.is_to_halt() {
            self.stop_requests()
        } else {
            self.last_requests()
        };
        self.end_program(Err(Error::closed()));
        self.leave_unanswered();
        self.close_jogs();
        if !self.link_is_up() {
            self.warn_of_what_goes_on();
            return false;
        }
        for request in requests {
            self.submit(request, deadline, ReplyTarget::Discard);
        }
        !self.waiting.is_empty()
    }

    /// True if a stop was requested and not confirmed. It is completed, also if the handles were
    /// dropped before.
    fn is_to_halt(&mut self) -> bool {
        let asked = self.shared.is_halt_asked() || self.owes_halt || !self.halting.is_empty();
        if asked {
            // A stop overrides an earlier detach.
            self.shared.detached.store(false, Ordering::SeqCst);
        }
        asked
    }

    /// Drops all reply receivers. Queued commands that may have reached the arm are reported as
    /// uncertain.
    fn leave_unanswered(&mut self) {
        for one in self.waiting.drain(..) {
            let request = one.request.frame();
            if let (ReplyTarget::Caller(reply), true) = (one.to, request.ctrl().queued()) {
                let error = Error::uncertain(None, None);
                // Only queued commands: an unanswered read or setting ends with the closed channel.
                let _ = reply.send(Err(error.with_command(command_name(&request))));
            }
        }
    }

    fn last_requests(&self) -> Vec<Request> {
        // Detached on purpose: motion and laser are left as they are.
        if self.shared.detached.load(Ordering::SeqCst) {
            return Vec::new();
        }
        let moving = self.shared.picture().motion().is_moving();
        let laser = self.shared.picture().may_be_lit();
        let turning = self.shared.held_motors(moving);
        let motors = motors_off().filter(move |(output, _)| turning.contains(output));
        let motors = motors.map(|(_, request)| request);
        let Ok([stop, laser_off, clear]) = Request::halt() else {
            return Vec::new();
        };
        let wanted = [(moving, stop), (laser, laser_off), (moving, clear)];
        let wanted = wanted.into_iter().filter(|(wanted, _)| *wanted);
        let wanted = wanted.map(|(_, request)| request);
        let pins = self.shared.lowered_pins();
        wanted.chain(pins).chain(motors).collect()
    }

    /// Returns the requests that stop the arm and its motors, and switch its laser off.
    pub(super) fn stop_requests(&self) -> Vec<Request> {
        let stop = Request::halt().into_iter().flatten();
        stop.chain(self.shared.behind_halt()).collect()
    }

    /// Returns the first requests on a reconnected line if the laser may have burnt meanwhile:
    /// laser off, queue paused. Empty if it cannot have.
    pub(super) fn laser_off_requests(&self) -> Vec<Request> {
        if !self.shared.picture().may_be_lit() {
            return Vec::new();
        }
        let laser_off = Request::laser_off().into_iter().flatten();
        laser_off.chain(self.shared.lowered_pins()).collect()
    }

    /// Warns that the arm may continue, because the stop was not sent or not confirmed.
    pub(super) fn warn_of_what_goes_on(&self) {
        // A refused connection has started nothing, and the refusing end is responsible for the
        // rest.
        if !self.is_refused() && !self.last_requests().is_empty() {
            tracing::warn!(
                "{}: the connection ends, but the arm has not confirmed the stop: it may finish \
                    its queue, a jog may go on, a laser may stay on, a motor may run on",
                self.shared.name
            );
        }
    }
}

impl Drop for Driver {
    /// Writes as much as possible if the runtime ends before the shutdown is complete.
    fn drop(&mut self) {
        if !self.leaving || !self.waiting.is_empty() {
            let requests = self.last_requests();
            match self.line.wire() {
                Some(wire) => wire.blurt(requests.iter().map(|request| *request.frame())),
                None => self.warn_of_what_goes_on(),
            }
        }
        // A caller that waits for the end may reopen the port, so it has to be closed before.
        self.line.let_go();
        self.close_jogs();
        self.publish_link(Link::Closed);
        self.refuse_halts();
    }
}
