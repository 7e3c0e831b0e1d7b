//! Stops that are asked for from outside of any task.

use std::time::Duration;

use magician_protocol::NoArgs;
use magician_protocol::commands::Pose;
use tokio::time::Instant;

use super::{Driver, To};
use crate::arm::gate::motors_off;
use crate::arm::halt::Waiter;
use crate::connection::Request;
use crate::{Error, Result};

/// How long a stop is said again on a line that loses it, also when its caller has gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// A stop whose answers are awaited.
pub(super) struct Halting {
    number: u64,
    /// Answers that have not come.
    left: usize,
    outcome: Result<()>,
    waiters: Vec<Waiter>,
}

impl Driver {
    /// Stops the arm at once, and tells these when it has confirmed that.
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
        let deadline = Instant::now() + PATIENCE;
        for request in requests {
            self.submit(request, deadline, To::Halt(self.halts));
        }
        for (request, held) in motors {
            // That the arm has a motor which nothing here started does not decide whether it has stopped.
            let to = if held {
                To::Halt(self.halts)
            } else {
                To::Nobody
            };
            self.submit(request, deadline, to);
        }
        // Where a burn goes on: see `lights_out`.
        if let (true, Ok(look)) = (burns, Request::get::<Pose>(&NoArgs)) {
            self.submit(look, deadline, To::Nobody);
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
            // One that the line has swallowed is said again when it is back.
            let lost = !self.link_is_up();
            self.owes_halt |= lost && done.outcome.is_err();
            if let Err(error) = &done.outcome {
                tracing::warn!("{}: a stop was not confirmed: {error}", self.shared.name);
            }
            done.tell();
        }
    }

    /// No handle is left to stop the arm.
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
