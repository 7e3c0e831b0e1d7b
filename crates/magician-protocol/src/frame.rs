//! Frames: constants, the control byte, the checksum, borrowed ([`Frame`]) and owned ([`FrameBuf`])
//! bytes.

use core::fmt;

use crate::{DecodeError, EncodeError, Layout, Row, Set, Writer};

/// First two bytes of every frame.
pub const HEADER: [u8; 2] = [0xAA, 0xAA];
/// Largest Len byte: id, Ctrl and parameters together (errata E03).
pub(crate) const MAX_LEN: usize = 250;
/// Largest number of parameter bytes in a frame.
pub const MAX_PARAMS: usize = MAX_LEN - 2;
/// Largest frame including header and checksum, bytes.
pub const MAX_FRAME: usize = MAX_LEN + 4;
/// Baud rate of the USB and TTL ports, 8N1 (document 1.1).
pub const BAUD_RATE: u32 = 115_200;
/// UDP port of the Wi-Fi module (errata E45).
pub const UDP_PORT: u16 = 8899;
/// Silence inside a frame after which the incomplete frame is dropped, ms (errata E04).
pub const INTER_BYTE_TIMEOUT_MS: u64 = 50;

/// Checksum over a frame's id, Ctrl and parameters: the two's complement of their sum (document
/// 1.2.2).
///
/// Len is not part of the sum (errata E02).
///
/// ```
/// assert_eq!(magician_protocol::checksum(&[0x0A, 0x00]), 0xF6);
/// ```
#[must_use]
#[inline]
pub fn checksum(body: &[u8]) -> u8 {
    body.iter()
        .fold(0u8, |sum, byte| sum.wrapping_add(*byte))
        .wrapping_neg()
}

/// Control byte of a frame (document 1.2.1, bits 2 to 7 errata E05).
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Ctrl(pub u8);

impl Ctrl {
    /// Ctrl of a get: rw 0, not queued.
    pub const GET: Self = Self(0);
    /// Ctrl of an immediate set: rw 1, not queued.
    pub const SET: Self = Self(1);
    /// Ctrl of a queued set: rw 1, queued.
    pub const QUEUED: Self = Self(3);

    /// Bit 0: true for a set, false for a get.
    #[must_use]
    pub const fn write(self) -> bool {
        self.0 & 1 != 0
    }

    /// Bit 1: true if the command goes into the queue.
    #[must_use]
    pub const fn queued(self) -> bool {
        self.0 & 2 != 0
    }

    /// Bit 2: true if the controller refused the command (errata E05, never seen in a capture).
    #[must_use]
    pub const fn error(self) -> bool {
        self.0 & 4 != 0
    }

    /// Same byte with bit 2 set.
    #[must_use]
    pub const fn with_error(self) -> Self {
        Self(self.0 | 4)
    }

    /// Bits 4 and 5: 0 for the arm, 1 for the extension controller.
    #[must_use]
    pub const fn destination(self) -> u8 {
        (self.0 >> 4) & 3
    }

    /// Bits 6 and 7: index of a slave controller.
    #[must_use]
    pub const fn slave(self) -> u8 {
        self.0 >> 6
    }
}

impl fmt::Debug for Ctrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Ctrl({:#04x})", self.0)
    }
}

/// A frame, borrowed; header, length and checksum have been checked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    bytes: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Creates a frame from the bytes of exactly one frame. `None` if bytes are missing, surplus or
    /// damaged.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let [0xAA, 0xAA, len, body @ .., sum] = bytes else {
            return None;
        };
        // Two bytes at least, id and Ctrl.
        let whole = usize::from(*len) == body.len() && (2..=MAX_LEN).contains(&body.len());
        (whole && checksum(body) == *sum).then_some(Self { bytes })
    }

    /// Creates a frame from bytes that the deframer has checked.
    pub(crate) fn trusted(bytes: &'a [u8]) -> Self {
        // Only in debug builds, so that no frame is summed twice.
        debug_assert!(Self::new(bytes).is_some());
        Self { bytes }
    }

    /// All bytes, header to checksum.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Command id.
    #[must_use]
    pub fn id(&self) -> u8 {
        self.bytes.get(3).copied().unwrap_or_default()
    }

    /// Control byte.
    #[must_use]
    pub fn ctrl(&self) -> Ctrl {
        Ctrl(self.bytes.get(4).copied().unwrap_or_default())
    }

    /// Parameters; may be empty.
    #[must_use]
    pub fn params(&self) -> &'a [u8] {
        let end = self.bytes.len().saturating_sub(1);
        self.bytes.get(5..end).unwrap_or_default()
    }
}

impl fmt::Debug for Frame<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Frame(")?;
        for byte in self.bytes {
            write!(f, "{byte:02X}")?;
        }
        f.write_str(")")
    }
}

/// Number of commands that this process has encoded by [`FrameBuf::set`].
#[cfg(feature = "counters")]
#[doc(hidden)]
pub static ENCODED: core::sync::atomic::AtomicUsize = core::sync::atomic::AtomicUsize::new(0);

/// A frame that owns its bytes, without allocation.
#[derive(Clone, Copy)]
pub struct FrameBuf {
    bytes: [u8; MAX_FRAME],
    len: u8,
}

impl FrameBuf {
    /// Creates a frame from id, Ctrl and parameter bytes.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] for more than 248 parameter bytes.
    pub fn new(id: u8, ctrl: Ctrl, params: &[u8]) -> Result<Self, EncodeError> {
        Self::with(id, ctrl, |writer| writer.put(params))
    }

    /// Creates a frame with the parameters of a layout.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] if a list or text does not fit a frame.
    #[inline]
    pub fn encode<L: Layout>(id: u8, ctrl: Ctrl, layout: &L) -> Result<Self, EncodeError> {
        Self::with(id, ctrl, |writer| layout.encode(writer))
    }

    /// Creates the get request of a row.
    ///
    /// # Errors
    /// Same as [`FrameBuf::encode`].
    #[inline]
    pub fn get<Q: Layout>(query: &Q, row: &Row) -> Result<Self, EncodeError> {
        Self::encode(row.id, Ctrl::GET, query)
    }

    /// Creates the frame of a set or an action; `ctrl` selects immediate or queued.
    ///
    /// # Errors
    /// Same as [`FrameBuf::encode`].
    #[inline]
    pub fn set(set: &Set, ctrl: Ctrl) -> Result<Self, EncodeError> {
        #[cfg(feature = "counters")]
        ENCODED.fetch_add(1, core::sync::atomic::Ordering::Relaxed);
        Self::with(set.row().id, ctrl, |writer| set.encode(writer))
    }

    fn with(id: u8, ctrl: Ctrl, fill: impl FnOnce(&mut Writer<'_>)) -> Result<Self, EncodeError> {
        let mut frame = Self {
            bytes: [0; MAX_FRAME],
            len: 0,
        };
        let bytes = &mut frame.bytes;
        // Parameters first, because Len and checksum depend on them.
        let mut writer = Writer::new(&mut bytes[5..5 + MAX_PARAMS]);
        fill(&mut writer);
        let count = writer.finish()?;
        bytes[..5].copy_from_slice(&[HEADER[0], HEADER[1], (count + 2) as u8, id, ctrl.0]);
        bytes[count + 5] = checksum(&bytes[3..count + 5]);
        // At most 254.
        frame.len = (count + 6) as u8;
        Ok(frame)
    }

    /// All bytes, header to checksum.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }

    /// Borrows the frame.
    #[must_use]
    pub fn frame(&self) -> Frame<'_> {
        Frame::trusted(self.bytes())
    }
}

impl From<Frame<'_>> for FrameBuf {
    fn from(frame: Frame<'_>) -> Self {
        let mut bytes = [0; MAX_FRAME];
        let len = frame.bytes().len();
        bytes[..len].copy_from_slice(frame.bytes());
        Self {
            bytes,
            len: len as u8,
        }
    }
}

impl PartialEq for FrameBuf {
    fn eq(&self, other: &Self) -> bool {
        self.bytes() == other.bytes()
    }
}

impl Eq for FrameBuf {}

impl fmt::Debug for FrameBuf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.frame().fmt(f)
    }
}

impl Frame<'_> {
    /// Decodes the parameters as `L`. The id is not checked: the caller knows the command.
    ///
    /// # Errors
    /// [`DecodeError`] if the parameter count fits no accepted form.
    pub fn read<L: Layout>(&self) -> Result<L, DecodeError> {
        L::decode(self.params())
    }
}
