//! Trace files: all bytes between hosts and an arm, with their times.
//!
//! A trace is a pcapng file (IETF draft-ietf-opsawg-pcapng) of link type USER0 (147), which
//! Wireshark opens. Nothing is added to the bytes:
//!
//! * An interface is a link (a pseudo-terminal, a UDP peer, ...), named by `if_name`.
//! * A packet is a frame, or a run of bytes outside of frames. The packets of one direction of a
//!   link, joined, are exactly the bytes of that direction.
//! * The direction is in `epb_flags`, as seen from the host: outbound (2) to the arm, inbound (1)
//!   from it.
//! * Times are microseconds since 1970, of the byte that completed the packet.

use std::collections::BTreeMap;
use std::io::{self, Write};

use magician_protocol::{Deframer, Direction, Event, INTER_BYTE_TIMEOUT_MS};

/// Prefix of the name of the arm's own line in the trace of a proxy. Such a trace also contains the
/// lines of the proxy's clients.
pub const LINE_OF_ARM: &str = "arm ";

mod read;

pub use read::{Packet, Trace, TraceError, read_trace};

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const INTERFACE_DESCRIPTION: u32 = 1;
const ENHANCED_PACKET: u32 = 6;
const BYTE_ORDER_MAGIC: u32 = 0x1A2B_3C4D;
/// Link type USER0, reserved for private dissectors in Wireshark.
const LINK_TYPE_USER0: u16 = 147;

const OPTION_END: u16 = 0;
const OPTION_IF_NAME: u16 = 2;
const OPTION_EPB_FLAGS: u16 = 2;
const OPTION_USER_APPLICATION: u16 = 4;
const OPTION_TIME_RESOLUTION: u16 = 9;

const INBOUND: u32 = 1;
const OUTBOUND: u32 = 2;
const DIRECTION_BITS: u32 = 3;

/// True if a file begins like a trace (or any pcapng file).
#[must_use]
pub fn is_trace(bytes: &[u8]) -> bool {
    bytes.starts_with(&SECTION_HEADER.to_be_bytes())
}

/// A link in a [`TraceWriter`]'s file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TraceLink(u32);

/// Writes a trace file.
///
/// Each packet is written in one piece and flushed, so that the file of a killed program can be
/// read up to its last frame.
///
/// ```
/// use magician_protocol::Direction;
/// use magician_record::trace::{TraceWriter, read_trace};
///
/// let mut file = Vec::new();
/// let mut writer = TraceWriter::new(&mut file)?;
/// let link = writer.link("./arm")?;
/// let get_pose = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];
/// writer.record(link, 1_700_000_000_000_000, Direction::Request, &get_pose)?;
/// drop(writer);
///
/// let packet = read_trace(&file).next().unwrap()?;
/// assert_eq!(packet.bytes, get_pose);
/// assert_eq!(packet.link_name, "./arm");
/// assert_eq!(packet.direction, Some(Direction::Request));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TraceWriter<W: Write> {
    out: W,
    links: u32,
    streams: BTreeMap<(TraceLink, bool), Stream>,
    block: Vec<u8>,
}

impl<W: Write> TraceWriter<W> {
    /// Writes the file header.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(out: W) -> io::Result<Self> {
        let mut writer = Self {
            out,
            links: 0,
            streams: BTreeMap::new(),
            block: Vec::new(),
        };
        writer.block(SECTION_HEADER, |block| {
            block.extend(BYTE_ORDER_MAGIC.to_le_bytes());
            block.extend(1u16.to_le_bytes());
            block.extend(0u16.to_le_bytes());
            block.extend(u64::MAX.to_le_bytes()); // section length: unknown
            option(
                block,
                OPTION_USER_APPLICATION,
                concat!("magician ", env!("CARGO_PKG_VERSION")).as_bytes(),
            );
            option(block, OPTION_END, &[]);
        })?;
        Ok(writer)
    }

    /// Adds a link with a name for the user.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn link(&mut self, name: &str) -> io::Result<TraceLink> {
        self.block(INTERFACE_DESCRIPTION, |block| {
            block.extend(LINK_TYPE_USER0.to_le_bytes());
            block.extend([0; 2]);
            block.extend([0; 4]); // no limit on packet length
            option(block, OPTION_IF_NAME, name.as_bytes());
            option(block, OPTION_TIME_RESOLUTION, &[6]);
            option(block, OPTION_END, &[]);
        })?;
        self.links += 1;
        Ok(TraceLink(self.links - 1))
    }

    /// Records bytes of a link with their time, microseconds since 1970. The bytes may be split
    /// anywhere; a packet is written when its frame is complete.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn record(
        &mut self,
        link: TraceLink,
        time: u64,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        let key = (link, direction == Direction::Reply);
        let mut stream = self.streams.remove(&key).unwrap_or_default();
        // Like the controller, give up a partial frame after the inter-byte timeout (E04).
        let gap = time.saturating_sub(stream.time) >= INTER_BYTE_TIMEOUT_MS * 1000;
        let written = if gap {
            self.end(key, &mut stream)
        } else {
            Ok(())
        };
        stream.time = time;
        let written = written.and(stream.push(bytes, |run| self.packet(key, time, run)));
        self.streams.insert(key, stream);
        written
    }

    /// Closes a link and writes its incomplete frames.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn close(&mut self, link: TraceLink) -> io::Result<()> {
        for reply in [false, true] {
            if let Some(mut stream) = self.streams.remove(&(link, reply)) {
                self.end((link, reply), &mut stream)?;
            }
        }
        Ok(())
    }

    fn end(&mut self, key: (TraceLink, bool), stream: &mut Stream) -> io::Result<()> {
        let time = stream.time;
        stream.deframer.expire();
        stream.push(&[], |run| self.packet(key, time, run))
    }

    fn packet(&mut self, key: (TraceLink, bool), time: u64, bytes: &[u8]) -> io::Result<()> {
        let (TraceLink(link), reply) = key;
        let length = bytes.len() as u32;
        self.block(ENHANCED_PACKET, |block| {
            block.extend(link.to_le_bytes());
            block.extend(((time >> 32) as u32).to_le_bytes());
            block.extend((time as u32).to_le_bytes());
            block.extend(length.to_le_bytes());
            block.extend(length.to_le_bytes());
            block.extend(bytes);
            pad(block);
            let flags = if reply { INBOUND } else { OUTBOUND };
            option(block, OPTION_EPB_FLAGS, &flags.to_le_bytes());
            option(block, OPTION_END, &[]);
        })
    }

    /// Writes a block in one piece, so that a killed program leaves no partial block in a buffer.
    fn block(&mut self, kind: u32, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        let block = &mut self.block;
        block.clear();
        block.extend(kind.to_le_bytes());
        block.extend([0; 4]);
        fill(block);
        let length = (block.len() as u32 + 4).to_le_bytes();
        block.extend(length);
        block[4..8].copy_from_slice(&length);
        self.out.write_all(block)?;
        self.out.flush()
    }
}

impl<W: Write> Drop for TraceWriter<W> {
    fn drop(&mut self) {
        for link in 0..self.links {
            // The error cannot be reported any more; all complete frames have been written.
            let _ = self.close(TraceLink(link));
        }
    }
}

fn option(block: &mut Vec<u8>, code: u16, value: &[u8]) {
    // The length field of an option has 16 bits.
    let value = &value[..value.len().min(usize::from(u16::MAX))];
    block.extend(code.to_le_bytes());
    block.extend((value.len() as u16).to_le_bytes());
    block.extend(value);
    pad(block);
}

fn pad(block: &mut Vec<u8>) {
    block.resize(block.len().next_multiple_of(4), 0);
}

/// One direction of a link: the deframer that splits it into packets, and the bytes not yet
/// written.
#[derive(Default)]
struct Stream {
    deframer: Deframer,
    /// Bytes not yet in a packet; the first is at stream position `start`.
    unwritten: Vec<u8>,
    start: u64,
    time: u64,
}

impl Stream {
    fn push(
        &mut self,
        bytes: &[u8],
        mut packet: impl FnMut(&[u8]) -> io::Result<()>,
    ) -> io::Result<()> {
        self.unwritten.extend(bytes);
        // Keep cutting after an error of the writer: the stream must not lose its position.
        let mut written = Ok(());
        let mut cut = |unwritten: &mut Vec<u8>, start: &mut u64, end: u64| {
            let count = (end.saturating_sub(*start) as usize).min(unwritten.len());
            if count > 0 {
                let run = packet(&unwritten[..count]);
                if written.is_ok() {
                    written = run;
                }
                unwritten.drain(..count);
                *start += count as u64;
            }
        };
        let mut input = bytes;
        while let Some(event) = self.deframer.next(&mut input) {
            if let Event::Frame { offset, frame } = event {
                let end = offset + frame.bytes().len() as u64;
                cut(&mut self.unwritten, &mut self.start, offset);
                cut(&mut self.unwritten, &mut self.start, end);
            }
        }
        // Bytes that the deframer has skipped belong to no frame; they become a packet.
        cut(&mut self.unwritten, &mut self.start, self.deframer.offset());
        written
    }
}
