//! Frames as messages, with the field names of `magician decode --json`.

use std::io::{self, Write};

use magician_protocol::{
    DecodeError, Deframer, Description, Direction, Event, Frame, INTER_BYTE_TIMEOUT_MS, Rejection,
    Row, describe,
};
use serde::Serialize;

use super::Micros;
use super::file::{File, Topic};
use super::message::Time;

/// One direction of a link: the link's name, and the bytes of an incomplete frame.
pub(super) struct FrameLine {
    pub(super) name: String,
    deframer: Deframer,
    /// Time of the latest bytes.
    last_bytes_at: Micros,
}

impl FrameLine {
    pub(super) fn of(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            deframer: Deframer::new(),
            last_bytes_at: 0,
        }
    }

    /// Writes every frame that the bytes complete, and bytes outside of frames.
    pub(super) fn push_bytes<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        let Self { name, deframer, .. } = self;
        let mut input = bytes;
        while let Some(event) = deframer.next(&mut input) {
            let (bytes, error) = match event {
                Event::Frame { frame, .. } => {
                    write_frame(file, now, name, &frame, direction)?;
                    continue;
                }
                Event::Rejected { bytes, reason, .. } => (bytes, error_code(reason)),
                Event::Noise { bytes, .. } => (bytes, "noise"),
            };
            file.write(Topic::Frames, now, |timestamp| Message {
                error: Some(error),
                ..Message::of(timestamp, name, direction, bytes)
            })?;
        }
        Ok(())
    }

    /// Like [`push_bytes`](Self::push_bytes), but ends a partial frame if the line was silent
    /// before.
    pub(super) fn push_bytes_after_silence<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        // The same timeout as in the controller (E04).
        if now.saturating_sub(self.last_bytes_at) >= INTER_BYTE_TIMEOUT_MS * 1000 {
            self.silence(file, now, direction)?;
        }
        self.last_bytes_at = now;
        self.push_bytes(file, now, direction, bytes)
    }

    /// Gives up a partial frame.
    pub(super) fn silence<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        direction: Direction,
    ) -> io::Result<()> {
        self.deframer.expire();
        self.push_bytes(file, now, direction, &[])
    }
}

/// Both directions of a line, as seen by a host.
pub(super) struct HostLine {
    requests: FrameLine,
    replies: FrameLine,
}

impl HostLine {
    pub(super) fn of(name: &str) -> Self {
        Self {
            requests: FrameLine::of(name),
            replies: FrameLine::of(name),
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.requests.name
    }

    pub(super) fn push_bytes_after_silence<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        let line = match direction {
            Direction::Request => &mut self.requests,
            Direction::Reply => &mut self.replies,
        };
        line.push_bytes_after_silence(file, now, direction, bytes)
    }

    /// Gives up partial frames at the end of the recording.
    pub(super) fn end<W: Write>(&mut self, file: &mut File<W>, now: Micros) -> io::Result<()> {
        self.requests.silence(file, now, Direction::Request)?;
        self.replies.silence(file, now, Direction::Reply)
    }
}

pub(super) fn write_frame<W: Write>(
    file: &mut File<W>,
    now: Micros,
    link: &str,
    frame: &Frame<'_>,
    direction: Direction,
) -> io::Result<()> {
    let ctrl = frame.ctrl();
    let meaning = describe(frame, direction);
    file.write(Topic::Frames, now, |timestamp| {
        let message = Message {
            id: Some(frame.id()),
            write: Some(ctrl.write()),
            queued: Some(ctrl.queued()),
            ..Message::of(timestamp, link, direction, frame.bytes())
        };
        match &meaning {
            Ok(description) => Message {
                ok: true,
                command: Some(description.name),
                write: Some(description.write),
                params: Some(Params::Fields(description)),
                notes: description.notes().collect(),
                ..message
            },
            Err(error) => Message {
                command: Row::with_id(frame.id()).map(|row| row.form_name(ctrl)),
                params: Some(Params::Raw {
                    raw: hex(frame.params()),
                }),
                error: Some(match error {
                    DecodeError::UnknownId(_) => "unknown",
                    _ => "length",
                }),
                ..message
            },
        }
    })
}

/// A frame, or bytes outside of frames. Fields that do not apply are absent.
#[derive(Serialize)]
struct Message<'a> {
    timestamp: Time,
    link: &'a str,
    direction: &'static str,
    hex: String,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    command: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    write: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    queued: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    params: Option<Params<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'static str>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Params<'a> {
    Fields(&'a Description<'a>),
    Raw { raw: String },
}

impl<'a> Message<'a> {
    fn of(timestamp: Time, link: &'a str, direction: Direction, bytes: &[u8]) -> Self {
        Self {
            timestamp,
            link,
            direction: match direction {
                Direction::Request => "request",
                Direction::Reply => "reply",
            },
            hex: hex(bytes),
            ok: false,
            id: None,
            command: None,
            write: None,
            queued: None,
            params: None,
            notes: Vec::new(),
            error: None,
        }
    }
}

const fn error_code(reason: Rejection) -> &'static str {
    match reason {
        Rejection::Checksum { .. } => "checksum",
        Rejection::Length(_) => "length",
        Rejection::Truncated => "truncated",
    }
}

fn hex(bytes: &[u8]) -> String {
    const DIGITS: [char; 16] = [
        '0', '1', '2', '3', '4', '5', '6', '7', '8', '9', 'A', 'B', 'C', 'D', 'E', 'F',
    ];
    let digit = |nibble: u8| DIGITS[usize::from(nibble & 15)];
    (bytes.iter())
        .flat_map(|byte| [digit(byte >> 4), digit(*byte)])
        .collect()
}
