//! Bytes to pieces: frames, rejected candidates, runs of noise.

use magician_protocol::{Deframer, Event};

use super::{From, Printer};
use crate::failure::Failure;

/// How many pieces were understood and how many not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) good: u64,
    pub(super) bad: u64,
}

/// Finds the pieces in a stream of bytes and hands them to a printer.
pub(super) struct Decoder<P: Printer> {
    deframer: Deframer,
    teller: Teller<P>,
}

/// What knows the events but not the bytes they come from.
struct Teller<P: Printer> {
    from: From,
    printer: P,
    tally: Tally,
    /// Where the run of noise under way ends so far.
    noise: Option<u64>,
}

impl<P: Printer> Decoder<P> {
    pub(super) fn new(from: From, printer: P) -> Self {
        Self {
            deframer: Deframer::new(),
            teller: Teller {
                from,
                printer,
                tally: Tally::default(),
                noise: None,
            },
        }
    }

    /// Takes more bytes.
    pub(super) fn push(&mut self, mut bytes: &[u8]) -> Result<(), Failure> {
        while let Some(event) = self.deframer.next(&mut bytes) {
            self.teller.tell(event)?;
        }
        Ok(())
    }

    /// Shows what has been found so far.
    pub(super) fn flush(&mut self) -> Result<(), Failure> {
        self.teller.printer.flush()
    }

    /// Ends the input: what waits for more bytes is truncated.
    pub(super) fn finish(mut self) -> Result<Tally, Failure> {
        self.deframer.expire();
        self.push(&[])?;
        self.teller.end_noise()?;
        self.flush()?;
        Ok(self.teller.tally)
    }
}

impl<P: Printer> Teller<P> {
    fn tell(&mut self, event: Event<'_>) -> Result<(), Failure> {
        match event {
            Event::Noise { offset, bytes } => self.noise(offset, bytes),
            Event::Rejected {
                offset,
                bytes,
                reason,
            } => {
                self.end_noise()?;
                self.tally.bad += 1;
                self.printer.rejected(offset, bytes, reason)
            }
            Event::Frame { offset, frame } => {
                self.end_noise()?;
                let meaning = self.from.describe(&frame);
                match meaning {
                    Ok(_) => self.tally.good += 1,
                    Err(_) => self.tally.bad += 1,
                }
                self.printer.frame(offset, &frame, meaning)
            }
        }
    }

    fn noise(&mut self, offset: u64, bytes: &[u8]) -> Result<(), Failure> {
        if self.noise != Some(offset) {
            self.end_noise()?;
            self.tally.bad += 1;
            self.printer.noise_begins(offset)?;
        }
        self.noise = Some(offset + bytes.len() as u64);
        self.printer.noise(bytes)
    }

    fn end_noise(&mut self) -> Result<(), Failure> {
        match self.noise.take() {
            Some(_) => self.printer.noise_ends(),
            None => Ok(()),
        }
    }
}
