use super::drive::Phase;
use super::item::{Entry, Fate};
use super::{Stream, StreamEvent, StreamFailure};
use crate::connection::Micros;

/// After so many losses between others the rest goes one by one.
pub(super) const GAPS: usize = 3;
/// Pause between looks at a queue that drains.
const DRAIN_PAUSE: Micros = 20_000;
/// A command that has not ended so long after its time does not run: the queue was never started.
const HEAD_STANDS: Micros = 2_000_000;
/// A cleared queue whose left space stands for so long will not drain.
const STANDING: Micros = 30_000_000;

/// A loss between others: stop, clear, and go on from the last vertex that is certain.
impl Stream {
    pub(super) fn begin_recovery(&mut self) {
        self.phase = Phase::Settle;
        (self.group, self.control) = (None, None);
    }

    /// Waits for the other answers, and for a WAIT or TRIG that a stop would cut short.
    pub(super) fn settle(&mut self, now: Micros) {
        if self.flying() > 0 {
            return;
        }
        let confirmed = self.confirmed;
        let certain = |entry: &&Entry| entry.index() <= confirmed;
        let waits = self.unfinished().filter(certain).any(Entry::is_cut_by_stop);
        if waits && !self.stopped && self.may_run(now) {
            self.pace(now);
            return;
        }
        self.gap = false;
        self.phase = Phase::Halt;
    }

    /// Whether the queue may run, as far as is known: the command at its head has not stood for longer than it takes.
    fn may_run(&self, now: Micros) -> bool {
        let head = self.unfinished().next().map_or(0, |head| head.item.time);
        let ends = self.reader.begun().saturating_add(head);
        now < ends.saturating_add(HEAD_STANDS)
    }

    /// The cleared queue was looked at: left space first, so that the current index is that of an empty queue.
    pub(super) fn drained(&mut self, now: Micros, since: Micros, before: u32) {
        let (left, places) = (self.reader.left, self.credit.places);
        if left >= places {
            return self.restart();
        }
        let since = if left == before { since } else { now };
        if now.saturating_sub(since) >= STANDING {
            return self.fail(StreamFailure::NotDrained { left, places });
        }
        self.phase = Phase::Drain { since, left };
        self.reader
            .look_closely(now.saturating_add(DRAIN_PAUSE), false);
    }

    /// The queue is stopped and empty: what is finished and certain is done, all else waits again.
    pub(super) fn restart(&mut self) {
        let (current, confirmed) = (self.reader.current, self.confirmed);
        let done = |index: u64| index <= current && confirmed.is_some_and(|all| index <= all);
        while self
            .entries
            .front()
            .is_some_and(|entry| entry.index().is_some_and(done))
        {
            self.stood = self.entries.pop_front().and_then(|entry| entry.item.end);
        }
        let mut again = 0;
        for entry in self.entries.iter_mut().filter(|entry| !entry.is_waiting()) {
            let counted = entry.index().is_some() && !entry.inserted;
            self.accepted = self.accepted.saturating_sub(counted.into());
            entry.fate = Fate::Waiting;
            again += 1;
        }
        self.gaps += 1;
        if self.gaps >= GAPS {
            self.window = 1;
        }
        // The numbers that were dropped are passed over.
        (self.expected, self.confirmed) = (None, None);
        (self.credit.strangers, self.stopped) = (0, true);
        self.phase = Phase::Choose;
        let window = self.window;
        self.events.push(StreamEvent::Recovered { again, window });
    }
}
