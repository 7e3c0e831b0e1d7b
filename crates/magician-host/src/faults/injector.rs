//! Fault injection for a single direction of a line.

use std::collections::VecDeque;

use super::Faults;
use super::dice::Dice;
use crate::connection::Micros;

/// Largest number of bytes under way. Once a stalled line holds that many, it loses more.
const MAX_BYTES_UNDER_WAY: usize = 64 * 1024;
/// Largest number of chunks under way.
const MAX_CHUNKS_UNDER_WAY: usize = 1024;
/// Largest number of pieces that a chunk is cut into.
const MAX_PIECES: u64 = 4;
/// Longest time between two pieces, and longest wait of a chunk for the next one to join, us.
const MAX_PIECE_GAP: Micros = 2_000;
/// Separates the random numbers of chunks from those of bytes.
// Faults of chunks then do not change which bytes are hit.
const CHUNK_SEED_MASK: u64 = 0x5EED_0000_C4C4_C4C4;

/// Output of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Passed {
    /// A chunk of bytes.
    Bytes(Vec<u8>),
    /// The plug was pulled: nothing passes before [`Injector::plug_in`].
    Unplugged,
    /// The controller restarts now.
    Reset,
}

/// Counts of the faults that an [`Injector`] has caused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes replaced by another value.
    pub replaced: u64,
    /// Bytes with one bit flipped.
    pub flipped: u64,
    /// Single bytes lost.
    pub dropped: u64,
    /// Bytes inserted.
    pub inserted: u64,
    /// Bytes duplicated.
    pub duplicated: u64,
    /// Pairs of bytes swapped.
    pub swapped: u64,
    /// Chunks lost, including those without room.
    pub dropped_chunks: u64,
    /// Chunks duplicated.
    pub duplicated_chunks: u64,
    /// Chunks that were overtaken by the next one, or waited for it.
    pub swapped_chunks: u64,
    /// Chunks delayed individually.
    pub late_chunks: u64,
    /// Stalls.
    pub stalls: u64,
    /// Chunks delivered in other pieces.
    pub rechunked: u64,
    /// Plugs pulled.
    pub unplugged: u64,
    /// Restarts of the controller.
    pub resets: u64,
}

impl Tally {
    /// Sum of all counts.
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

/// A single direction of a line with faults. Bytes go in by [`push`](Self::push) and come out of
/// [`poll`](Self::poll), immediately or at [`poll_timeout`](Self::poll_timeout).
#[derive(Clone, Debug)]
pub struct Injector {
    faults: Faults,
    /// Random numbers for bytes: one per byte, more for a byte that is hit.
    dice: Dice,
    /// Random numbers for chunks.
    chunk_dice: Dice,
    /// Output in order; times never decrease.
    under_way: VecDeque<(Micros, Passed)>,
    /// Individually delayed chunks, in no order.
    late: Vec<(Micros, Vec<u8>)>,
    /// Number of bytes in `under_way` and `late`.
    pub(super) load: usize,
    /// True if the next chunk is joined to the last entry under way.
    joins_next: bool,
    /// Chunk that waits for the next one to overtake it.
    held: Option<(Micros, Vec<u8>)>,
    unplugged: bool,
    tally: Tally,
}

impl Injector {
    /// Creates a line with these faults and random numbers from `seed`. The two directions of a
    /// line need different seeds; [`Faults::seed`] is ignored.
    #[must_use]
    pub fn new(faults: Faults, seed: u64) -> Self {
        Self {
            faults,
            dice: Dice::new(seed),
            chunk_dice: Dice::new(seed ^ CHUNK_SEED_MASK),
            under_way: VecDeque::new(),
            late: Vec::new(),
            load: 0,
            joins_next: false,
            held: None,
            unplugged: false,
            tally: Tally::default(),
        }
    }

    /// Sets the faults from now on.
    pub fn set_faults(&mut self, faults: Faults) {
        self.faults = faults;
    }

    /// Counts so far.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Puts in a chunk: a frame, a write, a datagram.
    pub fn push(&mut self, now: Micros, bytes: &[u8]) {
        // Without a plug bytes are lost before they reach the line.
        if self.unplugged || bytes.is_empty() {
            return;
        }
        self.release_held(now);
        // Bytes first, so that their random numbers do not depend on what happens to the chunk.
        let chunk = self.apply_byte_faults(bytes);
        if self.strikes(self.faults.unplug) {
            self.pull_plug(now);
        } else if self.strikes(self.faults.reset) {
            self.tally.resets += 1;
            self.send(now, Passed::Reset);
        } else if self.strikes(self.faults.drop_chunk) {
            self.tally.dropped_chunks += 1;
        } else {
            self.forward(now, chunk);
        }
    }

    /// Returns the next output that is due by `now`, in order. `None` if no output is due.
    pub fn poll(&mut self, now: Micros) -> Option<Passed> {
        self.release_held(now);
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
        self.joins_next &= !self.under_way.is_empty();
        Some(passed)
    }

    /// Instant of the next [`poll`](Self::poll), which may find that it has to wait a little
    /// longer. `None` if nothing is under way.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Micros> {
        // A chunk waiting to be overtaken comes behind everything under way.
        let next = self.under_way.front().map(|(at, _)| *at);
        let next = next.or_else(|| self.held.as_ref().map(|(until, _)| *until));
        let late = self.next_late().map(|(_, at)| at);
        next.into_iter().chain(late).min()
    }

    /// Index and time of the next individually delayed chunk. `None` without such chunks.
    fn next_late(&self) -> Option<(usize, Micros)> {
        let times = self.late.iter().map(|(at, _)| *at).enumerate();
        times.min_by_key(|(_, at)| *at)
    }

    /// Reconnects the plug. The owner calls this after [`Passed::Unplugged`]; everything under way
    /// is lost.
    pub fn plug_in(&mut self) {
        self.clear();
        self.unplugged = false;
    }

    /// True if a fault with this rate strikes. A rate of 0 draws no number, so other faults do not
    /// change.
    fn strikes(&mut self, rate: f64) -> bool {
        rate > 0.0 && self.chunk_dice.share() < rate
    }

    fn pull_plug(&mut self, now: Micros) {
        self.tally.unplugged += 1;
        self.clear();
        self.unplugged = true;
        self.under_way.push_back((now, Passed::Unplugged));
    }

    fn clear(&mut self) {
        self.under_way.clear();
        self.late.clear();
        self.load = 0;
        self.joins_next = false;
        self.held = None;
    }

    /// Forwards a surviving chunk, with stalls, delays, cuts and duplicates.
    fn forward(&mut self, now: Micros, chunk: Vec<u8>) {
        if chunk.is_empty() {
            return;
        }
        let twice = self.strikes(self.faults.duplicate_chunk);
        // Only one chunk waits at a time.
        let wait = self.strikes(self.faults.swap_chunk) && self.held.is_none();
        let mut at = now;
        if self.strikes(self.faults.stall) {
            self.tally.stalls += 1;
            let Faults {
                stall_least,
                stall_for,
                ..
            } = self.faults;
            // `check` has refused a reversed interval; saturation only avoids a panic.
            let more = stall_for.saturating_sub(stall_least);
            let more = self.chunk_dice.below(more.saturating_add(1));
            at = now.saturating_add(stall_least).saturating_add(more);
        }
        if wait {
            self.tally.swapped_chunks += 1;
            // Bounded, so that the last chunk of a test is not held for ever.
            self.held = Some((at.saturating_add(self.faults.hold_for), chunk.clone()));
        } else {
            self.send_or_delay(at, chunk.clone());
        }
        if twice {
            self.tally.duplicated_chunks += 1;
            self.send_or_delay(at, chunk);
        }
        if !wait && let Some((_, held)) = self.held.take() {
            self.send_rechunked(at, held);
        }
    }

    /// Sends a chunk in order, or delayed individually.
    fn send_or_delay(&mut self, at: Micros, chunk: Vec<u8>) {
        if !self.strikes(self.faults.late_chunk) {
            return self.send_rechunked(at, chunk);
        }
        // Like a full buffer of a network, which drops what does not fit.
        if self.late.len() >= MAX_CHUNKS_UNDER_WAY || self.load + chunk.len() > MAX_BYTES_UNDER_WAY
        {
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

    /// Sends the chunk that waited to be overtaken, if it has waited long enough.
    fn release_held(&mut self, now: Micros) {
        if self.held.as_ref().is_some_and(|(until, _)| *until <= now)
            && let Some((until, held)) = self.held.take()
        {
            self.send_rechunked(until, held);
        }
    }

    /// Sends a chunk whole, or in other pieces.
    fn send_rechunked(&mut self, at: Micros, chunk: Vec<u8>) {
        if !self.strikes(self.faults.rechunk) {
            return self.send(at, Passed::Bytes(chunk));
        }
        self.tally.rechunked += 1;
        let pieces = 1 + self.chunk_dice.below(MAX_PIECES);
        if pieces == 1 {
            // A single piece: delayed, and joined with the next chunk.
            let at = at.saturating_add(MAX_PIECE_GAP);
            self.send(at, Passed::Bytes(chunk));
            self.joins_next = matches!(self.under_way.back(), Some((_, Passed::Bytes(_))));
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
            at = at.saturating_add(1 + self.chunk_dice.below(MAX_PIECE_GAP));
        }
    }

    /// Appends an output behind those under way.
    fn send(&mut self, at: Micros, passed: Passed) {
        let size = match &passed {
            Passed::Bytes(bytes) => bytes.len(),
            Passed::Unplugged | Passed::Reset => 0,
        };
        if self.under_way.len() >= MAX_CHUNKS_UNDER_WAY || self.load + size > MAX_BYTES_UNDER_WAY {
            self.tally.dropped_chunks += 1;
            return;
        }
        let joins = std::mem::take(&mut self.joins_next);
        self.load += size;
        match (self.under_way.back_mut(), passed) {
            (Some((_, Passed::Bytes(last))), Passed::Bytes(bytes)) if joins => last.extend(bytes),
            (last, passed) => {
                // A line keeps its order: nothing overtakes a stalled chunk.
                let at = last.map_or(at, |(before, _)| at.max(*before));
                self.under_way.push_back((at, passed));
            }
        }
    }

    /// Applies the faults of bytes to a chunk.
    fn apply_byte_faults(&mut self, bytes: &[u8]) -> Vec<u8> {
        let rates = self.faults;
        let mut out = Vec::with_capacity(bytes.len() + 4);
        // Byte that waits to be swapped with the next one.
        let mut later = None;
        for (at, &byte) in bytes.iter().enumerate() {
            // A single random number decides among all faults of a byte, so at most one occurs.
            let mut chance = self.dice.share();
            let mut is = |rate: f64| {
                let hit = chance < rate;
                chance -= rate;
                hit
            };
            if is(rates.replace) {
                self.tally.replaced += 1;
                // Never the same value.
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
