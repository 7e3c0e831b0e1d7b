//! Record of the controller for observers: its events, and the assumptions behind its answers.

use magician_protocol::Row;

use crate::event::{Event, Log, Refusal};
use crate::fidelity::{Assumption, AssumptionSet, Fidelity, Strictness};

/// Event log and counts of assumptions.
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

    /// Records that a command was understood but not carried out.
    pub(crate) fn refuse(&mut self, id: u8, reason: Refusal) {
        self.event(Event::Refused { id, reason });
    }

    pub(crate) fn not_simulated(&mut self, row: &'static Row) {
        self.log.not_simulated(row);
    }

    /// Counts an assumption that a strict controller makes, too.
    pub(crate) fn assume(&mut self, assumption: Assumption) {
        if self.fidelity.count(assumption) {
            self.event(Event::Assumes { assumption });
        }
    }

    /// Counts an assumption of a command and returns true if the command may go on.
    ///
    /// A strict controller refuses an assumption that is a choice without a source, and logs the
    /// refusal.
    #[must_use]
    pub(crate) fn allows(&mut self, id: u8, assumption: Assumption) -> bool {
        self.assume(assumption);
        let refused = self.strict && assumption.strictness() == Strictness::Refused;
        if refused {
            self.refuse(id, Refusal::OnlyAChoice(assumption));
        }
        !refused
    }

    /// Like [`allows`](Self::allows) for several assumptions: the first refused one is the reason.
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
