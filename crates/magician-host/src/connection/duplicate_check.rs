//! Protection against duplicated datagrams.
//!
//! A controller executes a duplicated command twice, and no index distinguishes the second copy
//! from the next command if that one is lost. So over datagrams the next queued command is sent
//! only when no copy of the previous one can be under way
//! ([`Settings::echo`](super::Settings::echo) after it was sent) and readings since then have shown
//! that none was taken. After that, nothing but the next command itself can take the next index.

use magician_protocol::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{FrameBuf, Layout};

use super::index_tracker::Verdict;
use super::job::Purpose;
use super::planted_bug::{PlantedBug, is_planted};
use super::{Connection, Micros};

/// Attempts per reading before it is given up.
// A choice: the next command then waits for the lifetime of the previous one.
const MAX_ATTEMPTS: u32 = 4;

/// State of the check that precedes the next queued command.
#[derive(Clone, Debug)]
pub(super) struct DuplicateCheck {
    /// Instant at which the last queued command was sent.
    since: Micros,
    /// Instant after which no second copy of it can arrive.
    due: Micros,
    /// True once readings have begun.
    begun: bool,
    current: Option<u64>,
    pair: Option<(u64, u32)>,
    /// True if the readings are inconclusive. The next command then waits for the lifetime of the
    /// previous one.
    unclear: bool,
    /// Instant at which the readings are due or, if they are inconclusive, the lifetime is over.
    /// `None` once it has passed.
    wakes: Option<Micros>,
}

impl Connection {
    /// Starts the check for a queued command that is sent for the `nth` time.
    ///
    /// A command is sent again only when its first copy is assumed lost. If that copy arrives after
    /// all, it does so during this wait, and the readings reveal it.
    pub(super) fn begin_duplicate_check(&mut self, now: Micros, nth: u32) {
        if self.settings.ordered
            || self.settings.echo == 0
            || is_planted(PlantedBug::NoDuplicateCheck)
        {
            return;
        }
        // After a retransmission the first copy may be anywhere in the network: wait a whole
        // lifetime.
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

    /// True if a new queued command may be sent.
    pub(super) fn may_send_queued(&self, now: Micros) -> bool {
        let over = |duplicate_check: &DuplicateCheck| {
            duplicate_check.unclear
                && duplicate_check.since.saturating_add(self.lifetime.get()) <= now
        };
        self.duplicate_check.as_ref().is_none_or(over)
    }

    /// True while readings have yet to show that nothing was duplicated.
    pub(super) fn is_checking_duplicates(&self) -> bool {
        self.duplicate_check
            .as_ref()
            .is_some_and(|duplicate_check| !duplicate_check.unclear)
    }

    pub(super) fn next_check_timeout(&self) -> Option<Micros> {
        self.duplicate_check
            .as_ref()
            .and_then(|duplicate_check| duplicate_check.wakes)
    }

    pub(super) fn handle_check_timeout(&mut self, now: Micros) {
        if let Some(duplicate_check) = &mut self.duplicate_check {
            duplicate_check.wakes = duplicate_check.wakes.filter(|at| *at > now);
        }
    }

    /// Next reading to send, if one is due.
    pub(super) fn next_check_reading(&self, now: Micros) -> Option<Purpose> {
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

    /// Notes that a reading is sent.
    pub(super) fn note_check_reading(&mut self) {
        if let Some(duplicate_check) = &mut self.duplicate_check
            // During a doubt the same readings serve the doubt instead.
            && self.doubt.is_none()
        {
            duplicate_check.begun = true;
        }
    }

    /// True if a reading that was sent `sent` times without a reply is sent again.
    pub(super) fn retries_reading(&mut self, sent: u32) -> bool {
        let accounted = self.is_accounted();
        let Some(duplicate_check) = (self.duplicate_check.as_mut()).filter(|duplicate_check| {
            duplicate_check.begun && !duplicate_check.unclear && accounted
        }) else {
            return false;
        };
        if sent >= MAX_ATTEMPTS {
            duplicate_check.give_up(self.lifetime.get());
        }
        sent < MAX_ATTEMPTS
    }

    /// Processes the reply to a reading.
    pub(super) fn process_reading(&mut self, purpose: Purpose, frame: &FrameBuf) {
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
                    self.finish_check(pair);
                }
            }
            // A stray reply of an earlier reading.
            _ => {}
        }
    }

    fn finish_check(&mut self, (current, left): (u64, u32)) {
        let tail = self.tracker.tail(current, left);
        match self.tracker.judge(current, left) {
            Verdict::NotTaken => self.duplicate_check = None,
            _ if tail.is_some_and(|tail| self.tracker.is_surplus(tail)) => {
                self.duplicate_check = None;
                self.unaccounted(tail.unwrap_or(current));
            }
            // Neither clean nor a clear surplus: another host may be at work, so wait for the
            // lifetime.
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
