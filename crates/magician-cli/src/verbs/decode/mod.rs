//! `decode`: explains bytes of the protocol.

mod human;
mod record;
mod source;

use std::ffi::OsString;

use clap::{Args, ValueEnum};
use magician_protocol::Direction;
use magician_record::pieces::{Decoder, PieceCounts, Sink};
use magician_record::trace::Packet;

use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;
pub(crate) use record::hex;

/// Decode protocol bytes from hex text, a file, or stdin
#[derive(Args, Debug)]
#[command(after_help = "\
Text that consists of hex digits, spaces, commas and 0x is read as hex; a file may contain bytes, \
hex text or a pcapng capture.

  magician decode AA AA 02 0A 00 F6
  magician decode --from arm --json capture.bin
  cat /dev/ttyUSB0 | magician decode -

A capture contains the direction of each packet; offsets are counted separately for each direction of each link.

Exit status 10 if bytes are not a frame, or a frame cannot be decoded.")]
pub(crate) struct Decode {
    /// Sender of the bytes, if the input does not contain it
    #[arg(long = "from", value_name = "SIDE", default_value = "auto")]
    sender: Sender,
    /// Bytes in hex, a file, or - for stdin
    #[arg(required = true, value_name = "HEX|FILE|-")]
    input: Vec<OsString>,
}

/// The sender of the bytes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Sender {
    /// Host
    Host,
    /// Arm
    Arm,
    /// Side whose layout fits; host if both fit
    Auto,
}

impl Sender {
    fn direction(self) -> Option<Direction> {
        match self {
            Self::Host => Some(Direction::Request),
            Self::Arm => Some(Direction::Reply),
            Self::Auto => None,
        }
    }
}

/// Returns the word for a direction.
pub(crate) fn direction_word(direction: Direction) -> &'static str {
    match direction {
        Direction::Request => "request",
        Direction::Reply => "reply",
    }
}

/// Output of the decoded pieces.
type Printer<'o> = Box<dyn Sink<Error = Failure> + 'o>;

impl Decode {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let printer = printer(&mut context.out, context.global.json);
        let mut decoder = Decoder::new(self.sender.direction(), printer);
        source::read(&self.input, &mut decoder)?;
        verdict(decoder.finish()?.0)
    }
}

fn printer(out: &mut Output, json: bool) -> Printer<'_> {
    if json {
        Box::new(record::Records { out })
    } else {
        Box::new(human::Lines::new(out))
    }
}

/// Decoder for packets of a live capture.
pub(crate) struct Packets<'o> {
    decoder: Decoder<Printer<'o>>,
}

impl<'o> Packets<'o> {
    pub(crate) fn new(out: &'o mut Output, json: bool) -> Self {
        let decoder = Decoder::new(None, printer(out, json));
        Self { decoder }
    }

    /// Decodes one packet.
    pub(crate) fn packet(&mut self, packet: &Packet<'_>) -> Result<(), Failure> {
        self.decoder.packet(packet)
    }

    /// Prints what has been decoded so far.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        self.decoder.flush()
    }

    /// Ends the decoding. Fails if part of the input could not be decoded.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        verdict(self.decoder.finish()?.0)
    }
}

fn verdict(tally: PieceCounts) -> Result<(), Failure> {
    let PieceCounts { good, bad } = tally;
    if bad == 0 {
        return Ok(());
    }
    let frames = if good == 1 { "frame" } else { "frames" };
    let pieces = if bad == 1 { "piece" } else { "pieces" };
    let message = format!("{bad} {pieces} not understood, {good} {frames} understood");
    Err(Failure::new(Kind::CheckFailed, message))
}
