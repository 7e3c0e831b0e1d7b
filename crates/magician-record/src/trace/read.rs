//! Reader of trace files. It accepts foreign pcapng files, and never panics on any bytes.

use std::borrow::Cow;

use magician_protocol::Direction;
use thiserror::Error;

use super::{
    BYTE_ORDER_MAGIC, DIRECTION_BITS, ENHANCED_PACKET, INBOUND, INTERFACE_DESCRIPTION,
    LINK_TYPE_USER0, OPTION_END, OPTION_EPB_FLAGS, OPTION_IF_NAME, OPTION_TIME_RESOLUTION,
    OUTBOUND, SECTION_HEADER,
};

const MICROS_PER_SECOND: u128 = 1_000_000;

/// Bytes of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Microseconds since 1970.
    pub time: u64,
    /// Number of the link in the file.
    pub link: u32,
    /// Name of the link; empty if it has none.
    pub link_name: Cow<'a, str>,
    /// Sender; `None` if the file does not say.
    pub direction: Option<Direction>,
    /// A frame, or a run of bytes outside of frames.
    pub bytes: &'a [u8],
}

/// Error in a trace file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TraceError {
    /// Not a pcapng file.
    #[error("not a trace: the file does not begin with a pcapng section header")]
    NotATrace,
    /// The file ends in the middle of a block, as when its writer was killed.
    #[error("the trace ends inside the block at byte {offset}")]
    Truncated {
        /// Position of the block.
        offset: usize,
    },
    /// A block is inconsistent, so the rest cannot be read.
    #[error("the trace is damaged at byte {offset}")]
    Damaged {
        /// Position of the block.
        offset: usize,
    },
    /// A link of the file has another link type, such as Ethernet. Its packets are left out.
    #[error("link {link} of the trace has link type {link_type}, not that of an arm (USER0, 147)")]
    LinkType {
        /// Number of the link.
        link: u32,
        /// Link type of the capture.
        link_type: u16,
    },
}

/// Reads a trace file: its packets in the order of the file.
///
/// Accepts any pcapng file of link type USER0, in either byte order and any time resolution. No
/// input makes it panic. It continues after [`TraceError::LinkType`] and ends after any other
/// error.
#[must_use]
pub fn read_trace(bytes: &[u8]) -> Trace<'_> {
    Trace {
        file: bytes,
        offset: 0,
        big_endian: false,
        links: Vec::new(),
        first: 0,
    }
}

/// Iterator over the packets of a trace file, made by [`read_trace`].
#[derive(Clone, Debug)]
pub struct Trace<'a> {
    file: &'a [u8],
    /// Position of the next block.
    offset: usize,
    big_endian: bool,
    links: Vec<Link<'a>>,
    /// Index of the first of `links` in the present section.
    first: usize,
}

#[derive(Clone, Debug)]
struct Link<'a> {
    name: Cow<'a, str>,
    /// Ticks per second of its timestamps.
    per_second: u128,
    arm: bool,
}

impl<'a> Iterator for Trace<'a> {
    type Item = Result<Packet<'a>, TraceError>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.offset < self.file.len() {
            match self.block() {
                Ok(None) => {}
                Ok(Some(packet)) => return Some(Ok(packet)),
                Err(error) => {
                    if !matches!(error, TraceError::LinkType { .. }) {
                        self.offset = self.file.len();
                    }
                    return Some(Err(error));
                }
            }
        }
        None
    }
}

impl<'a> Trace<'a> {
    /// Reads one block; returns its packet if it is a packet block.
    fn block(&mut self) -> Result<Option<Packet<'a>>, TraceError> {
        let offset = self.offset;
        let truncated = TraceError::Truncated { offset };
        let damaged = TraceError::Damaged { offset };
        let rest = self.file.get(offset..).unwrap_or_default();
        if offset == 0 && !super::is_trace(rest) {
            return Err(TraceError::NotATrace);
        }
        let mut head = self.fields(rest);
        // The type of a section header is a palindrome, so it reads the same in both byte orders.
        let kind = head.u32().ok_or(truncated)?;
        if kind == SECTION_HEADER {
            let magic = rest.get(8..12).ok_or(truncated)?;
            self.big_endian = magic == BYTE_ORDER_MAGIC.to_be_bytes();
            if !self.big_endian && magic != BYTE_ORDER_MAGIC.to_le_bytes() {
                return Err(damaged);
            }
            head = self.fields(rest);
            head.u32();
        }
        let length = head.u32().ok_or(truncated)? as usize;
        if length < 12 || !length.is_multiple_of(4) {
            return Err(damaged);
        }
        let block = rest.get(..length).ok_or(truncated)?;
        let body = block.get(8..length - 4).ok_or(damaged)?;
        // The length stands at both ends of a block.
        if block.get(4..8) != block.get(length - 4..) {
            return Err(damaged);
        }
        self.offset = offset + length;
        match kind {
            SECTION_HEADER => {
                self.first = self.links.len();
                Ok(None)
            }
            INTERFACE_DESCRIPTION => self.link(body).ok_or(damaged)?.map(|()| None),
            ENHANCED_PACKET => self.packet(body).ok_or(damaged),
            // Name resolution, statistics and other blocks carry no bytes of a line.
            _ => Ok(None),
        }
    }

    /// Reads an interface block. `None` if it is damaged.
    fn link(&mut self, body: &'a [u8]) -> Option<Result<(), TraceError>> {
        let mut fields = self.fields(body);
        let link_type = fields.u16()?;
        fields.take(6)?;
        let mut link = Link {
            name: Cow::Borrowed(""),
            per_second: MICROS_PER_SECOND,
            arm: link_type == LINK_TYPE_USER0,
        };
        while let Some((code, value)) = fields.option()? {
            match (code, value) {
                (OPTION_IF_NAME, name) => link.name = String::from_utf8_lossy(name),
                (OPTION_TIME_RESOLUTION, [resolution, ..]) => {
                    link.per_second = per_second(*resolution)?;
                }
                // Other options do not matter here.
                _ => {}
            }
        }
        let number = self.links.len() as u32;
        let arm = link.arm;
        self.links.push(link);
        Some(if arm {
            Ok(())
        } else {
            Err(TraceError::LinkType {
                link: number,
                link_type,
            })
        })
    }

    /// Reads a packet block. `None` if it is damaged; `Some(None)` for a packet of another link
    /// type.
    fn packet(&self, body: &'a [u8]) -> Option<Option<Packet<'a>>> {
        let mut fields = self.fields(body);
        let number = self.first.checked_add(fields.u32()? as usize)?;
        let link = self.links.get(number)?;
        let ticks = u128::from(fields.u32()?) << 32 | u128::from(fields.u32()?);
        let length = fields.u32()? as usize;
        fields.u32()?;
        let bytes = fields.padded(length)?;
        let mut flags = 0;
        while let Some((code, value)) = fields.option()? {
            if code == OPTION_EPB_FLAGS {
                flags = self.fields(value).u32()?;
            }
        }
        let time = ticks * MICROS_PER_SECOND / link.per_second;
        Some(link.arm.then(|| Packet {
            time: u64::try_from(time).unwrap_or(u64::MAX),
            link: number as u32,
            link_name: link.name.clone(),
            direction: match flags & DIRECTION_BITS {
                INBOUND => Some(Direction::Reply),
                OUTBOUND => Some(Direction::Request),
                _ => None,
            },
            bytes,
        }))
    }

    fn fields(&self, bytes: &'a [u8]) -> Fields<'a> {
        Fields {
            bytes,
            big_endian: self.big_endian,
        }
    }
}

/// Ticks per second from `if_tsresol`: a negative power of 10, or of 2 if the top bit is set.
/// `None` if it is too fine for the arithmetic, which no clock is.
fn per_second(resolution: u8) -> Option<u128> {
    let exponent = u32::from(resolution & 0x7F);
    let base: u128 = if resolution & 0x80 == 0 { 10 } else { 2 };
    base.checked_pow(exponent)
}

/// Reads fields from the front of a block; `None` at its end.
struct Fields<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    fn padded(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.take(count.checked_next_multiple_of(4)?)?;
        taken.get(..count)
    }

    fn u16(&mut self) -> Option<u16> {
        let bytes = self.take(2)?.try_into().ok()?;
        Some(if self.big_endian {
            u16::from_be_bytes(bytes)
        } else {
            u16::from_le_bytes(bytes)
        })
    }

    fn u32(&mut self) -> Option<u32> {
        let bytes = self.take(4)?.try_into().ok()?;
        Some(if self.big_endian {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    /// Reads an option; `Some(None)` after the last.
    fn option(&mut self) -> Option<Option<(u16, &'a [u8])>> {
        if self.bytes.is_empty() {
            return Some(None);
        }
        let code = self.u16()?;
        let length = self.u16()?;
        let value = self.padded(usize::from(length))?;
        Some((code != OPTION_END).then_some((code, value)))
    }
}
