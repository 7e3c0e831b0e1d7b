//! Stops requested from outside of any task, through a [`Stopper`](crate::Stopper).

use std::time::Duration;

use magician_protocol::NoArgs;
use magician_protocol::commands::Pose;
use tokio::time::Instant;

use super::{Driver, ReplyTarget};
use crate::arm::gate::motors_off;
use crate::arm::halt::Waiter;
use crate::connection::Request;
use crate::{Error, Result};

/// Time for which a stop is retransmitted on a lossy line, also after its caller has gone. Choice:
/// as the default timeout of a call.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);

/// A stop in progress.
pub(super) struct Halting {
    number: u64,
    /// Missing answers.
    left: usize,
    outcome: Result<()>,
    waiters: Vec<Waiter>,
}

impl Driver {
    /// Stops the arm immediately, and notifies the waiters once the stop is confirmed.
    pub(super) fn halt(&mut self, waiters: Vec<Waiter>) {
        self.owes_halt = false;
        let held = self.shared.held_motors(true);
        let burns = self.shared.picture().may_be_lit();
        let pins = self.shared.lowered_pins();
        let requests: Vec<_> = { Request::halt().into_iter().flatten() }
            .chain(pins)
            .collect();
        let motors: Vec<_> = motors_off()
            .map(|(output, request)| (request, held.contains(&output)))
            .collect();
        let counted = motors.iter().filter(|(_, held)| *held).count();
        self.halts += 1;
        self.halting.push(Halting {
            number: self.halts,
            left: requests.len() + counted,
            outcome: Ok(()),
            waiters,
        });
        let deadline = Instant::now() + ANSWER_TIMEOUT;
        for request in requests {
            self.submit(request, deadline, ReplyTarget::Halt(self.halts));
        }
        for (request, held) in motors {
            // The answer of a motor output that this connection did not start does not decide if
            // the arm has stopped.
            let to = if held {
                ReplyTarget::Halt(self.halts)
            } else {
                ReplyTarget::Discard
            };
            self.submit(request, deadline, to);
        }
        // The pose shows where to resume a burn (`lights_out`).
        if let (true, Ok(look)) = (burns, Request::get::<Pose>(&NoArgs)) {
            self.submit(look, deadline, ReplyTarget::Discard);
        }
    }

    pub(super) fn halt_answered(&mut self, number: u64, answer: Result<()>) {
        let Some(at) = self.halting.iter().position(|one| one.number == number) else {
            return;
        };
        let Some(one) = self.halting.get_mut(at) else {
            return;
        };
        if one.outcome.is_ok() {
            one.outcome = answer;
        }
        one.left = one.left.saturating_sub(1);
        if one.left == 0 {
            let done = self.halting.swap_remove(at);
            // A stop lost with the line is sent again after a reconnect.
            let lost = !self.link_is_up();
            self.owes_halt |= lost && done.outcome.is_err();
            if let Err(error) = &done.outcome {
                tracing::warn!("{}: a stop was not confirmed: {error}", self.shared.name);
            }
            done.tell();
        }
    }

    /// Refuses pending stops: no handle is left to stop the arm.
    pub(super) fn refuse_halts(&mut self) {
        for waiter in self.shared.take_halt().unwrap_or_default() {
            waiter.tell(Err(Error::closed()));
        }
    }
}

impl Halting {
    fn tell(self) {
        let copy = |outcome: &Result<()>| match outcome {
            Ok(()) => Ok(()),
            Err(error) => Err(error.copy()),
        };
        for waiter in self.waiters {
            waiter.tell(copy(&self.outcome));
        }
    }
}
