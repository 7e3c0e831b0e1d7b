//! Decoded pieces as JSON, one object per line. The hex of a run of noise is written as it arrives,
//! so that memory stays bounded for runs of any length.

use std::io::Write;

use magician_protocol::{DecodeError, Description, Frame, Rejection, Row};
use magician_record::pieces::{Origin, Place, Sink};
use serde::Serialize;

use super::direction_word;
use crate::failure::Failure;
use crate::output::Output;

/// Writes pieces as JSON.
pub(super) struct Records<'o> {
    pub(super) out: &'o mut Output,
}

#[derive(Serialize)]
struct DecodedFrame<'a> {
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
    #[serde(flatten)]
    seen: CaptureFields<'a>,
}

#[derive(Serialize)]
struct UndecodedFrame<'a> {
    offset: u64,
    hex: String,
    ok: bool,
    id: u8,
    command: Option<&'static str>,
    write: bool,
    queued: bool,
    params: Raw,
    error: &'static str,
    #[serde(flatten)]
    seen: CaptureFields<'a>,
}

/// Additional fields of a piece from a capture: the link, and the time in microseconds since 1970.
#[derive(Serialize)]
struct CaptureFields<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    link: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<u64>,
}

impl<'a> CaptureFields<'a> {
    fn of(origin: Origin<'a>) -> Self {
        Self {
            link: origin
                .link
                .map(|(_, name)| name)
                .filter(|name| !name.is_empty()),
            time: origin.time,
        }
    }
}

#[derive(Serialize)]
struct Raw {
    raw: String,
}

#[derive(Serialize)]
struct Rejected<'a> {
    offset: u64,
    hex: String,
    ok: bool,
    error: &'static str,
    #[serde(flatten)]
    seen: CaptureFields<'a>,
}

/// Returns bytes as upper-case hex digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

impl Sink for Records<'_> {
    type Error = Failure;

    fn frame(
        &mut self,
        place: Place<'_>,
        frame: &Frame<'_>,
        meaning: Result<Description<'_>, DecodeError>,
    ) -> Result<(), Failure> {
        let description = match &meaning {
            Ok(description) => description,
            Err(error) => return self.out.json(&undecoded(place, frame, *error)),
        };
        self.out.json(&DecodedFrame {
            offset: place.offset,
            hex: hex(frame.bytes()),
            ok: true,
            id: frame.id(),
            command: description.name,
            direction: direction_word(description.direction),
            write: description.write,
            queued: description.queued,
            params: description,
            notes: description.notes().collect(),
            seen: CaptureFields::of(place.origin),
        })
    }

    fn rejected(
        &mut self,
        place: Place<'_>,
        bytes: &[u8],
        reason: Rejection,
    ) -> Result<(), Failure> {
        self.out.json(&Rejected {
            offset: place.offset,
            hex: hex(bytes),
            ok: false,
            error: reason.name(),
            seen: CaptureFields::of(place.origin),
        })
    }

    fn noise_begins(&mut self, place: Place<'_>) -> Result<(), Failure> {
        Ok(write!(self.out, r#"{{"offset":{},"hex":""#, place.offset)?)
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

/// Describes a complete frame that cannot be decoded: unknown id, or parameters that fit no layout.
fn undecoded<'a>(place: Place<'a>, frame: &Frame<'_>, error: DecodeError) -> UndecodedFrame<'a> {
    let ctrl = frame.ctrl();
    UndecodedFrame {
        offset: place.offset,
        hex: hex(frame.bytes()),
        ok: false,
        id: frame.id(),
        command: Row::with_id(frame.id()).map(|row| row.form_name(ctrl)),
        write: ctrl.write(),
        queued: ctrl.queued(),
        params: Raw {
            raw: hex(frame.params()),
        },
        error: match error {
            DecodeError::UnknownId(_) => "unknown",
            _ => "length",
        },
        seen: CaptureFields::of(place.origin),
    }
}
