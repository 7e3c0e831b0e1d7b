//! `decode`: bytes of the protocol explained.

mod hex;
mod human;
mod record;
mod source;
mod stream;

use std::ffi::OsString;

use clap::{Args, ValueEnum};
use magician_protocol::{DecodeError, Description, Direction, Frame, Rejection, describe};

use magician_record::trace::Packet;

use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;
pub(crate) use record::hex;
use stream::{Origin, Tally};

/// Explain bytes of the protocol: hex, a file, or stdin
#[derive(Args, Debug)]
#[command(after_help = "\
Text is read as hex if it has only hex digits, spaces, commas and 0x; a file may hold bytes, hex \
    text or a pcapng capture.

  magician decode AA AA 02 0A 00 F6
  magician decode --from arm --json capture.bin
  cat /dev/ttyUSB0 | magician decode -

A capture knows the direction of each packet; offsets count separately for each direction of each link.

Exit status 10 if bytes are not a frame, or a frame cannot be decoded.")]
pub(crate) struct Decode {
    /// Sender of the bytes, where the input does not say
    #[arg(long, value_name = "SIDE", default_value = "auto")]
    from: From,
    /// Bytes in hex, or a file, or - for stdin
    #[arg(required = true, value_name = "HEX|FILE|-")]
    input: Vec<OsString>,
}

/// The sender of the bytes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum From {
    /// The host
    Host,
    /// The arm
    Arm,
    /// The side whose layout fits; the host if both fit
    Auto,
}

impl std::convert::From<Direction> for From {
    fn from(direction: Direction) -> Self {
        match direction {
            Direction::Request => Self::Host,
            Direction::Reply => Self::Arm,
        }
    }
}

impl From {
    fn describe<'a>(self, frame: &Frame<'a>) -> Result<Description<'a>, DecodeError> {
        match self {
            Self::Host => describe(frame, Direction::Request),
            Self::Arm => describe(frame, Direction::Reply),
            Self::Auto => Description::guess(frame),
        }
    }
}

/// A direction in a word.
pub(crate) fn word(direction: Direction) -> &'static str {
    match direction {
        Direction::Request => "request",
        Direction::Reply => "reply",
    }
}

/// Where a piece begins: its position in the bytes of its direction and link, and what is known of
/// those.
#[derive(Clone, Copy, Debug)]
struct StreamPosition<'a> {
    offset: u64,
    origin: Origin<'a>,
}

/// What becomes of the pieces that the bytes consist of; a run of noise comes in parts.
trait Printer {
    fn frame(
        &mut self,
        place: StreamPosition<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure>;
    fn rejected(
        &mut self,
        place: StreamPosition<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Failure>;
    fn noise_begins(&mut self, place: StreamPosition<'_>) -> Result<(), Failure>;
    fn noise(&mut self, bytes: &[u8]) -> Result<(), Failure>;
    fn noise_ends(&mut self) -> Result<(), Failure>;
    fn flush(&mut self) -> Result<(), Failure>;
}

impl<P: Printer + ?Sized> Printer for Box<P> {
    fn frame(
        &mut self,
        place: StreamPosition<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure> {
        (**self).frame(place, frame, meaning)
    }

    fn rejected(
        &mut self,
        place: StreamPosition<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Failure> {
        (**self).rejected(place, bytes, reason)
    }

    fn noise_begins(&mut self, place: StreamPosition<'_>) -> Result<(), Failure> {
        (**self).noise_begins(place)
    }

    fn noise(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        (**self).noise(bytes)
    }

    fn noise_ends(&mut self) -> Result<(), Failure> {
        (**self).noise_ends()
    }

    fn flush(&mut self) -> Result<(), Failure> {
        (**self).flush()
    }
}

impl Decode {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let out = &mut context.out;
        let tally = match context.global.json {
            true => self.read(record::Records { out }),
            false => self.read(human::Lines::new(out)),
        }?;
        verdict(tally)
    }

    fn read(&self, printer: impl Printer) -> Result<Tally, Failure> {
        let mut decoder = stream::Decoder::new(self.from, printer);
        source::read(&self.input, &mut decoder)?;
        decoder.finish()
    }
}

/// Explains the packets of a capture as they come.
pub(crate) struct Packets<'o> {
    decoder: stream::Decoder<Box<dyn Printer + 'o>>,
}

impl<'o> Packets<'o> {
    pub(crate) fn new(out: &'o mut Output, json: bool) -> Self {
        let printer: Box<dyn Printer + 'o> = match json {
            true => Box::new(record::Records { out }),
            false => Box::new(human::Lines::new(out)),
        };
        let decoder = stream::Decoder::new(From::Auto, printer);
        Self { decoder }
    }

    /// Explains one more.
    pub(crate) fn packet(&mut self, packet: &Packet<'_>) -> Result<(), Failure> {
        self.decoder.push(Origin::of(packet), packet.bytes)
    }

    /// Shows what has been found so far.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        self.decoder.flush()
    }

    /// Ends, with a failure if something was not understood.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        verdict(self.decoder.finish()?)
    }
}

fn verdict(tally: Tally) -> Result<(), Failure> {
    let Tally { good, bad } = tally;
    if bad == 0 {
        return Ok(());
    }
    let frames = if good == 1 { "frame" } else { "frames" };
    let pieces = if bad == 1 { "piece" } else { "pieces" };
    let message = format!("{bad} {pieces} not understood, {good} {frames} understood");
    Err(Failure::new(Kind::CheckFailed, message))
}
