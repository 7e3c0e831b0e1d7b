//! Decoding of raw bytes into pieces: frames with their meaning, rejected candidates, and runs of
//! noise.
//!
//! A [`Decoder`] takes bytes in any split, keeps the directions of each link apart, and hands the
//! pieces to a [`Sink`]. Its memory is bounded.

use magician_protocol::{
    DecodeError, Deframer, Description, Direction, Event, Frame, Rejection, describe,
};

use crate::trace::{Packet, TraceError, read_trace};

/// Receives the pieces of the decoded bytes. A run of noise arrives in parts.
pub trait Sink {
    /// Error that ends the decoding.
    type Error;

    /// Receives a valid frame and its meaning, or the reason why it has none.
    ///
    /// # Errors
    /// The sink's own error.
    fn frame(
        &mut self,
        place: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Self::Error>;

    /// Receives a candidate rejected as a frame.
    ///
    /// # Errors
    /// The sink's own error.
    fn rejected(
        &mut self,
        place: Place<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Self::Error>;

    /// Starts a run of bytes without a frame.
    ///
    /// # Errors
    /// The sink's own error.
    fn noise_begins(&mut self, place: Place<'_>) -> Result<(), Self::Error>;

    /// Receives the next bytes of the run.
    ///
    /// # Errors
    /// The sink's own error.
    fn noise(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Ends the run.
    ///
    /// # Errors
    /// The sink's own error.
    fn noise_ends(&mut self) -> Result<(), Self::Error>;

    /// Called when no further piece can be decoded from the bytes so far.
    ///
    /// # Errors
    /// The sink's own error.
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

/// Position of a piece among the bytes of its direction and link, and the origin of these bytes.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// Number of bytes of the same direction and link before it.
    pub offset: u64,
    /// Origin of the bytes.
    pub origin: Origin<'a>,
}

/// Counts of decoded and of undecodable pieces.
#[derive(Clone, Copy, Debug, Default)]
pub struct PieceCounts {
    /// Frames with a known meaning.
    pub good: u64,
    /// Frames without a known meaning, rejected candidates and runs of noise.
    pub bad: u64,
}

/// Origin of a run of bytes, as far as known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin<'a> {
    /// Sender, if known.
    pub direction: Option<Direction>,
    /// Number and name of the link in a capture.
    pub link: Option<(u32, &'a str)>,
    /// Time, microseconds since 1970.
    pub time: Option<u64>,
}

/// Identity of a byte stream: link and direction.
type Stream = (Option<u32>, Option<bool>);

impl Origin<'_> {
    fn stream(&self) -> Stream {
        let reply = self
            .direction
            .map(|direction| direction == Direction::Reply);
        (self.link.map(|(number, _)| number), reply)
    }
}

/// Decodes streams of bytes and hands the pieces to a [`Sink`].
pub struct Decoder<S: Sink> {
    streams: Vec<(Stream, Deframer)>,
    interpreter: PieceInterpreter<S>,
}

/// Interprets the events of a deframer. Separate from [`Decoder`], because an event borrows the
/// deframer.
struct PieceInterpreter<S: Sink> {
    sender: Option<Direction>,
    sink: S,
    tally: PieceCounts,
    /// Run of noise in progress: its stream, and its end so far.
    noise: Option<(Stream, u64)>,
}

impl<S: Sink> Decoder<S> {
    /// Creates a decoder. `sender` is assumed for bytes whose direction is not known.
    ///
    /// If it is `None`, a frame counts as the direction whose layout it fits, or as a request if it
    /// fits both.
    pub fn new(sender: Option<Direction>, sink: S) -> Self {
        Self {
            streams: Vec::new(),
            interpreter: PieceInterpreter {
                sender,
                sink,
                tally: PieceCounts::default(),
                noise: None,
            },
        }
    }

    /// Decodes further bytes.
    ///
    /// # Errors
    /// Errors of the sink.
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
            self.interpreter.handle_event(origin, event)?;
        }
        Ok(())
    }

    /// Decodes a packet of a capture.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn packet(&mut self, packet: &Packet<'_>) -> Result<(), S::Error> {
        let origin = Origin {
            direction: packet.direction,
            link: Some((packet.link, &packet.link_name)),
            time: Some(packet.time),
        };
        self.push(origin, packet.bytes)
    }

    /// Decodes a whole capture, as far as it can be read. Returns the first error in it, if any.
    ///
    /// # Errors
    /// Errors of the sink.
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

    /// Tells the sink that no further piece can be decoded from the bytes so far.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn flush(&mut self) -> Result<(), S::Error> {
        self.interpreter.sink.flush()
    }

    /// Ends the input: incomplete frames are truncated. Returns the counts and the sink.
    ///
    /// # Errors
    /// Errors of the sink.
    pub fn finish(mut self) -> Result<(PieceCounts, S), S::Error> {
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
                self.interpreter.handle_event(origin, event)?;
            }
        }
        self.interpreter.end_noise()?;
        self.flush()?;
        Ok((self.interpreter.tally, self.interpreter.sink))
    }
}

impl<S: Sink> PieceInterpreter<S> {
    fn handle_event(&mut self, origin: Origin<'_>, event: Event<'_>) -> Result<(), S::Error> {
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
        // Consecutive noise of one stream is one run, however the deframer reports it.
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
