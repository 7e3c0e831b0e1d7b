//! Time that passes at an arm in virtual time while a program runs.
//!
//! The task lets it pass when it is at rest: all is sent that the queue takes, and all answers are there. So the arm never
//! waits for its host, as long as the host has something to send. Where it has not, time passes by the wall: a source that
//! waits for the arm, a line that swallows answers.

use std::time::Duration;

use super::{Driver, micros};
use crate::connection::Micros;
use crate::transport::{LeapTo, STEP};

/// How long the arm waits for a program that is slow to tell what comes next.
const PATIENCE: Micros = 1_000_000;

/// What advances the arm's clock.
#[derive(Debug, Default)]
pub(super) struct VirtualTimeDriver {
    /// This task.
    leads: bool,
    /// When the arm goes on although the program, or an answer, is late.
    step: Option<Micros>,
    /// Commands that the program had told when that was decided.
    told: u64,
    /// When time passes around an arm at rest whose program has nothing for now.
    rest: Option<Micros>,
}

impl VirtualTimeDriver {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.step.or(self.rest)
    }
}

impl Driver {
    /// A program begins: whether the arm's time passes as this task says. It leads the arm until it is at rest without a program, so
    /// that a stop is heard before the arm goes on by itself.
    pub(super) fn lead(&mut self) {
        let now = self.now();
        self.leading.leads = self.line.wire().is_some_and(|wire| wire.lead(true));
        if let (true, Some(program)) = (self.leading.leads, &mut self.program) {
            program.stream.leapt(now, Duration::ZERO, false);
        }
    }

    /// Nothing else is to be done now: lets the arm's time pass; whether any has.
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
            // What is around the arm goes on by the wall.
            if is_due(&mut self.leading.rest, now, 0) {
                leap = (self.line.wire()).and_then(|wire| wire.leap(STEP, LeapTo::Instant));
            }
        } else {
            self.leading.rest = None;
        }
        match (leap, &mut self.program) {
            (Some(leap), Some(program)) => program.stream.leapt(now, leap.time, leap.news),
            (None, Some(program)) => program.stream.runs(now),
            (_, None) => {
                self.leading = VirtualTimeDriver::default();
                self.line.wire().map(|wire| wire.lead(false));
            }
        }
        leap.is_some()
    }

    /// How much of the arm's time may pass now, if any may, and how far.
    fn far(&mut self, now: Micros) -> Option<(Duration, LeapTo)> {
        let program = self.program.as_ref().filter(|_| !self.leaving)?;
        if std::mem::replace(&mut self.leading.told, program.offered) != program.offered {
            // Slow or not, it is not late any more.
            self.leading.step = None;
        }
        let slow = program.stream.starves();
        if slow || !self.connection.is_idle() {
            let patience = if slow { PATIENCE } else { micros(STEP) };
            // What a slow program waits for may happen around an arm at rest: a belt that runs, a sensor.
            let to = if slow { LeapTo::Instant } else { LeapTo::Rest };
            let comes = is_due(&mut self.leading.step, now, patience);
            if let Some(supply) = &program.supply {
                supply.set_stands(slow && !comes);
            }
            return comes.then_some((STEP, to));
        }
        let most = program.stream.patience(now).unwrap_or(Duration::MAX);
        let ends = program.stream.wants_room() || program.stream.has_nothing();
        self.leading.step = None;
        if let Some(supply) = &program.supply {
            supply.set_stands(false);
        }
        Some((most, if ends { LeapTo::End } else { LeapTo::Rest }))
    }

    /// Whether its program has said that there is nothing for now, and nothing is under way.
    fn rests_for_now(&self) -> bool {
        let stream = self.program.as_ref().map(|program| &program.stream);
        let waits = stream.is_some_and(|stream| stream.has_nothing() && !stream.starves());
        waits && !self.leaving && self.connection.is_idle()
    }
}

/// Whether a step by the wall comes now; the first one only after some patience.
fn is_due(step: &mut Option<Micros>, now: Micros, patience: Micros) -> bool {
    let at = step.get_or_insert(now.saturating_add(patience));
    let comes = *at <= now;
    if comes {
        *at = now.saturating_add(micros(STEP));
    }
    comes
}
