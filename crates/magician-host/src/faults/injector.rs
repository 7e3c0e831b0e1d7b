use std::collections::VecDeque;

use super::Faults;
use super::dice::Dice;
use crate::connection::Micros;

/// Most bytes under way; a line that stands still for longer loses what comes then.
const ROOM: usize = 64 * 1024;
/// Most chunks under way.
const CHUNKS: usize = 1024;
/// Most pieces that a chunk is cut into.
const PIECES: u64 = 4;
/// The longest time between two pieces, and the longest wait for a chunk to come along with, us.
const APART: Micros = 2_000;
/// Sets the chances of chunks apart from those of bytes, so that the bytes that are hit do not
/// depend on what happens to chunks.
const OTHER_DICE: u64 = 0x5EED_0000_C4C4_C4C4;

/// What comes out of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Passed {
    /// A chunk.
    Bytes(Vec<u8>),
    /// The plug is out: nothing passes before [`Injector::plug_in`].
    Unplugged,
    /// The controller restarts now.
    Reset,
}

/// What an [`Injector`] has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes that became another one.
    pub replaced: u64,
    /// Bytes of which one bit was turned.
    pub flipped: u64,
    /// Bytes that were lost one by one.
    pub dropped: u64,
    /// Inserted bytes.
    pub inserted: u64,
    /// Bytes that came twice.
    pub duplicated: u64,
    /// Pairs of bytes that changed places.
    pub swapped: u64,
    /// Chunks that were lost, those that had no room among them.
    pub dropped_chunks: u64,
    /// Chunks that came twice.
    pub duplicated_chunks: u64,
    /// Chunks that let another one pass, or waited for one.
    pub swapped_chunks: u64,
    /// Chunks that were late by themselves.
    pub late_chunks: u64,
    /// Stalls.
    pub stalls: u64,
    /// Chunks that came in other cuts.
    pub rechunked: u64,
    /// Pulled plugs.
    pub unplugged: u64,
    /// Restarts.
    pub resets: u64,
}

impl Tally {
    /// All together.
    #[must_use]
    pub fn total(&self) -> u64 {
        let bytes = [
            self.replaced,
            self.flipped,
            self.dropped,
            self.inserted,
            self.duplicated,
            self.swapped,
        ];
        let chunks = [
            self.dropped_chunks,
            self.duplicated_chunks,
            self.swapped_chunks,
            self.late_chunks,
            self.stalls,
            self.rechunked,
            self.unplugged,
            self.resets,
        ];
        bytes.iter().chain(&chunks).sum()
    }
}

/// One direction of a line with faults: bytes go in with [`push`](Self::push) and come out of
/// [`poll`](Self::poll), at [`poll_timeout`](Self::poll_timeout) if not at once.
#[derive(Clone, Debug)]
pub struct Injector {
    faults: Faults,
    /// For bytes; drawn from once a byte, and more for a byte that is hit.
    dice: Dice,
    /// For chunks.
    chunk_dice: Dice,
    /// In the order in which it comes out; times never go down.
    under_way: VecDeque<(Micros, Passed)>,
    /// Late by themselves, in no order.
    late: Vec<(Micros, Vec<u8>)>,
    /// Bytes in `under_way` and `late`.
    pub(super) load: usize,
    /// The last one under way may take the next chunk along.
    open: bool,
    /// Waits for the next chunk to pass.
    held: Option<(Micros, Vec<u8>)>,
    unplugged: bool,
    tally: Tally,
}

impl Injector {
    /// A line that does this, with chances of this seed; the two directions of a line take
    /// different ones. [`Faults::seed`] is not looked at.
    #[must_use]
    pub fn new(faults: Faults, seed: u64) -> Self {
        Self {
            faults,
            dice: Dice::new(seed),
            chunk_dice: Dice::new(seed ^ OTHER_DICE),
            under_way: VecDeque::new(),
            late: Vec::new(),
            load: 0,
            open: false,
            held: None,
            unplugged: false,
            tally: Tally::default(),
        }
    }

    /// From now on it does this.
    pub fn set_faults(&mut self, faults: Faults) {
        self.faults = faults;
    }

    /// What it has done so far.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// A chunk goes in: a frame, a write, a datagram.
    pub fn push(&mut self, now: Micros, bytes: &[u8]) {
        if self.unplugged || bytes.is_empty() {
            return;
        }
        self.release(now);
        let chunk = self.spoil(bytes);
        if self.strikes(self.faults.unplug) {
            self.pull(now);
        } else if self.strikes(self.faults.reset) {
            self.tally.resets += 1;
            self.send(now, Passed::Reset);
        } else if self.strikes(self.faults.drop_chunk) {
            self.tally.dropped_chunks += 1;
        } else {
            self.forward(now, chunk);
        }
    }

    /// What has come through by now, in its order.
    pub fn poll(&mut self, now: Micros) -> Option<Passed> {
        self.release(now);
        let first = self.under_way.front().map(|(at, _)| *at);
        if let Some((place, at)) = self.next_late()
            && at <= now
            && first.is_none_or(|first| at < first)
        {
            let (_, bytes) = self.late.swap_remove(place);
            self.load -= bytes.len();
            return Some(Passed::Bytes(bytes));
        }
        first.filter(|at| *at <= now)?;
        let (_, passed) = self.under_way.pop_front()?;
        if let Passed::Bytes(bytes) = &passed {
            self.load -= bytes.len();
        }
        self.open &= !self.under_way.is_empty();
        Some(passed)
    }

    /// When to [`poll`](Self::poll) next; what has waited may have to wait a little more then.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        // What has waited for another one to pass still comes behind what is under way.
        let next = self.under_way.front().map(|(at, _)| *at);
        let next = next.or_else(|| self.held.as_ref().map(|(until, _)| *until));
        let late = self.next_late().map(|(_, at)| at);
        next.into_iter().chain(late).min()
    }

    /// Which of the late ones comes first, and when.
    fn next_late(&self) -> Option<(usize, Micros)> {
        let times = self.late.iter().map(|(at, _)| *at).enumerate();
        times.min_by_key(|(_, at)| *at)
    }

    /// The plug is in again; called by the owner that was told that it was pulled. What was under way is lost.
    pub fn plug_in(&mut self) {
        self.clear();
        self.unplugged = false;
    }

    /// Whether it happens now. What never happens draws no number.
    fn strikes(&mut self, rate: f64) -> bool {
        rate > 0.0 && self.chunk_dice.share() < rate
    }

    fn pull(&mut self, now: Micros) {
        self.tally.unplugged += 1;
        self.clear();
        self.unplugged = true;
        self.under_way.push_back((now, Passed::Unplugged));
    }

    fn clear(&mut self) {
        self.under_way.clear();
        self.late.clear();
        self.load = 0;
        self.open = false;
        self.held = None;
    }

    /// A chunk that is not lost: stalls, waits, is cut, comes twice.
    fn forward(&mut self, now: Micros, chunk: Vec<u8>) {
        if chunk.is_empty() {
            return;
        }
        let twice = self.strikes(self.faults.duplicate_chunk);
        let wait = self.strikes(self.faults.swap_chunk) && self.held.is_none();
        let mut at = now;
        if self.strikes(self.faults.stall) {
            self.tally.stalls += 1;
            let Faults {
                stall_least,
                stall_for,
                ..
            } = self.faults;
            let more = stall_for.saturating_sub(stall_least);
            let more = self.chunk_dice.below(more.saturating_add(1));
            at = now.saturating_add(stall_least).saturating_add(more);
        }
        if wait {
            self.tally.swapped_chunks += 1;
            self.held = Some((at.saturating_add(self.faults.hold_for), chunk.clone()));
        } else {
            self.hurry(at, chunk.clone());
        }
        if twice {
            self.tally.duplicated_chunks += 1;
            self.hurry(at, chunk);
        }
        if !wait && let Some((_, held)) = self.held.take() {
            self.cut(at, held);
        }
    }

    /// Sends a chunk in its turn, or late by itself.
    fn hurry(&mut self, at: Micros, chunk: Vec<u8>) {
        if !self.strikes(self.faults.late_chunk) {
            return self.cut(at, chunk);
        }
        if self.late.len() >= CHUNKS || self.load + chunk.len() > ROOM {
            self.tally.dropped_chunks += 1;
            return;
        }
        self.tally.late_chunks += 1;
        self.load += chunk.len();
        let late = self
            .chunk_dice
            .below(self.faults.late_for.saturating_add(1));
        self.late.push((at.saturating_add(late), chunk));
    }

    /// The chunk that waited for another one to pass has waited long enough.
    fn release(&mut self, now: Micros) {
        if self.held.as_ref().is_some_and(|(until, _)| *until <= now)
            && let Some((until, held)) = self.held.take()
        {
            self.cut(until, held);
        }
    }

    /// Sends a chunk whole, or in other cuts.
    fn cut(&mut self, at: Micros, chunk: Vec<u8>) {
        if !self.strikes(self.faults.rechunk) {
            return self.send(at, Passed::Bytes(chunk));
        }
        self.tally.rechunked += 1;
        let pieces = 1 + self.chunk_dice.below(PIECES);
        if pieces == 1 {
            let at = at.saturating_add(APART);
            self.send(at, Passed::Bytes(chunk));
            self.open = matches!(self.under_way.back(), Some((_, Passed::Bytes(_))));
            return;
        }
        let (mut rest, mut at) = (chunk.as_slice(), at);
        for left in (1..=pieces).rev() {
            let most = (rest.len() as u64).saturating_sub(left - 1);
            let count = if left == 1 {
                rest.len()
            } else {
                (1 + self.chunk_dice.below(most)) as usize
            };
            let (piece, after) = rest.split_at(count.min(rest.len()));
            if !piece.is_empty() {
                self.send(at, Passed::Bytes(piece.to_vec()));
            }
            rest = after;
            at = at.saturating_add(1 + self.chunk_dice.below(APART));
        }
    }

    /// Puts it under way behind what is there.
    fn send(&mut self, at: Micros, passed: Passed) {
        let size = match &passed {
            Passed::Bytes(bytes) => bytes.len(),
            Passed::Unplugged | Passed::Reset => 0,
        };
        if self.under_way.len() >= CHUNKS || self.load + size > ROOM {
            self.tally.dropped_chunks += 1;
            return;
        }
        let joins = std::mem::take(&mut self.open);
        self.load += size;
        match (self.under_way.back_mut(), passed) {
            (Some((_, Passed::Bytes(last))), Passed::Bytes(bytes)) if joins => last.extend(bytes),
            (last, passed) => {
                let at = last.map_or(at, |(before, _)| at.max(*before));
                self.under_way.push_back((at, passed));
            }
        }
    }

    /// What happens to the bytes of a chunk.
    fn spoil(&mut self, bytes: &[u8]) -> Vec<u8> {
        let rates = self.faults;
        let mut out = Vec::with_capacity(bytes.len() + 4);
        // Waits for the byte with which it changes places.
        let mut later = None;
        for (at, &byte) in bytes.iter().enumerate() {
            let mut chance = self.dice.share();
            let mut is = |rate: f64| {
                let hit = chance < rate;
                chance -= rate;
                hit
            };
            if is(rates.replace) {
                self.tally.replaced += 1;
                // Never the same one.
                let by = 1 + self.dice.below(255) as u8;
                out.push(byte.wrapping_add(by));
            } else if is(rates.flip) {
                self.tally.flipped += 1;
                out.push(byte ^ (1 << self.dice.below(8)));
            } else if is(rates.drop) {
                self.tally.dropped += 1;
            } else if is(rates.insert) {
                self.tally.inserted += 1;
                out.extend([self.dice.byte(), byte]);
            } else if is(rates.duplicate) {
                self.tally.duplicated += 1;
                out.extend([byte, byte]);
            } else if is(rates.swap) && later.is_none() && at + 1 < bytes.len() {
                self.tally.swapped += 1;
                later = Some(byte);
                continue;
            } else {
                out.push(byte);
            }
            out.extend(later.take());
        }
        out
    }
}
