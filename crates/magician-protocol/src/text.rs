//! Texts and raw bytes at the end of a frame.

use core::fmt;

use crate::check::{RangeError, check_count};
use crate::{DecodeError, Field, FieldType, MAX_PARAMS, Range, Reader, Wire, Writer};

/// Text in a frame: at most 247 bytes without its NUL (errata E17).
///
/// Texts from this library are UTF-8; bytes from a controller are kept as received.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Text {
    bytes: [u8; MAX_PARAMS],
    len: u8,
}

impl Text {
    /// Largest text that fits a frame with its NUL, bytes.
    pub const CAPACITY: usize = MAX_PARAMS - 1;

    /// Creates a text. `None` if it is longer than [`Text::CAPACITY`] bytes or contains a NUL.
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let fits = text.len() <= Self::CAPACITY && !text.as_bytes().contains(&0);
        fits.then(|| Self::from_bytes_truncated(text.as_bytes()))
    }

    fn from_bytes_truncated(from: &[u8]) -> Self {
        let mut bytes = [0; MAX_PARAMS];
        let mut len = 0;
        for (to, byte) in bytes.iter_mut().zip(until_nul(from)) {
            *to = *byte;
            len += 1;
        }
        Self { bytes, len }
    }

    /// Bytes without the NUL.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// The text as `str`.
    ///
    /// # Errors
    /// If the controller sent invalid UTF-8.
    pub fn as_str(&self) -> Result<&str, core::str::Utf8Error> {
        core::str::from_utf8(self.as_bytes())
    }

    /// The text as received, with U+FFFD for invalid UTF-8; for programs.
    ///
    /// For people use `Display`, which escapes control characters.
    #[must_use]
    pub fn lossy(&self) -> impl fmt::Display + '_ {
        Lossy(self.as_bytes())
    }

    /// Text cut to at most `max` bytes; may cut inside a character.
    #[must_use]
    pub fn truncated(&self, max: usize) -> Self {
        let bytes = self.as_bytes();
        Self::from_bytes_truncated(bytes.get(..max).unwrap_or(bytes))
    }
}

/// Bytes shown as text, with U+FFFD for invalid UTF-8.
pub(crate) struct Lossy<'a>(pub(crate) &'a [u8]);

impl fmt::Display for Lossy<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for chunk in self.0.utf8_chunks() {
            f.write_str(chunk.valid())?;
            if !chunk.invalid().is_empty() {
                f.write_str("\u{FFFD}")?;
            }
        }
        Ok(())
    }
}

/// Bytes before the first NUL.
pub(crate) fn until_nul(bytes: &[u8]) -> &[u8] {
    match bytes.iter().position(|byte| *byte == 0) {
        Some(end) => bytes.get(..end).unwrap_or_default(),
        None => bytes,
    }
}

impl Wire for Text {
    const TYPE: FieldType = FieldType::Text;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        Ok(Self::from_bytes_truncated(reader.rest()))
    }

    fn write(&self, writer: &mut Writer<'_>) {
        writer.put(self.as_bytes());
        // A text of 248 bytes fills the frame. Only a controller can have sent it, without a NUL,
        // and no NUL fits behind it.
        if usize::from(self.len) < MAX_PARAMS {
            writer.put(&[0]);
        }
    }

    fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
        check_count(self.len.into(), field, range)
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::from_bytes_truncated(&[])
    }
}

/// Formats the text for people: control characters are escaped as by [`visible`](crate::visible).
impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        crate::FieldValue::Text(self.as_bytes()).fmt(f)
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\"", self.as_bytes().escape_ascii())
    }
}

/// Remaining bytes of a frame; may be empty.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Bytes {
    bytes: [u8; MAX_PARAMS],
    len: u8,
}

impl Bytes {
    /// Creates the field. `None` for more bytes than a frame carries.
    #[must_use]
    pub fn new(from: &[u8]) -> Option<Self> {
        let mut bytes = [0; MAX_PARAMS];
        bytes.get_mut(..from.len())?.copy_from_slice(from);
        Some(Self {
            bytes,
            // At most MAX_PARAMS, 248.
            len: from.len() as u8,
        })
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }
}

impl Wire for Bytes {
    const TYPE: FieldType = FieldType::Bytes;
    const OPTIONAL: bool = true;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let found = reader.remaining();
        Self::new(reader.rest()).ok_or(DecodeError::Length {
            expected: MAX_PARAMS,
            found,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) {
        writer.put(self.as_slice());
    }
}

impl Default for Bytes {
    fn default() -> Self {
        Self {
            bytes: [0; MAX_PARAMS],
            len: 0,
        }
    }
}

impl fmt::Debug for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}
