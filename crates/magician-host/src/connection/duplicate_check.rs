//! Datagrams that come twice.
//!
//! A controller takes a doubled command twice, and no index tells its second copy from the next command, if that one is
//! lost. So over datagrams the next queued command goes out only when no copy of the one before is under way any more
//! ([`Settings::echo`](super::Settings::echo) after it went out) and readings since then have shown that none was taken in
//! between. Then nothing but the next command itself can take the next index.

use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout};

use super::index_tracker::Verdict;
use super::job::Purpose;
use super::planted_bug::{PlantedBug, planted};
use super::{Connection, Micros};

/// A reading that went out so often without an answer is given up.
const TRIES: u32 = 4;

/// What is to be seen before the next queued command goes out.
#[derive(Clone, Debug)]
pub(super) struct DuplicateCheck {
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
    pub(super) fn begin_duplicate_check(&mut self, now: Micros, nth: u32) {
        if self.settings.ordered || self.settings.echo == 0 || planted(PlantedBug::NoDuplicateCheck)
        {
            return;
        }
        let long = match nth {
            ..=1 => 2 * self.estimator.round_trip().unwrap_or(0),
            _ => self.lifetime.measured().unwrap_or(0),
        };
        let echo = self.settings.echo.max(long);
        self.duplicate_check = Some(DuplicateCheck {
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
    pub(super) fn is_no_duplicate(&self, now: Micros) -> bool {
        let over = |duplicate_check: &DuplicateCheck| {
            duplicate_check.unclear
                && duplicate_check.since.saturating_add(self.lifetime.get()) <= now
        };
        self.duplicate_check.as_ref().is_none_or(over)
    }

    /// Whether readings are still to show that nothing came twice.
    pub(super) fn is_vetting(&self) -> bool {
        self.duplicate_check
            .as_ref()
            .is_some_and(|duplicate_check| !duplicate_check.unclear)
    }

    pub(super) fn vet_wakes(&self) -> Option<Micros> {
        self.duplicate_check
            .as_ref()
            .and_then(|duplicate_check| duplicate_check.wakes)
    }

    pub(super) fn pass_vet(&mut self, now: Micros) {
        if let Some(duplicate_check) = &mut self.duplicate_check {
            duplicate_check.wakes = duplicate_check.wakes.filter(|at| *at > now);
        }
    }

    /// The reading that is due.
    pub(super) fn next_vetting(&self, now: Micros) -> Option<Purpose> {
        let duplicate_check = self
            .duplicate_check
            .as_ref()
            .filter(|duplicate_check| !duplicate_check.unclear)?;
        (duplicate_check.due <= now && self.is_accounted()).then_some(
            match duplicate_check.current {
                None => Purpose::Current,
                Some(_) => Purpose::Left,
            },
        )
    }

    /// A reading goes out.
    pub(super) fn check_duplicates(&mut self) {
        if let Some(duplicate_check) = &mut self.duplicate_check
            && self.doubt.is_none()
        {
            duplicate_check.begun = true;
        }
    }

    /// Whether a reading that got no answer `sent` times goes out again.
    pub(super) fn vets_on(&mut self, sent: u32) -> bool {
        let accounted = self.is_accounted();
        let Some(duplicate_check) = (self.duplicate_check.as_mut()).filter(|duplicate_check| {
            duplicate_check.begun && !duplicate_check.unclear && accounted
        }) else {
            return false;
        };
        if sent >= TRIES {
            duplicate_check.give_up(self.lifetime.get());
        }
        sent < TRIES
    }

    /// Takes a reading.
    pub(super) fn vet_reading(&mut self, purpose: Purpose, frame: &FrameBuf) {
        let Some(duplicate_check) = self
            .duplicate_check
            .as_mut()
            .filter(|duplicate_check| duplicate_check.begun && !duplicate_check.unclear)
        else {
            return;
        };
        let params = frame.frame().params();
        match (duplicate_check.current, purpose) {
            (None, Purpose::Current) => {
                let read = QueuedCmdCurrentIndex::decode(params);
                duplicate_check.current = read.ok().map(|read| read.queued_cmd_current_index);
            }
            (Some(current), Purpose::Left) => {
                duplicate_check.current = None;
                let Ok(read) = QueuedCmdLeftSpace::decode(params) else {
                    return;
                };
                let pair = (current, read.left_space);
                if duplicate_check.pair.replace(pair) == Some(pair) {
                    self.end_vet(pair);
                }
            }
            _ => {}
        }
    }

    fn end_vet(&mut self, (current, left): (u64, u32)) {
        let tail = self.tracker.tail(current, left);
        match self.tracker.judge(current, left) {
            Verdict::Lost => self.duplicate_check = None,
            _ if tail.is_some_and(|tail| self.tracker.is_surplus(tail)) => {
                self.duplicate_check = None;
                self.unaccounted(tail.unwrap_or(current));
            }
            _ => {
                if let Some(duplicate_check) = &mut self.duplicate_check {
                    duplicate_check.give_up(self.lifetime.get());
                }
            }
        }
    }
}

impl DuplicateCheck {
    fn give_up(&mut self, lifetime: Micros) {
        self.unclear = true;
        self.wakes = Some(self.since.saturating_add(lifetime));
    }
}
