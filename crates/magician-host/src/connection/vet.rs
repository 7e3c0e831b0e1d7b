//! Datagrams that come twice.
//!
//! A controller takes a doubled command twice, and no index tells its second copy from the next command, if that one is
//! lost. So over datagrams the next queued command goes out only when no copy of the one before is under way any more
//! ([`Settings::echo`](super::Settings::echo) after it went out) and readings since then have shown that none was taken in
//! between. Then nothing but the next command itself can take the next index.

use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout};

use super::flaw::{Flaw, planted};
use super::job::Purpose;
use super::ledger::Verdict;
use super::{Connection, Micros};

/// A reading that went out so often without an answer is given up.
const TRIES: u32 = 4;

/// What is to be seen before the next queued command goes out.
#[derive(Clone, Debug)]
pub(super) struct Vet {
    /// When the last queued command went out.
    since: Micros,
    /// When no second copy of it can come any more.
    due: Micros,
    /// Readings have begun.
    begun: bool,
    current: Option<u64>,
    pair: Option<(u64, u32)>,
    /// The readings tell nothing: only when all answers are dead too does the next command go out.
    unclear: bool,
    /// An instant at which something becomes due.
    wakes: Option<Micros>,
}

impl Connection {
    /// A queued command goes out, for the `nth` time. Its first copy counts as gone by then; should it come all the same, it
    /// comes before the next command goes out, and shows.
    pub(super) fn begin_vet(&mut self, now: Micros, nth: u32) {
        if self.settings.ordered || self.settings.echo == 0 || planted(Flaw::NoVet) {
            return;
        }
        let long = match nth {
            ..=1 => 2 * self.estimator.round_trip().unwrap_or(0),
            _ => self.lifetime.measured().unwrap_or(0),
        };
        let echo = self.settings.echo.max(long);
        self.vet = Some(Vet {
            since: now,
            begun: false,
            current: None,
            pair: None,
            unclear: false,
            due: now.saturating_add(echo),
            wakes: Some(now.saturating_add(echo)),
        });
    }

    /// Whether a queued command may go out that did not go out before.
    pub(super) fn is_vetted(&self, now: Micros) -> bool {
        let over = |vet: &Vet| vet.unclear && vet.since.saturating_add(self.lifetime.get()) <= now;
        self.vet.as_ref().is_none_or(over)
    }

    /// Whether readings are still to show that nothing came twice.
    pub(super) fn is_vetting(&self) -> bool {
        self.vet.as_ref().is_some_and(|vet| !vet.unclear)
    }

    pub(super) fn vet_wakes(&self) -> Option<Micros> {
        self.vet.as_ref().and_then(|vet| vet.wakes)
    }

    pub(super) fn pass_vet(&mut self, now: Micros) {
        if let Some(vet) = &mut self.vet {
            vet.wakes = vet.wakes.filter(|at| *at > now);
        }
    }

    /// The reading that is due.
    pub(super) fn next_vetting(&self, now: Micros) -> Option<Purpose> {
        let vet = self.vet.as_ref().filter(|vet| !vet.unclear)?;
        (vet.due <= now && self.is_accounted()).then_some(match vet.current {
            None => Purpose::Current,
            Some(_) => Purpose::Left,
        })
    }

    /// A reading goes out.
    pub(super) fn vetting(&mut self) {
        if let Some(vet) = &mut self.vet
            && self.doubt.is_none()
        {
            vet.begun = true;
        }
    }

    /// Whether a reading that got no answer `sent` times goes out again.
    pub(super) fn vets_on(&mut self, sent: u32) -> bool {
        let accounted = self.is_accounted();
        let Some(vet) = (self.vet.as_mut()).filter(|vet| vet.begun && !vet.unclear && accounted)
        else {
            return false;
        };
        if sent >= TRIES {
            vet.give_up(self.lifetime.get());
        }
        sent < TRIES
    }

    /// Takes a reading.
    pub(super) fn vet_reading(&mut self, purpose: Purpose, frame: &FrameBuf) {
        let Some(vet) = self.vet.as_mut().filter(|vet| vet.begun && !vet.unclear) else {
            return;
        };
        let params = frame.frame().params();
        match (vet.current, purpose) {
            (None, Purpose::Current) => {
                let read = QueuedCmdCurrentIndex::decode(params);
                vet.current = read.ok().map(|read| read.queued_cmd_current_index);
            }
            (Some(current), Purpose::Left) => {
                vet.current = None;
                let Ok(read) = QueuedCmdLeftSpace::decode(params) else {
                    return;
                };
                let pair = (current, read.left_space);
                if vet.pair.replace(pair) == Some(pair) {
                    self.end_vet(pair);
                }
            }
            _ => {}
        }
    }

    fn end_vet(&mut self, (current, left): (u64, u32)) {
        let tail = self.ledger.tail(current, left);
        match self.ledger.judge(current, left) {
            Verdict::Lost => self.vet = None,
            _ if tail.is_some_and(|tail| self.ledger.is_surplus(tail)) => {
                self.vet = None;
                self.unaccounted(tail.unwrap_or(current));
            }
            _ => {
                if let Some(vet) = &mut self.vet {
                    vet.give_up(self.lifetime.get());
                }
            }
        }
    }
}

impl Vet {
    fn give_up(&mut self, lifetime: Micros) {
        self.unclear = true;
        self.wakes = Some(self.since.saturating_add(lifetime));
    }
}
