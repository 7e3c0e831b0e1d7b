//! Time that passes at an arm in virtual time while a program runs.
//!
//! The task lets it pass when it is at rest: all is sent that the queue takes, and all answers are there. So the arm never
//! waits for its host, as long as the host has something to send. Where it has not, time passes by the wall: a source that
//! waits for the arm, a line that swallows answers.

use std::time::Duration;

use super::{Driver, micros};
use crate::connection::Micros;
use crate::transport::STEP;

/// How long the arm waits for a program that is slow to tell what comes next.
const PATIENCE: Micros = 1_000_000;

/// What advances the arm's clock.
#[derive(Debug, Default)]
pub(super) struct VirtualTimeDriver {
    /// This task.
    leads: bool,
    /// When the arm goes on although the program, or an answer, is late.
    step: Option<Micros>,
}

impl VirtualTimeDriver {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.step
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
        let leap = match self.far(now) {
            Some((most, ends)) => (self.line.wire()).and_then(|wire| wire.leap(most, ends)),
            None => None,
        };
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

    /// How much of the arm's time may pass now, if any may, and whether the program is to hear of each command that ends.
    fn far(&mut self, now: Micros) -> Option<(Duration, bool)> {
        let program = self.program.as_ref().filter(|_| !self.leaving)?;
        let slow = program.stream.starves();
        if slow || !self.connection.is_idle() {
            let patience = if slow { PATIENCE } else { micros(STEP) };
            return self.steps(now, patience).then_some((STEP, false));
        }
        self.leading.step = None;
        let most = program.stream.patience(now).unwrap_or(Duration::MAX);
        Some((most, program.stream.wants_room()))
    }

    /// Whether the arm goes a step by the wall now; the first one only after some patience.
    fn steps(&mut self, now: Micros, patience: Micros) -> bool {
        let step = (self.leading.step).get_or_insert(now.saturating_add(patience));
        let comes = *step <= now;
        if comes {
            *step = now.saturating_add(micros(STEP));
        }
        comes
    }
}
