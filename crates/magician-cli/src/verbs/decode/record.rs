//! Pieces as JSON, one object a line. The hex of a run of noise is written as it comes, so that
//! a run of any length takes no memory.

use std::io::Write;

use magician_protocol::{DecodeError, Description, Direction, Frame, Rejection, Row};
use serde::Serialize;

use super::Printer;
use crate::failure::Failure;
use crate::output::Output;

/// Writes the pieces as JSON.
pub(super) struct Records<'o> {
    pub(super) out: &'o mut Output,
}

#[derive(Serialize)]
struct Understood<'a> {
    offset: u64,
    hex: String,
    ok: bool,
    id: u8,
    command: &'static str,
    direction: &'static str,
    write: bool,
    queued: bool,
    params: &'a Description<'a>,
    notes: Vec<&'static str>,
}

#[derive(Serialize)]
struct Misfit {
    offset: u64,
    hex: String,
    ok: bool,
    id: u8,
    command: Option<&'static str>,
    write: bool,
    queued: bool,
    params: Raw,
    error: &'static str,
}

#[derive(Serialize)]
struct Raw {
    raw: String,
}

#[derive(Serialize)]
struct Rejected {
    offset: u64,
    hex: String,
    ok: bool,
    error: &'static str,
}

/// Bytes in hex, as JSON has them.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

impl Printer for Records<'_> {
    fn frame(
        &mut self,
        offset: u64,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure> {
        let description = match &meaning {
            Ok(description) => description,
            Err(error) => return self.out.json(&misfit(offset, frame, *error)),
        };
        self.out.json(&Understood {
            offset,
            hex: hex(frame.bytes()),
            ok: true,
            id: frame.id(),
            command: description.name,
            direction: match description.direction {
                Direction::Request => "request",
                Direction::Reply => "reply",
            },
            write: description.write,
            queued: description.queued,
            params: description,
            notes: description.notes().collect(),
        })
    }

    fn rejected(&mut self, offset: u64, bytes: &[u8], reason: Rejection) -> Result<(), Failure> {
        self.out.json(&Rejected {
            offset,
            hex: hex(bytes),
            ok: false,
            error: match reason {
                Rejection::Checksum { .. } => "checksum",
                Rejection::Length(_) => "length",
                Rejection::Truncated => "truncated",
            },
        })
    }

    fn noise_begins(&mut self, offset: u64) -> Result<(), Failure> {
        Ok(write!(self.out, r#"{{"offset":{offset},"hex":""#)?)
    }

    fn noise(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        Ok(write!(self.out, "{}", hex(bytes))?)
    }

    fn noise_ends(&mut self) -> Result<(), Failure> {
        self.out.line(r#"","ok":false,"error":"noise"}"#)
    }

    fn flush(&mut self) -> Result<(), Failure> {
        self.out.flush()
    }
}

/// A whole frame that nobody understands: an unknown id, or parameters that fit no form.
fn misfit(offset: u64, frame: &Frame<'_>, error: DecodeError) -> Misfit {
    let ctrl = frame.ctrl();
    Misfit {
        offset,
        hex: hex(frame.bytes()),
        ok: false,
        id: frame.id(),
        command: Row::with_id(frame.id()).map(|row| match ctrl.write() || ctrl.queued() {
            true if row.set.is_some() => row.set_name,
            _ if row.value.is_some() => row.get_name,
            _ => row.set_name,
        }),
        write: ctrl.write(),
        queued: ctrl.queued(),
        params: Raw {
            raw: hex(frame.params()),
        },
        error: match error {
            DecodeError::UnknownId(_) => "unknown",
            _ => "length",
        },
    }
}
