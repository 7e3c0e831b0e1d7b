//! Frames as messages, in the words of `magician decode --json`.

use std::collections::BTreeMap;
use std::io::{self, Write};

use magician_protocol::{
    DecodeError, Deframer, Description, Direction, Event, Frame, FrameBuf, Rejection, Row, describe,
};
use serde::Serialize;

use crate::mcap::Micros;
use crate::mcap::file::{File, Topic};
use crate::mcap::message::Time;
use magician_sim::LinkId;

/// The links: their names, and what has been heard of frames that are not complete.
#[derive(Default)]
pub(super) struct Lines(BTreeMap<LinkId, Line>);

struct Line {
    name: String,
    deframer: Deframer,
}

impl Line {
    fn of(link: LinkId) -> Self {
        Self {
            name: format!("link {}", link.0),
            deframer: Deframer::new(),
        }
    }
}

impl Lines {
    pub(super) fn name(&mut self, link: LinkId, name: &str) {
        name.clone_into(&mut self.line(link).name);
    }

    pub(super) fn forget(&mut self, link: LinkId) {
        self.0.remove(&link);
    }

    fn line(&mut self, link: LinkId) -> &mut Line {
        self.0.entry(link).or_insert_with(|| Line::of(link))
    }

    /// Writes every frame that bytes from a peer complete, and what turns out to belong to none.
    pub(super) fn heard<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
        bytes: &[u8],
    ) -> io::Result<()> {
        let Line { name, deframer } = self.line(link);
        let mut input = bytes;
        while let Some(event) = deframer.next(&mut input) {
            let (bytes, error) = match event {
                Event::Frame { frame, .. } => {
                    write_frame(file, now, name, &frame, Direction::Request)?;
                    continue;
                }
                Event::Rejected { bytes, reason, .. } => (bytes, word(reason)),
                Event::Noise { bytes, .. } => (bytes, "noise"),
            };
            file.write(Topic::Frames, now, |timestamp| Message {
                error: Some(error),
                ..Message::of(timestamp, name, Direction::Request, bytes)
            })?;
        }
        Ok(())
    }

    /// What a peer began will not be completed.
    pub(super) fn silence<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
    ) -> io::Result<()> {
        self.line(link).deframer.expire();
        self.heard(file, now, link, &[])
    }

    pub(super) fn answered<W: Write>(
        &mut self,
        file: &mut File<W>,
        now: Micros,
        link: LinkId,
        frame: &FrameBuf,
    ) -> io::Result<()> {
        let name = &self.line(link).name;
        write_frame(file, now, name, &frame.frame(), Direction::Reply)
    }
}

fn write_frame<W: Write>(
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

/// A frame, or bytes that are none. What does not apply is absent.
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

const fn word(reason: Rejection) -> &'static str {
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
