//! Reader of recordings as MCAP: messages of `/pose` (<https://mcap.dev/spec>,
//! `foxglove.PoseInFrame` as JSON).
//!
//! The records are parsed here and not by the library that writes them, because it panics on chunks
//! with inconsistent lengths.

use magician_host::{Message, message};
use serde::Deserialize;

use super::recording::{self, Sample};
use crate::formats::content::points::MCAP_MAGIC;
use crate::{Diagnostic, DiagnosticCode, Origin, Parsed, Plan};

/// Opcode of a record that defines a channel.
const CHANNEL_OPCODE: u8 = 0x04;
/// Opcode of a message.
const MESSAGE_OPCODE: u8 = 0x05;
/// Opcode of a chunk, which contains records.
const CHUNK_OPCODE: u8 = 0x06;

const NANOS_PER_SECOND: f64 = 1e9;
const MM_PER_METRE: f64 = 1000.0;

/// The part used of a `foxglove.PoseInFrame`, m.
#[derive(Deserialize)]
struct PoseInFrame {
    pose: Pose,
}

#[derive(Deserialize)]
struct Pose {
    position: Position,
    orientation: Orientation,
}

#[derive(Deserialize)]
struct Position {
    x: f64,
    y: f64,
    z: f64,
}

/// Quaternion of a rotation about the vertical.
#[derive(Deserialize)]
struct Orientation {
    z: f64,
    w: f64,
}

/// Cursor over bytes.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    /// Reads a little-endian number.
    fn number(&mut self, bytes: u64) -> Option<u64> {
        let taken = self.take(bytes)?.iter().rev();
        Some(taken.fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.number(4)?;
        self.take(length)
    }

    /// Reads the next record. `None` at the end, or if the rest is incomplete.
    fn record(&mut self) -> Option<(u8, Bytes<'a>)> {
        let mut ahead = *self;
        let kind = ahead.number(1)?;
        let length = ahead.number(8)?;
        let content = ahead.take(length)?;
        *self = ahead;
        Some((kind as u8, Bytes(content)))
    }
}

/// Poses found so far.
#[derive(Default)]
struct PoseChannel {
    /// Id of the channel `/pose`.
    channel: Option<u64>,
    first: Option<u64>,
    samples: Vec<Sample>,
}

pub(super) fn read(bytes: &[u8], resample: Option<f64>) -> Result<Parsed<Plan>, Diagnostic> {
    let mut records = Bytes(bytes.get(MCAP_MAGIC.len()..).unwrap_or_default());
    let mut found = PoseChannel::default();
    while let Some((kind, content)) = records.record() {
        match kind {
            CHUNK_OPCODE => found.chunk(content)?,
            kind => found.record(kind, content)?,
        }
    }
    if found.samples.is_empty() {
        return Err(Diagnostic::of_file(message!(
            "it has no /pose: no path of the tool was recorded"
        )));
    }
    let mut reading = recording::plan(&found.samples, resample)?;
    // A complete file ends with the magic bytes.
    if records.0 != MCAP_MAGIC {
        let note = Diagnostic::of_file(message!(
            "the recording is cut off: it is followed to its end"
        ));
        reading.notes.push(note.coded(DiagnosticCode::LeftOut));
    }
    Ok(reading)
}

fn damaged(what: Message) -> Diagnostic {
    Diagnostic::of_file(message!("the recording is damaged: {what}", what))
}

impl PoseChannel {
    /// Parses a chunk. Its checksum is verified, so that a damaged file does not lead the arm
    /// elsewhere.
    fn chunk(&mut self, mut content: Bytes<'_>) -> Result<(), Diagnostic> {
        let mut parts = || {
            content.take(8 + 8 + 8)?;
            let checksum = content.number(4)?;
            let compression = content.text()?;
            let length = content.number(8)?;
            Some((checksum, compression, content.take(length)?))
        };
        let (checksum, compression, data) =
            parts().ok_or_else(|| damaged(message!("a chunk is shorter than it says")))?;
        if !compression.is_empty() {
            let what = String::from_utf8_lossy(compression).into_owned();
            let diagnostic = Diagnostic::of_file(message!(
                "chunks compressed with {what} are not supported",
                what
            ));
            return Err(diagnostic.help(message!("write it without compression")));
        }
        if checksum != 0 && checksum != u64::from(crc32fast::hash(data)) {
            return Err(damaged(message!("a chunk has a wrong checksum")));
        }
        let mut records = Bytes(data);
        while let Some((kind, content)) = records.record() {
            self.record(kind, content)?;
        }
        Ok(())
    }

    fn record(&mut self, kind: u8, mut content: Bytes<'_>) -> Result<(), Diagnostic> {
        let short = || damaged(message!("a record is shorter than it says"));
        match kind {
            CHANNEL_OPCODE => {
                let mut parts = || {
                    let id = content.number(2)?;
                    content.take(2)?;
                    Some((id, content.text()?, content.text()?))
                };
                let (id, topic, encoding) = parts().ok_or_else(short)?;
                if topic == b"/pose" {
                    if encoding != b"json" {
                        let what = message!(
                            "the messages of /pose are not JSON, the only supported encoding"
                        );
                        return Err(Diagnostic::of_file(what));
                    }
                    self.channel = Some(id);
                }
            }
            MESSAGE_OPCODE => {
                let mut parts = || {
                    let channel = content.number(2)?;
                    content.take(4)?;
                    let time = content.number(8)?;
                    content.take(8)?;
                    Some((channel, time))
                };
                let (channel, time) = parts().ok_or_else(short)?;
                if self.channel == Some(channel) {
                    self.message(time, content.0)?;
                }
            }
            // Schemas, indices, attachments and metadata are not needed.
            _ => {}
        }
        Ok(())
    }

    fn message(&mut self, time: u64, data: &[u8]) -> Result<(), Diagnostic> {
        let PoseInFrame { pose } = serde_json::from_slice(data).map_err(|error| {
            Diagnostic::of_file(message!(
                "a message of /pose is not a foxglove.PoseInFrame: {error}",
                error = error.to_string()
            ))
        })?;
        let begun = *self.first.get_or_insert(time);
        let Position { x, y, z } = pose.position;
        let r = 2.0 * libm::atan2(pose.orientation.z, pose.orientation.w).to_degrees();
        self.samples.push(Sample {
            t: time.saturating_sub(begun) as f64 / NANOS_PER_SECOND,
            pose: [x * MM_PER_METRE, y * MM_PER_METRE, z * MM_PER_METRE, r],
            j4: None,
            origin: Origin::NONE,
        });
        Ok(())
    }
}
