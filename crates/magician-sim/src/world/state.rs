//! Everything that a world which is not empty knows.

use std::sync::Arc;

use super::Happening;
use super::agenda::Agenda;
use crate::Micros;
use crate::scenario::{Action, Scenario};

/// A world that is not empty.
#[derive(Clone, Debug)]
pub(super) struct State {
    scenario: Arc<Scenario>,
    /// The latest instant that the world was told.
    now: Micros,
    agenda: Agenda,
}

impl State {
    pub(super) fn new(scenario: Scenario) -> Self {
        Self {
            now: 0,
            agenda: Agenda::new(scenario.script()),
            scenario: Arc::new(scenario),
        }
    }

    pub(super) fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    pub(super) fn digital(&self, address: u8) -> bool {
        self.agenda.digital(address)
    }

    pub(super) fn analog(&self, address: u8) -> u16 {
        self.agenda.analog(address)
    }

    pub(super) fn override_input(&mut self, action: Action) -> bool {
        self.agenda.override_input(self.now, action)
    }

    pub(super) fn index_started(&mut self, now: Micros, index: u64) {
        self.now = self.now.max(now);
        self.agenda
            .index_started(self.scenario.script(), now, index);
    }

    pub(super) fn next_event(&self) -> Option<Micros> {
        self.agenda.next_event(self.scenario.script())
    }

    pub(super) fn happen(&mut self, now: Micros) -> Option<Happening> {
        self.now = self.now.max(now);
        self.agenda.happen(self.scenario.script(), now)
    }
}
