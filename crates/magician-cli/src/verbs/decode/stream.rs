//! Bytes to pieces: frames, rejected candidates, runs of noise.

use magician_protocol::{Deframer, Direction, Event};
use magician_record::trace::Packet;

use super::{From, Printer, StreamPosition};
use crate::failure::Failure;

/// How many pieces were understood and how many not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) good: u64,
    pub(super) bad: u64,
}

/// What a run of bytes is part of, and what is known of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Origin<'a> {
    /// The sender, if known.
    pub(super) direction: Option<Direction>,
    /// Number and name of the link in a capture.
    pub(super) link: Option<(u32, &'a str)>,
    /// When, microseconds since 1970.
    pub(super) time: Option<u64>,
}

/// The bytes of one direction of one link.
type Stream = (Option<u32>, Option<bool>);

impl<'a> Origin<'a> {
    /// What a packet of a capture tells.
    pub(super) fn of(packet: &'a Packet<'_>) -> Self {
        Self {
            direction: packet.direction,
            link: Some((packet.link, &packet.link_name)),
            time: Some(packet.time),
        }
    }

    fn stream(&self) -> Stream {
        let reply = self
            .direction
            .map(|direction| direction == Direction::Reply);
        (self.link.map(|(number, _)| number), reply)
    }
}

/// Finds the pieces in streams of bytes and hands them to a printer.
pub(super) struct Decoder<P: Printer> {
    streams: Vec<(Stream, Deframer)>,
    teller: Teller<P>,
}

/// What knows the events but not the bytes they come from.
struct Teller<P: Printer> {
    from: From,
    printer: P,
    tally: Tally,
    /// The run of noise under way: its stream, and where it ends so far.
    noise: Option<(Stream, u64)>,
}

impl<P: Printer> Decoder<P> {
    pub(super) fn new(from: From, printer: P) -> Self {
        Self {
            streams: Vec::new(),
            teller: Teller {
                from,
                printer,
                tally: Tally::default(),
                noise: None,
            },
        }
    }

    /// Takes more bytes.
    pub(super) fn push(&mut self, origin: Origin<'_>, mut bytes: &[u8]) -> Result<(), Failure> {
        let stream = origin.stream();
        let known = self.streams.iter().position(|(other, _)| *other == stream);
        let at = known.unwrap_or_else(|| {
            self.streams.push((stream, Deframer::new()));
            self.streams.len() - 1
        });
        let Some((_, deframer)) = self.streams.get_mut(at) else {
            return Ok(());
        };
        while let Some(event) = deframer.next(&mut bytes) {
            self.teller.tell(origin, event)?;
        }
        Ok(())
    }

    /// Shows what has been found so far.
    pub(super) fn flush(&mut self) -> Result<(), Failure> {
        self.teller.printer.flush()
    }

    /// Ends the input: what waits for more bytes is truncated.
    pub(super) fn finish(mut self) -> Result<Tally, Failure> {
        for ((link, reply), deframer) in &mut self.streams {
            let origin = Origin {
                direction: reply.map(|reply| match reply {
                    true => Direction::Reply,
                    false => Direction::Request,
                }),
                link: link.map(|number| (number, "")),
                time: None,
            };
            deframer.expire();
            while let Some(event) = deframer.next(&mut &[][..]) {
                self.teller.tell(origin, event)?;
            }
        }
        self.teller.end_noise()?;
        self.flush()?;
        Ok(self.teller.tally)
    }
}

impl<P: Printer> Teller<P> {
    fn tell(&mut self, origin: Origin<'_>, event: Event<'_>) -> Result<(), Failure> {
        let place = |offset| StreamPosition { offset, origin };
        match event {
            Event::Noise { offset, bytes } => self.noise(place(offset), bytes),
            Event::Rejected {
                offset,
                bytes,
                reason,
            } => {
                self.end_noise()?;
                self.tally.bad += 1;
                self.printer.rejected(place(offset), bytes, reason)
            }
            Event::Frame { offset, frame } => {
                self.end_noise()?;
                let from = origin.direction.map_or(self.from, From::from);
                let meaning = from.describe(&frame);
                match meaning {
                    Ok(_) => self.tally.good += 1,
                    Err(_) => self.tally.bad += 1,
                }
                self.printer.frame(place(offset), &frame, meaning)
            }
        }
    }

    fn noise(&mut self, place: StreamPosition<'_>, bytes: &[u8]) -> Result<(), Failure> {
        let stream = place.origin.stream();
        if self.noise != Some((stream, place.offset)) {
            self.end_noise()?;
            self.tally.bad += 1;
            self.printer.noise_begins(place)?;
        }
        self.noise = Some((stream, place.offset + bytes.len() as u64));
        self.printer.noise(bytes)
    }

    fn end_noise(&mut self) -> Result<(), Failure> {
        match self.noise.take() {
            Some(_) => self.printer.noise_ends(),
            None => Ok(()),
        }
    }
}
