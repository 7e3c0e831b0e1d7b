use core::fmt;

use crate::{DecodeError, EncodeError, Layout, Row, Set, Writer};

/// The two bytes every frame starts with.
pub const HEADER: [u8; 2] = [0xAA, 0xAA];
/// Largest Len byte: id, Ctrl and parameters (errata E03).
pub(crate) const MAX_LEN: usize = 250;
/// Most parameter bytes in a frame.
pub const MAX_PARAMS: usize = MAX_LEN - 2;
/// Most bytes in a frame, header and checksum included.
pub const MAX_FRAME: usize = MAX_LEN + 4;
/// Serial speed of the USB and TTL ports, 8N1 (document 1.1).
pub const BAUD_RATE: u32 = 115_200;
/// UDP port of the Wi-Fi module (errata E45).
pub const UDP_PORT: u16 = 8899;
/// Silence inside a frame after which its start is given up, in ms (errata E04).
pub const INTER_BYTE_TIMEOUT_MS: u64 = 50;

/// The checksum of a frame's id, Ctrl and parameters: the two's complement of their sum
/// (document 1.2.2; Len is not summed, errata E02).
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

/// The control byte of a frame (document 1.2.1, bits 2 to 7 errata E05).
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Ctrl(pub u8);

impl Ctrl {
    /// A get: rw 0, not queued.
    pub const GET: Self = Self(0);
    /// An immediate set: rw 1, not queued.
    pub const SET: Self = Self(1);
    /// A queued set: rw 1, queued.
    pub const QUEUED: Self = Self(3);

    /// Bit 0: set (1) or get (0).
    #[must_use]
    pub const fn write(self) -> bool {
        self.0 & 1 != 0
    }

    /// Bit 1: to be queued.
    #[must_use]
    pub const fn queued(self) -> bool {
        self.0 & 2 != 0
    }

    /// Bit 2: the controller refused the command (errata E05, never seen in a capture).
    #[must_use]
    pub const fn error(self) -> bool {
        self.0 & 4 != 0
    }

    /// The same with bit 2 set.
    #[must_use]
    pub const fn with_error(self) -> Self {
        Self(self.0 | 4)
    }

    /// Bits 4 and 5: 0 the arm, 1 the extension controller.
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

/// The bytes of one frame whose header, length and checksum have been checked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    bytes: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Takes a frame that fills `bytes` exactly; `None` if it does not or is damaged.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let [0xAA, 0xAA, len, body @ .., sum] = bytes else {
            return None;
        };
        let whole = usize::from(*len) == body.len() && (2..=MAX_LEN).contains(&body.len());
        (whole && checksum(body) == *sum).then_some(Self { bytes })
    }

    /// For the deframer, which has done the checks.
    pub(crate) fn trusted(bytes: &'a [u8]) -> Self {
        debug_assert!(Self::new(bytes).is_some());
        Self { bytes }
    }

    /// All bytes, header to checksum.
    #[must_use]
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Id of the command.
    #[must_use]
    pub fn id(&self) -> u8 {
        self.bytes.get(3).copied().unwrap_or_default()
    }

    /// The control byte.
    #[must_use]
    pub fn ctrl(&self) -> Ctrl {
        Ctrl(self.bytes.get(4).copied().unwrap_or_default())
    }

    /// The parameters, possibly none.
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

/// Commands that this process has encoded by [`FrameBuf::set`].
#[cfg(feature = "counters")]
#[doc(hidden)]
pub static ENCODED: core::sync::atomic::AtomicUsize = core::sync::atomic::AtomicUsize::new(0);

/// A frame that owns its bytes, on the stack.
#[derive(Clone, Copy)]
pub struct FrameBuf {
    bytes: [u8; MAX_FRAME],
    len: u8,
}

impl FrameBuf {
    /// A frame with these parameters.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] beyond 248 parameter bytes.
    pub fn new(id: u8, ctrl: Ctrl, params: &[u8]) -> Result<Self, EncodeError> {
        Self::with(id, ctrl, |writer| writer.put(params))
    }

    /// A frame with the parameters of a layout.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] when a list or text is too long for a frame.
    #[inline]
    pub fn encode<L: Layout>(id: u8, ctrl: Ctrl, layout: &L) -> Result<Self, EncodeError> {
        Self::with(id, ctrl, |writer| layout.encode(writer))
    }

    /// The get request of a row.
    ///
    /// # Errors
    /// As [`FrameBuf::encode`].
    #[inline]
    pub fn get<Q: Layout>(query: &Q, row: &Row) -> Result<Self, EncodeError> {
        Self::encode(row.id, Ctrl::GET, query)
    }

    /// The frame that sets a value or orders an action: at once or queued, as `ctrl` says.
    ///
    /// # Errors
    /// As [`FrameBuf::encode`].
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
        let mut writer = Writer::new(&mut bytes[5..5 + MAX_PARAMS]);
        fill(&mut writer);
        let count = writer.finish()?;
        bytes[..5].copy_from_slice(&[HEADER[0], HEADER[1], (count + 2) as u8, id, ctrl.0]);
        bytes[count + 5] = checksum(&bytes[3..count + 5]);
        frame.len = (count + 6) as u8;
        Ok(frame)
    }

    /// All bytes, header to checksum.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }

    /// The frame as a view.
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
    /// Reads the parameters as `L`; whether the frame is that command is for the caller to know.
    ///
    /// # Errors
    /// [`DecodeError`] when the parameter count fits no accepted form.
    pub fn read<L: Layout>(&self) -> Result<L, DecodeError> {
        L::decode(self.params())
    }
}
