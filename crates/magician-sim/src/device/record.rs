//! The controller's record for observers: its events, and the assumptions behind its answers.

use magician_protocol::Row;

use crate::event::{Event, Log, Refusal};
use crate::fidelity::{Assumption, AssumptionSet, Fidelity, Strictness};

/// The log and the count of assumptions.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    log: Log,
    fidelity: Fidelity,
    strict: bool,
}

impl Record {
    pub(crate) fn new(strict: bool) -> Self {
        Self {
            log: Log::default(),
            fidelity: Fidelity::default(),
            strict,
        }
    }

    pub(crate) fn log(&self) -> &Log {
        &self.log
    }

    pub(crate) fn fidelity(&self) -> &Fidelity {
        &self.fidelity
    }

    pub(crate) fn event(&mut self, event: Event) {
        self.log.push(event);
    }

    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.log.pop()
    }

    /// A command was understood and is not carried out.
    pub(crate) fn refuse(&mut self, id: u8, reason: Refusal) {
        self.event(Event::Refused { id, reason });
    }

    pub(crate) fn not_simulated(&mut self, row: &'static Row) {
        self.log.not_simulated(row);
    }

    /// Counts what something rests on that a strict controller does, too.
    pub(crate) fn assume(&mut self, assumption: Assumption) {
        if self.fidelity.count(assumption) {
            self.event(Event::Assumes { assumption });
        }
    }

    /// Counts what a command of an id rests on; whether to go on. A strict controller does not
    /// where only a choice exists, and says so.
    #[must_use]
    pub(crate) fn allows(&mut self, id: u8, assumption: Assumption) -> bool {
        self.assume(assumption);
        let refused = self.strict && assumption.strictness() == Strictness::Refused;
        if refused {
            self.refuse(id, Refusal::OnlyAChoice(assumption));
        }
        !refused
    }

    /// As [`allows`](Self::allows) for several: the first choice is the reason.
    #[must_use]
    pub(crate) fn allows_all(&mut self, id: u8, mut assumptions: AssumptionSet) -> bool {
        while let Some(assumption) = assumptions.take() {
            if !self.allows(id, assumption) {
                return false;
            }
        }
        true
    }
}
