//! The line of one peer: bytes on their way to the arm, and replies on their way back.
//!
//! Bytes are cut into pieces at the positions where a frame can be complete. A second decoder (the
//! scout) runs ahead to find them, so that on a paced line the controller sees each request at the
//! instant of its last byte and not at the end of the write.

use std::collections::VecDeque;

use magician_protocol::{Deframer, Event, FrameBuf};

use crate::pace::{LineTiming, Wire};
use crate::{Controller, HostInstant, LinkId, Observer};

/// The line of one peer: input in flight, and replies.
pub(super) struct Link {
    input: Wire,
    /// Decoder that runs ahead on a paced line to find the bytes that complete a frame.
    scout: Option<Box<Deframer>>,
    /// Stream position up to which bytes belong to a piece.
    cut: u64,
    pub(super) pieces: VecDeque<Piece>,
    /// Bytes of all pieces.
    pub(super) bytes: VecDeque<u8>,
    /// Instant at which a partial frame is abandoned.
    pub(super) silent: Option<HostInstant>,
    pub(super) replies: Replies,
}

/// Replies in flight to a peer.
pub(super) struct Replies {
    output: Wire,
    /// Replies, each with the instant by which its last byte has passed.
    queue: VecDeque<(HostInstant, FrameBuf)>,
    /// True if nothing reads them.
    pub(super) hung_up: bool,
}

/// Bytes that can be handed to the controller at once: only the last one can complete a frame.
pub(super) struct Piece {
    /// Arrival of the last byte.
    pub(super) at: HostInstant,
    pub(super) count: usize,
}

impl Link {
    pub(super) fn new(line: LineTiming) -> Self {
        let paced = line.baud.is_some_and(|baud| baud > 0);
        Self {
            input: Wire::new(line),
            // Without a baud rate all bytes arrive at once, so there is no position to look for.
            scout: paced.then(Box::default),
            cut: 0,
            pieces: VecDeque::new(),
            bytes: VecDeque::new(),
            silent: None,
            replies: Replies {
                output: Wire::new(line),
                queue: VecDeque::new(),
                hung_up: false,
            },
        }
    }

    pub(super) fn put(&mut self, now: HostInstant, bytes: &[u8]) {
        // A peer that writes again is back, as on a serial port opened anew.
        self.replies.hung_up = false;
        self.bytes.extend(bytes);
        let end = self.cut + bytes.len() as u64;
        if let Some(mut scout) = self.scout.take() {
            // The scout sees each byte once, however the caller cuts the stream.
            let mut input = bytes;
            while let Some(event) = scout.next(&mut input) {
                if let Some(end) = decided_at(&event) {
                    self.cut_at(now, end);
                }
            }
            self.scout = Some(scout);
        }
        self.cut_at(now, end);
    }

    /// Ends a piece at stream position `end`, unless an earlier cut is at or beyond it.
    fn cut_at(&mut self, now: HostInstant, end: u64) {
        let count = end.saturating_sub(self.cut) as usize;
        if count > 0 {
            let at = self.input.carry(now, count);
            self.pieces.push_back(Piece { at, count });
            self.cut = end;
        }
    }

    pub(super) fn fall_silent(&mut self) {
        self.silent = None;
        if let Some(scout) = &mut self.scout {
            scout.expire();
            // Drain the frames found inside the abandoned bytes: the controller handles them in
            // `expire`, so they are no cutting positions any more.
            while scout.next(&mut &[][..]).is_some() {}
        }
    }

    pub(super) fn input_due(&self) -> Option<HostInstant> {
        let arrival = self.pieces.front().map(|piece| piece.at);
        arrival.or(self.silent)
    }

    pub(super) fn bytes_in_flight(&self) -> usize {
        let replies = self.replies.queue.iter();
        self.bytes.len() + replies.map(|(_, frame)| frame.bytes().len()).sum::<usize>()
    }
}

impl Replies {
    /// Puts the controller's replies on the line, not before `from`.
    pub(super) fn take_from(
        &mut self,
        controller: &mut Controller,
        observer: &mut impl Observer,
        link: LinkId,
        from: HostInstant,
    ) {
        while let Some(frame) = controller.poll_transmit(link) {
            if !self.hung_up {
                observer.reply(controller.now(), link, &frame);
                let at = self.output.carry(from, frame.bytes().len());
                self.queue.push_back((at, frame));
            }
        }
    }

    pub(super) fn due(&self) -> Option<HostInstant> {
        self.queue.front().map(|(at, _)| *at)
    }

    /// Arrival of the first reply that has not arrived by `now`.
    pub(super) fn due_after(&self, now: HostInstant) -> Option<HostInstant> {
        let come = self.queue.partition_point(|(at, _)| *at <= now);
        self.queue.get(come).map(|(at, _)| *at)
    }

    pub(super) fn pop(&mut self, now: HostInstant) -> Option<FrameBuf> {
        let due = self.due().is_some_and(|at| at <= now);
        let (_, frame) = due.then(|| self.queue.pop_front())??;
        Some(frame)
    }

    pub(super) fn hang_up(&mut self) {
        self.hung_up = true;
        self.queue.clear();
    }
}

/// Stream position after the byte that decided an event: the last byte of a frame, or the byte that
/// disproved a candidate, which may uncover frames inside it.
fn decided_at(event: &Event<'_>) -> Option<u64> {
    match event {
        Event::Frame { offset, frame } => Some(offset + frame.bytes().len() as u64),
        Event::Rejected { offset, bytes, .. } => Some(offset + bytes.len() as u64),
        // Noise contains no frame, so it decides nothing.
        Event::Noise { .. } => None,
    }
}
