//! Separation of a byte stream into frames and foreign bytes.

use magician_protocol::{Deframer, Event, FrameBuf, INTER_BYTE_TIMEOUT_MS};

use crate::connection::Micros;

// The same silence as in the deframer's documentation (errata E04).
const SILENCE: Micros = INTER_BYTE_TIMEOUT_MS * 1000;

/// A part of a byte stream. All parts together are the stream.
#[allow(clippy::large_enum_variant)]
pub(super) enum Piece<'a> {
    Frame(FrameBuf),
    /// Bytes outside of any frame: noise, or a damaged frame.
    Foreign(&'a [u8]),
}

/// Separates a byte stream into frames and the bytes between them.
#[derive(Debug, Default)]
pub(super) struct Cutter {
    deframer: Deframer,
    /// Bytes not yet in any piece; the first is at stream position `start`.
    held: Vec<u8>,
    start: u64,
    heard: Micros,
}

impl Cutter {
    /// Processes received bytes.
    pub(super) fn push(&mut self, now: Micros, bytes: &[u8], piece: impl FnMut(Piece<'_>)) {
        self.heard = now;
        self.cut(bytes, piece);
    }

    /// Processes the timer: bytes that waited too long for the rest of their frame are foreign.
    pub(super) fn handle_timeout(&mut self, now: Micros, piece: impl FnMut(Piece<'_>)) {
        if self.poll_timeout().is_some_and(|at| at <= now) {
            self.deframer.expire();
            self.cut(&[], piece);
        }
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        let waits = self.deframer.pending();
        waits.then(|| self.heard.saturating_add(SILENCE))
    }

    fn cut(&mut self, mut bytes: &[u8], mut piece: impl FnMut(Piece<'_>)) {
        self.held.extend(bytes);
        while let Some(event) = self.deframer.next(&mut bytes) {
            if let Event::Frame { offset, frame } = event {
                let frame = FrameBuf::from(frame);
                // Bytes before the frame belong to nothing, so report them first, in order.
                self.foreign(offset, &mut piece);
                self.take(frame.bytes().len(), |_| ());
                piece(Piece::Frame(frame));
            }
        }
        // Bytes that the deframer has passed will never be part of a frame.
        self.foreign(self.deframer.offset(), &mut piece);
    }

    /// Reports the bytes held before stream position `end` as foreign.
    fn foreign(&mut self, end: u64, mut piece: impl FnMut(Piece<'_>)) {
        let count = end.saturating_sub(self.start);
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        if count > 0 {
            self.take(count, |run| piece(Piece::Foreign(run)));
        }
    }

    fn take(&mut self, count: usize, call: impl FnOnce(&[u8])) {
        let count = count.min(self.held.len());
        call(self.held.get(..count).unwrap_or_default());
        self.held.drain(..count);
        self.start = self.start.saturating_add(count as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_protocol::Ctrl;

    /// Pieces of a stream that arrives in steps of `step` bytes.
    fn cut(stream: &[u8], step: usize) -> Vec<(bool, Vec<u8>)> {
        let mut pieces: Vec<(bool, Vec<u8>)> = Vec::new();
        let mut see = |piece: Piece<'_>| match piece {
            Piece::Frame(frame) => pieces.push((true, frame.bytes().to_vec())),
            Piece::Foreign(run) => match pieces.last_mut() {
                Some((false, last)) => last.extend(run),
                _ => pieces.push((false, run.to_vec())),
            },
        };
        let mut cutter = Cutter::default();
        for (now, bytes) in (0..).zip(stream.chunks(step)) {
            cutter.push(now, bytes, &mut see);
        }
        cutter.handle_timeout(SILENCE - 1, &mut see);
        cutter.handle_timeout(Micros::MAX, &mut see);
        assert_eq!(cutter.poll_timeout(), None);
        pieces
    }

    #[test]
    fn the_pieces_are_the_stream_however_it_comes() {
        let get = FrameBuf::new(10, Ctrl::GET, &[]).unwrap();
        let set = FrameBuf::new(84, Ctrl::QUEUED, &[0xAA; 17]).unwrap();
        let mut damaged = set.bytes().to_vec();
        damaged[7] ^= 1;
        let stream = [
            b"M10\r\n".as_slice(),
            get.bytes(),
            set.bytes(),
            &damaged,
            get.bytes(),
            &set.bytes()[..9],
        ]
        .concat();
        let expected = [
            (false, b"M10\r\n".to_vec()),
            (true, get.bytes().to_vec()),
            (true, set.bytes().to_vec()),
            (false, damaged),
            (true, get.bytes().to_vec()),
            (false, set.bytes()[..9].to_vec()),
        ];
        for step in [1, 2, 7, stream.len()] {
            assert_eq!(cut(&stream, step), expected, "{step}");
        }
    }
}
