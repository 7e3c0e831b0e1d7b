//! Reading and writing of parameters: cursors, the types of fields, and the traits of layouts.

use crate::check::{Number, RangeError, check_number};
use crate::layout::{Field, LayoutInfo};
use crate::{DecodeError, EncodeError, Range, Row};

/// Cursor that reads parameters front to back.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Starts at the first byte.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// True if no bytes are left.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Number of bytes left.
    #[must_use]
    pub const fn remaining(&self) -> usize {
        self.rest.len()
    }

    /// Reads the next `N` bytes.
    ///
    /// # Errors
    /// [`DecodeError::Length`] if fewer are left.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let Some((head, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(DecodeError::Length {
                expected: N,
                found: self.rest.len(),
            });
        };
        self.rest = rest;
        Ok(*head)
    }

    /// Reads the next `count` bytes. `None` if fewer are left.
    pub fn slice(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(head)
    }

    /// Reads all bytes left.
    pub fn rest(&mut self) -> &'a [u8] {
        core::mem::take(&mut self.rest)
    }
}

/// Cursor that writes parameters front to back. An overflow is reported by
/// [`finish`](Self::finish), never by a panic.
#[derive(Debug)]
pub struct Writer<'a> {
    bytes: &'a mut [u8],
    count: usize,
}

impl<'a> Writer<'a> {
    /// Starts at the first byte of `bytes`.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, count: 0 }
    }

    /// Appends bytes.
    #[inline]
    pub fn put(&mut self, more: &[u8]) {
        if let Some(room) = self
            .bytes
            .get_mut(self.count..self.count.saturating_add(more.len()))
        {
            room.copy_from_slice(more);
        }
        // Counts beyond the end too, so that `finish` can say how much was needed.
        self.count = self.count.saturating_add(more.len());
    }

    /// Number of bytes written.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] if they did not fit.
    pub fn finish(self) -> Result<usize, EncodeError> {
        if self.count > self.bytes.len() {
            return Err(EncodeError::TooLong { needed: self.count });
        }
        Ok(self.count)
    }
}

/// Numeric type on the wire, always little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Scalar {
    /// Single byte, unsigned.
    U8,
    /// Two bytes, unsigned.
    U16,
    /// Four bytes, unsigned.
    U32,
    /// Eight bytes, unsigned.
    U64,
    /// Four bytes, two's complement.
    I32,
    /// Four bytes, IEEE 754 binary32.
    F32,
}

impl Scalar {
    /// Size, bytes.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 => 8,
        }
    }
}

/// A named value of an open enum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Value on the wire.
    pub value: u8,
    /// Name, as the Rust variant.
    pub name: &'static str,
    /// Meaning, as a sentence.
    pub doc: &'static str,
}

/// Description of an open enum: names for some values of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnumInfo {
    /// Name of the Rust type.
    pub name: &'static str,
    /// Named values.
    pub variants: &'static [Variant],
}

/// Type of a field on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum FieldType {
    /// A single number.
    Scalar(Scalar),
    /// A fixed-size array of numbers.
    Array(Scalar, usize),
    /// A byte where 0 is off and anything else is on.
    Flag,
    /// A byte with named values.
    Enum(&'static EnumInfo),
    /// The rest of the frame as text, terminated by NUL (errata E17).
    Text,
    /// The rest of the frame as bytes.
    Bytes,
    /// The rest of the frame as alarm bits, 1 to 32 bytes (errata E20).
    Alarms,
    /// The rest of the frame as a list of outputs (errata E29).
    Outputs,
}

impl FieldType {
    /// Size, bytes. `None` if the field takes the rest of the frame.
    #[must_use]
    pub const fn size(self) -> Option<usize> {
        match self {
            Self::Scalar(scalar) => Some(scalar.size()),
            Self::Array(scalar, count) => Some(scalar.size() * count),
            Self::Flag | Self::Enum(_) => Some(1),
            Self::Text | Self::Bytes | Self::Alarms | Self::Outputs => None,
        }
    }
}

/// A type that can be a field of a layout.
pub trait Wire: Sized {
    /// Type on the wire.
    const TYPE: FieldType;
    /// True if the field may be left out at the end of a layout.
    const OPTIONAL: bool = false;

    /// Reads a value.
    ///
    /// # Errors
    /// [`DecodeError`] if too few bytes are left or they are malformed.
    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError>;

    /// Writes the value.
    fn write(&self, writer: &mut Writer<'_>);

    /// Checks the value against the range of its field. The default accepts everything.
    ///
    /// # Errors
    /// [`RangeError`] if it is out of range or not a finite number.
    fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
        let _ = (field, range);
        Ok(())
    }
}

macro_rules! scalar {
    ($number:ident as $as:ident: $($type:ident $scalar:ident),*) => {$(
        impl Wire for $type {
            const TYPE: FieldType = FieldType::Scalar(Scalar::$scalar);

            #[inline]
            fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
                Ok($type::from_le_bytes(reader.array()?))
            }

            #[inline]
            fn write(&self, writer: &mut Writer<'_>) {
                writer.put(&self.to_le_bytes());
            }

            #[inline]
            fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
                check_number(Number::$number(*self as $as), field, range)
            }
        }
    )*};
}

scalar!(Integer as i64: u8 U8, u16 U16, u32 U32, u64 U64, i32 I32);
scalar!(Float as f32: f32 F32);

impl<T: Wire + Copy + Default, const N: usize> Wire for [T; N] {
    const TYPE: FieldType = match T::TYPE {
        FieldType::Scalar(scalar) => FieldType::Array(scalar, N),
        // Evaluated at compile time: such a layout does not build.
        _ => panic!("arrays hold numbers"),
    };

    #[inline]
    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        let mut items = [T::default(); N];
        for item in &mut items {
            *item = T::read(reader)?;
        }
        Ok(items)
    }

    #[inline]
    fn write(&self, writer: &mut Writer<'_>) {
        for item in self {
            item.write(writer);
        }
    }

    #[inline]
    fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
        self.iter().enumerate().try_for_each(|(at, item)| {
            let checked = item.check(field, range);
            checked.map_err(|error| error.with_item(at))
        })
    }
}

impl<T: Wire> Wire for Option<T> {
    const TYPE: FieldType = T::TYPE;
    const OPTIONAL: bool = true;

    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError> {
        if reader.is_empty() {
            return Ok(None);
        }
        T::read(reader).map(Some)
    }

    fn write(&self, writer: &mut Writer<'_>) {
        if let Some(value) = self {
            value.write(writer);
        }
    }

    fn check(&self, field: &'static Field, range: Range) -> Result<(), RangeError> {
        match self {
            Some(value) => value.check(field, range),
            None => Ok(()),
        }
    }
}

/// Parameters of one form of a command, as a typed value.
pub trait Layout: Sized {
    /// Description of the fields, for programs that discover them at run time.
    const INFO: &'static LayoutInfo;

    /// Decodes the parameters of a frame: the exact form and the tolerated ones in
    /// [`LayoutInfo::forms`]. Surplus bytes are ignored (errata E11).
    ///
    /// # Errors
    /// [`DecodeError`] if the parameter count fits no accepted form.
    fn decode(params: &[u8]) -> Result<Self, DecodeError>;

    /// Encodes the parameters in their exact form.
    fn encode(&self, writer: &mut Writer<'_>);

    /// Checks all fields against their ranges.
    ///
    /// Two things are not checked: flags, which are on for any byte but 0, and rail positions
    /// ([`Range::Absolute`]), whose range depends on more than the command.
    ///
    /// # Errors
    /// [`RangeError`] for the first field out of range.
    #[inline]
    fn check(&self) -> Result<(), RangeError> {
        self.check_fields(|_| true)
    }

    /// Checks the fields selected by `wanted`.
    ///
    /// # Errors
    /// Same as [`check`](Self::check).
    fn check_fields(&self, wanted: impl Fn(&Field) -> bool) -> Result<(), RangeError> {
        let _ = wanted;
        Ok(())
    }
}

/// A value with a get.
pub trait Readable: Layout {
    /// Parameters of the request; [`NoArgs`] for most values.
    type Query: Layout;
    /// Row of the command.
    const ROW: &'static Row;
}

/// A value or action with a set.
pub trait Writable: Layout {
    /// Row of the command.
    const ROW: &'static Row;
}

/// A [`Writable`] that may be queued.
pub trait Queueable: Writable {}

/// The layout without fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoArgs;

impl Layout for NoArgs {
    const INFO: &'static LayoutInfo = &LayoutInfo {
        name: "NoArgs",
        fields: &[],
        forms: &[],
    };

    fn decode(_: &[u8]) -> Result<Self, DecodeError> {
        Ok(Self)
    }

    fn encode(&self, _: &mut Writer<'_>) {}
}
