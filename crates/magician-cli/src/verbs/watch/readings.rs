//! Readings of a watched arm beside its state: pins, tools, and counters of the connection.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician::connection::Stats;
use magician::{Arm, ArmOutputs};
use magician_job::Polled;
use magician_job::jog::ToolState;

use crate::verbs::io::{self, PIN_COUNT, Pin};

/// Interval of reading one pin. Pins with a function take every second turn.
const PIN_READ_INTERVAL: Duration = Duration::from_millis(100);
/// Interval of reading tools and counters.
const AROUND_READ_INTERVAL: Duration = Duration::from_millis(500);

/// Readings outside the arm's state.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::verbs) struct Around {
    pub(in crate::verbs) tools: ToolState,
    pub(in crate::verbs) stats: Stats,
}

/// Polls tools and counters.
pub(in crate::verbs) fn around(arm: &Arm) -> Polled<Around> {
    let arm = arm.clone();
    Polled::every(AROUND_READ_INTERVAL, move || {
        let arm = arm.clone();
        async move {
            let tools = ToolState::read(&arm).await.ok()?;
            let (stats, _) = arm.stats().await.ok()?;
            Some(Around { tools, stats })
        }
    })
}

/// Polls laser and tools.
pub(super) fn outputs(arm: &Arm) -> Polled<ArmOutputs> {
    let arm = arm.clone();
    Polled::every(AROUND_READ_INTERVAL, move || {
        let arm = arm.clone();
        async move { arm.read_outputs().await.ok() }
    })
}

/// Round robin that decides which pin is read next.
#[derive(Debug)]
pub(super) struct PinRotation {
    /// Addresses of pins with a function.
    busy: Vec<u8>,
    turn: usize,
}

impl PinRotation {
    pub(super) const fn new() -> Self {
        Self {
            busy: Vec::new(),
            turn: 0,
        }
    }

    /// Returns the next pin to read: alternately any pin and one with a function.
    pub(super) fn next(&mut self) -> u8 {
        self.turn = self.turn.wrapping_add(1);
        let (turn, any) = (self.turn / 2, self.turn.is_multiple_of(2));
        match self.busy.get(turn % self.busy.len().max(1)) {
            Some(busy) if !any => *busy,
            _ => {
                let turn = if self.busy.is_empty() {
                    self.turn
                } else {
                    turn
                };
                (turn % usize::from(PIN_COUNT)) as u8 + 1
            }
        }
    }

    pub(super) fn note(&mut self, address: u8, busy: bool) {
        self.busy.retain(|known| *known != address);
        if busy {
            self.busy.push(address);
        }
    }
}

/// Polls the pins one by one.
pub(super) fn pins(arm: &Arm) -> Polled<Pin> {
    let arm = arm.clone();
    let rotation = Arc::new(Mutex::new(PinRotation::new()));
    Polled::every(PIN_READ_INTERVAL, move || {
        let (arm, rotation) = (arm.clone(), Arc::clone(&rotation));
        async move {
            let held = || rotation.lock().unwrap_or_else(PoisonError::into_inner);
            let address = held().next();
            let pin = io::read(&arm, address).await.ok()?;
            held().note(address, pin.has_function());
            Some(pin)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pin_has_its_turn_and_busy_ones_more() {
        let mut rotation = PinRotation::new();
        let mut first: Vec<u8> = (0..20).map(|_| rotation.next()).collect();
        first.sort_unstable();
        assert_eq!(first, (1..=20).collect::<Vec<u8>>());
        rotation.note(7, true);
        rotation.note(9, true);
        let turns: Vec<u8> = (0..80).map(|_| rotation.next()).collect();
        for pin in 1..=20 {
            assert!(turns.contains(&pin), "{pin}");
        }
        let of = |pin| turns.iter().filter(|turn| **turn == pin).count();
        assert!(of(7) >= 20 && of(9) >= 20 && of(1) <= 3);
        rotation.note(7, false);
        rotation.note(9, false);
        let turns: Vec<u8> = (0..40).map(|_| rotation.next()).collect();
        assert!(turns.iter().filter(|turn| **turn == 7).count() <= 2);
    }
}
