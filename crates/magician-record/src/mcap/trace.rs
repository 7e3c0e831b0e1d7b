//! Extraction of the frames of a recording as a trace.

use std::collections::BTreeMap;

use magician_protocol::Direction;
use serde::Deserialize;
use thiserror::Error;

use super::file::Topic;
use crate::trace::{TraceLink, TraceWriter};

/// First bytes of an MCAP file.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// True if a file begins like a recording (or any MCAP file).
#[must_use]
pub fn is_recording(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Reason why a recording contains no trace.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FramesError {
    /// Not an MCAP file, or damaged at its very beginning.
    #[error("the recording cannot be read: {0}")]
    Unreadable(String),
    /// A message of `/frames` was not written by this crate.
    #[error("message {number} of /frames is not a frame of a line")]
    Message {
        /// Number of the message, from 1.
        number: usize,
    },
    /// The recording has no messages in `/frames`.
    #[error("the recording has no frames: nothing in /frames")]
    Empty,
}

/// Bytes of one message: a frame, or bytes outside of frames.
struct Packet {
    time: u64,
    link: String,
    direction: Direction,
    bytes: Vec<u8>,
}

#[derive(Deserialize)]
struct Message {
    link: String,
    direction: String,
    hex: String,
}

/// Converts `/frames` of a recording to a [trace](crate::trace): one packet for each message, in
/// order of time.
///
/// A file without an end, as a killed program leaves it, is converted as far as it goes.
///
/// # Errors
/// [`FramesError`] if the file is unreadable, or has no frames of this crate.
pub fn trace_of(recording: &[u8]) -> Result<Vec<u8>, FramesError> {
    let unreadable = |error: mcap::McapError| FramesError::Unreadable(error.to_string());
    let options = mcap::read::Options::IgnoreEndMagic.into();
    let messages = mcap::MessageStream::new_with_options(recording, options).map_err(unreadable)?;
    let mut frames = Vec::new();
    // Records have no markers to synchronise on, so everything behind damaged bytes is lost.
    for message in messages.map_while(Result::ok) {
        if message.channel.topic == Topic::Frames.name() {
            let number = frames.len() + 1;
            let wrong = FramesError::Message { number };
            let packet = packet(message.log_time / 1000, &message.data);
            frames.push(packet.ok_or(wrong)?);
        }
    }
    if frames.is_empty() {
        return Err(FramesError::Empty);
    }
    // Chunks of a second each may be stored in any order.
    frames.sort_by_key(|packet| packet.time);
    let mut trace = Vec::new();
    // Writing to memory does not fail.
    write(&mut trace, &frames).map_err(|error| FramesError::Unreadable(error.to_string()))?;
    Ok(trace)
}

fn packet(time: u64, text: &[u8]) -> Option<Packet> {
    let Message {
        link,
        direction,
        hex,
    } = serde_json::from_slice(text).ok()?;
    let direction = match &*direction {
        "request" => Direction::Request,
        "reply" => Direction::Reply,
        _ => return None,
    };
    let digit = |letter: u8| char::from(letter).to_digit(16);
    let pair = |pair: &[u8]| match pair {
        [high, low] => Some((digit(*high)? * 16 + digit(*low)?) as u8),
        _ => None,
    };
    let bytes = hex.as_bytes().chunks(2).map(pair).collect::<Option<_>>()?;
    Some(Packet {
        time,
        link,
        direction,
        bytes,
    })
}

fn write(out: &mut Vec<u8>, packets: &[Packet]) -> std::io::Result<()> {
    let mut writer = TraceWriter::new(out)?;
    let mut links: BTreeMap<&str, TraceLink> = BTreeMap::new();
    for packet in packets {
        let link = match links.get(&*packet.link) {
            Some(link) => *link,
            None => {
                let link = writer.link(&packet.link)?;
                links.insert(&packet.link, link);
                link
            }
        };
        writer.record(link, packet.time, packet.direction, &packet.bytes)?;
    }
    Ok(())
}
