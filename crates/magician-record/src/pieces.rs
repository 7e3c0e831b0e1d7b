//! Bytes of lines in pieces: frames with their meaning, rejected candidates, runs of noise.
//!
//! A [`Decoder`] finds them in bytes that come as they come, each direction of each link on its own, and hands them to a [`Sink`]
//! in bounded memory.

use magician_protocol::{
    DecodeError, Deframer, Description, Direction, Event, Frame, Rejection, describe,
};

use crate::trace::{Packet, TraceError, read_trace};

/// What becomes of the pieces that the bytes consist of; a run of noise comes in parts.
pub trait Sink {
    /// Why it cannot take any more.
    type Error;

    /// A whole frame, and what it means if that can be told.
    ///
    /// # Errors
    /// Its own.
    fn frame(
        &mut self,
        place: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Self::Error>;

    /// A candidate that is not a frame.
    ///
    /// # Errors
    /// Its own.
    fn rejected(
        &mut self,
        place: Place<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Self::Error>;

    /// A run of bytes without a frame begins.
    ///
    /// # Errors
    /// Its own.
    fn noise_begins(&mut self, place: Place<'_>) -> Result<(), Self::Error>;

    /// The next bytes of the run.
    ///
    /// # Errors
    /// Its own.
    fn noise(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;

    /// The run is over.
    ///
    /// # Errors
    /// Its own.
    fn noise_ends(&mut self) -> Result<(), Self::Error>;

    /// Nothing more is to be had of the bytes so far.
    ///
    /// # Errors
    /// Its own.
    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl<S: Sink + ?Sized> Sink for Box<S> {
    type Error = S::Error;

    fn frame(
        &mut self,
        place: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), S::Error> {
        (**self).frame(place, frame, meaning)
    }

    fn rejected(
        &mut self,
        place: Place<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), S::Error> {
        (**self).rejected(place, bytes, reason)
    }

    fn noise_begins(&mut self, place: Place<'_>) -> Result<(), S::Error> {
        (**self).noise_begins(place)
    }

    fn noise(&mut self, bytes: &[u8]) -> Result<(), S::Error> {
        (**self).noise(bytes)
    }

    fn noise_ends(&mut self) -> Result<(), S::Error> {
        (**self).noise_ends()
    }

    fn flush(&mut self) -> Result<(), S::Error> {
        (**self).flush()
    }
}

/// Where a piece begins: its position in the bytes of its direction and link, and what is known of those.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// Bytes of the same direction and link before it.
    pub offset: u64,
    /// What it is part of.
    pub origin: Origin<'a>,
}

/// How many pieces were understood and how many not.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Frames that were understood.
    pub good: u64,
    /// All else.
    pub bad: u64,
}

/// What a run of bytes is part of, and what is known of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin<'a> {
    /// The sender, if known.
    pub direction: Option<Direction>,
    /// Number and name of the link in a capture.
    pub link: Option<(u32, &'a str)>,
    /// When, microseconds since 1970.
    pub time: Option<u64>,
}

/// The bytes of one direction of one link.
type Stream = (Option<u32>, Option<bool>);

impl Origin<'_> {
    fn stream(&self) -> Stream {
        let reply = self
            .direction
            .map(|direction| direction == Direction::Reply);
        (self.link.map(|(number, _)| number), reply)
    }
}

/// Finds the pieces in streams of bytes and hands them to a [`Sink`].
pub struct Decoder<S: Sink> {
    streams: Vec<(Stream, Deframer)>,
    teller: Teller<S>,
}

/// What knows the events but not the bytes they come from.
struct Teller<S: Sink> {
    sender: Option<Direction>,
    sink: S,
    tally: Tally,
    /// The run of noise under way: its stream, and where it ends so far.
    noise: Option<(Stream, u64)>,
}

impl<S: Sink> Decoder<S> {
    /// Takes bytes of this sender where the input does not say; without one the side whose layout fits, the host if both fit.
    pub fn new(sender: Option<Direction>, sink: S) -> Self {
        Self {
            streams: Vec::new(),
            teller: Teller {
                sender,
                sink,
                tally: Tally::default(),
                noise: None,
            },
        }
    }

    /// Takes more bytes.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn push(&mut self, origin: Origin<'_>, mut bytes: &[u8]) -> Result<(), S::Error> {
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

    /// Takes a packet of a capture.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn packet(&mut self, packet: &Packet<'_>) -> Result<(), S::Error> {
        let origin = Origin {
            direction: packet.direction,
            link: Some((packet.link, &packet.link_name)),
            time: Some(packet.time),
        };
        self.push(origin, packet.bytes)
    }

    /// Takes a whole capture, as far as it can be read; the first thing that is wrong with it, if there is one.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn capture(&mut self, file: &[u8]) -> Result<Option<TraceError>, S::Error> {
        let mut wrong = None;
        for packet in read_trace(file) {
            match packet {
                Ok(packet) => self.packet(&packet)?,
                Err(error) => wrong = wrong.or(Some(error)),
            }
        }
        self.flush()?;
        Ok(wrong)
    }

    /// Tells the sink that nothing more is to be had of the bytes so far.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn flush(&mut self) -> Result<(), S::Error> {
        self.teller.sink.flush()
    }

    /// Ends the input: what waits for more bytes is truncated. How many pieces there were, and the sink.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(mut self) -> Result<(Tally, S), S::Error> {
        for ((link, reply), deframer) in &mut self.streams {
            let origin = Origin {
                direction: reply.map(|reply| {
                    if reply {
                        Direction::Reply
                    } else {
                        Direction::Request
                    }
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
        Ok((self.teller.tally, self.teller.sink))
    }
}

impl<S: Sink> Teller<S> {
    fn tell(&mut self, origin: Origin<'_>, event: Event<'_>) -> Result<(), S::Error> {
        let place = |offset| Place { offset, origin };
        match event {
            Event::Noise { offset, bytes } => self.noise(place(offset), bytes),
            Event::Rejected {
                offset,
                bytes,
                reason,
            } => {
                self.end_noise()?;
                self.tally.bad += 1;
                self.sink.rejected(place(offset), bytes, reason)
            }
            Event::Frame { offset, frame } => {
                self.end_noise()?;
                let meaning = match origin.direction.or(self.sender) {
                    Some(direction) => describe(&frame, direction),
                    None => Description::guess(&frame),
                };
                match meaning {
                    Ok(_) => self.tally.good += 1,
                    Err(_) => self.tally.bad += 1,
                }
                self.sink.frame(place(offset), &frame, meaning)
            }
        }
    }

    fn noise(&mut self, place: Place<'_>, bytes: &[u8]) -> Result<(), S::Error> {
        let stream = place.origin.stream();
        if self.noise != Some((stream, place.offset)) {
            self.end_noise()?;
            self.tally.bad += 1;
            self.sink.noise_begins(place)?;
        }
        self.noise = Some((stream, place.offset + bytes.len() as u64));
        self.sink.noise(bytes)
    }

    fn end_noise(&mut self) -> Result<(), S::Error> {
        match self.noise.take() {
            Some(_) => self.sink.noise_ends(),
            None => Ok(()),
        }
    }
}
