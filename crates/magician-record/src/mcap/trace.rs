//! The frames of a recording as a trace.

use std::collections::BTreeMap;

use magician_protocol::Direction;
use serde::Deserialize;
use thiserror::Error;

use super::file::Topic;
use crate::trace::{TraceLink, TraceWriter};

/// How an MCAP file begins.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Whether a file begins as a recording (any MCAP file) does.
#[must_use]
pub fn is_recording(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Why a recording has no trace in it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FramesError {
    /// It is no MCAP file, or damaged where not even its beginning can be read.
    #[error("the recording cannot be read: {0}")]
    Unreadable(String),
    /// A message of `/frames` is none of ours.
    #[error("message {number} of /frames is not a frame of a line")]
    Message {
        /// Which, from 1.
        number: usize,
    },
    /// There is no message of `/frames`.
    #[error("the recording has no frames: nothing in /frames")]
    Empty,
}

/// Bytes of a line.
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

/// The `/frames` of a recording as a [trace](crate::trace): each message a packet, in the order in which they passed. What is
/// missing at the end of a file whose program was killed is left out.
///
/// # Errors
/// A [`FramesError`].
pub fn trace_of(recording: &[u8]) -> Result<Vec<u8>, FramesError> {
    let unreadable = |error: mcap::McapError| FramesError::Unreadable(error.to_string());
    let options = mcap::read::Options::IgnoreEndMagic.into();
    let messages = mcap::MessageStream::new_with_options(recording, options).map_err(unreadable)?;
    let mut frames = Vec::new();
    // What follows damage is not found.
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
    // Written in pieces of a second each, which may lie beside each other.
    frames.sort_by_key(|packet| packet.time);
    let mut trace = Vec::new();
    // It is written to memory.
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
    let digit = |sign: u8| char::from(sign).to_digit(16);
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
