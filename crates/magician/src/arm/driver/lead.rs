//! Passing of virtual time while a program runs.
//!
//! An arm in virtual time stands until its clock is advanced. During a run the driver task advances
//! it whenever the task itself is idle: everything the queue accepts is sent, and all answers have
//! arrived. So the arm never waits for its host while the host has commands to send, and a run
//! takes the estimated time to the microsecond. If the host is late (a source without a next
//! command, a line that loses answers), time follows the wall clock instead.

use std::time::Duration;

use super::{Driver, micros};
use crate::connection::Micros;
use crate::transport::{LeapTo, STEP};

/// Time for which the arm's clock waits for a slow command source. Choice: a source that computes
/// is given this long; afterwards time follows the wall clock.
const ANSWER_TIMEOUT: Micros = 1_000_000;

/// State of the virtual clock's driver.
#[derive(Debug, Default)]
pub(super) struct VirtualTimeDriver {
    /// True if this task advances the clock.
    leads: bool,
    /// Time of the next step although the program, or an answer, is late.
    step: Option<Micros>,
    /// Number of commands the program had supplied when `step` was set.
    told: u64,
    /// Time of the next step around an arm at rest whose program has nothing to send.
    rest: Option<Micros>,
}

impl VirtualTimeDriver {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.step.or(self.rest)
    }
}

impl Driver {
    /// Takes the lead over the arm's clock when a program begins. It is kept until the arm is at
    /// rest without a program, so that a stop takes effect before time passes by itself.
    pub(super) fn lead(&mut self) {
        let now = self.now();
        self.leading.leads = self.line.wire().is_some_and(|wire| wire.lead(true));
        if let (true, Some(program)) = (self.leading.leads, &mut self.program) {
            program.stream.leap_clock(now, Duration::ZERO, false);
        }
    }

    /// Lets the arm's time pass if there is nothing else to do; true if any passed.
    pub(super) fn go_on_in_time(&mut self) -> bool {
        if !self.leading.leads {
            return false;
        }
        let now = self.now();
        let mut leap = match self.far(now) {
            Some((most, to)) => (self.line.wire()).and_then(|wire| wire.leap(most, to)),
            None => None,
        };
        if leap.is_none() && self.rests_for_now() {
            // The world around the arm follows the wall clock.
            if is_due(&mut self.leading.rest, now, 0) {
                leap = (self.line.wire()).and_then(|wire| wire.leap(STEP, LeapTo::Instant));
            }
        } else {
            self.leading.rest = None;
        }
        match (leap, &mut self.program) {
            (Some(leap), Some(program)) => program.stream.leap_clock(now, leap.time, leap.news),
            (None, Some(program)) => program.stream.run_clock(now),
            // The program has ended: the arm's clock becomes its own again.
            (_, None) => {
                self.leading = VirtualTimeDriver::default();
                self.line.wire().map(|wire| wire.lead(false));
            }
        }
        leap.is_some()
    }

    /// Returns how much of the arm's time may pass now, and up to which event; `None` if none may.
    fn far(&mut self, now: Micros) -> Option<(Duration, LeapTo)> {
        let program = self.program.as_ref().filter(|_| !self.leaving)?;
        if std::mem::replace(&mut self.leading.told, program.offered) != program.offered {
            // A source that has just supplied a command is not late any more, even if it is slow.
            self.leading.step = None;
        }
        let slow = program.stream.is_starving();
        if slow || !self.connection.is_idle() {
            let patience = if slow { ANSWER_TIMEOUT } else { micros(STEP) };
            // The event that a slow program waits for may happen around an arm at rest: a belt, a
            // sensor.
            let to = if slow { LeapTo::Instant } else { LeapTo::Rest };
            let comes = is_due(&mut self.leading.step, now, patience);
            if let Some(supply) = &program.supply {
                supply.set_clock_waiting(slow && !comes);
            }
            return comes.then_some((STEP, to));
        }
        let most = program.stream.patience(now).unwrap_or(Duration::MAX);
        let ends = program.stream.wants_room() || program.stream.is_out_of_commands();
        self.leading.step = None;
        if let Some(supply) = &program.supply {
            supply.set_clock_waiting(false);
        }
        Some((most, if ends { LeapTo::End } else { LeapTo::Rest }))
    }

    /// True if the program has nothing to send for now, and nothing is in flight.
    fn rests_for_now(&self) -> bool {
        let stream = self.program.as_ref().map(|program| &program.stream);
        let waits =
            stream.is_some_and(|stream| stream.is_out_of_commands() && !stream.is_starving());
        waits && !self.leaving && self.connection.is_idle()
    }
}

/// True if a step by the wall clock is due; the first is due after `patience`.
fn is_due(step: &mut Option<Micros>, now: Micros, patience: Micros) -> bool {
    let at = step.get_or_insert(now.saturating_add(patience));
    let comes = *at <= now;
    if comes {
        *at = now.saturating_add(micros(STEP));
    }
    comes
}
