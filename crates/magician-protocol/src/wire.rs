use crate::check::{Number, RangeError, check_number};
use crate::layout::{Field, LayoutInfo};
use crate::{DecodeError, EncodeError, Range, Row};

/// Reads parameters front to back.
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

    /// Whether nothing is left.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Bytes left.
    #[must_use]
    pub const fn remaining(&self) -> usize {
        self.rest.len()
    }

    /// The next `N` bytes.
    ///
    /// # Errors
    /// [`DecodeError::Length`] when fewer are left.
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

    /// The next `count` bytes, or `None` when fewer are left.
    pub fn slice(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(head)
    }

    /// Everything that is left.
    pub fn rest(&mut self) -> &'a [u8] {
        core::mem::take(&mut self.rest)
    }
}

/// Writes parameters front to back; remembers an overflow instead of panicking.
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
        self.count = self.count.saturating_add(more.len());
    }

    /// How many bytes were written.
    ///
    /// # Errors
    /// [`EncodeError::TooLong`] when they did not fit.
    pub fn finish(self) -> Result<usize, EncodeError> {
        if self.count > self.bytes.len() {
            return Err(EncodeError::TooLong { needed: self.count });
        }
        Ok(self.count)
    }
}

/// A number on the wire, always little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Scalar {
    /// One byte, unsigned.
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
    /// Bytes it takes.
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
    /// Number on the wire.
    pub value: u8,
    /// Name in Rust case.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
}

/// An open enum: names for some of the values of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnumInfo {
    /// Name of the Rust type.
    pub name: &'static str,
    /// The values that have a name.
    pub variants: &'static [Variant],
}

/// How a field lies on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum FieldType {
    /// One number.
    Scalar(Scalar),
    /// A fixed number of numbers.
    Array(Scalar, usize),
    /// A byte of which 0 is off and anything else is on.
    Flag,
    /// A byte with named values.
    Enum(&'static EnumInfo),
    /// The rest of the frame as text, ended by a NUL (errata E17).
    Text,
    /// The rest of the frame as bytes.
    Bytes,
    /// The rest of the frame as alarm bits, 1 to 32 bytes (errata E20).
    Alarms,
    /// The rest of the frame as a list of outputs (errata E29).
    Outputs,
}

impl FieldType {
    /// Bytes it takes, `None` for what takes the rest of the frame.
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

/// A type that can stand as a field of a layout.
pub trait Wire: Sized {
    /// How it lies on the wire.
    const TYPE: FieldType;
    /// Whether the field may be left out at the end of a layout.
    const OPTIONAL: bool = false;

    /// Reads it.
    ///
    /// # Errors
    /// [`DecodeError`] when the bytes do not suffice.
    fn read(reader: &mut Reader<'_>) -> Result<Self, DecodeError>;

    /// Writes it.
    fn write(&self, writer: &mut Writer<'_>);

    /// Checks it against the range that applies to its field.
    ///
    /// # Errors
    /// [`RangeError`] when it is out of the range, or not a finite number.
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
            checked.map_err(|error| error.at(at))
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

/// The parameters of one form of a command, as a value.
pub trait Layout: Sized {
    /// The layout's fields, for programs that learn of them at run time.
    const INFO: &'static LayoutInfo;

    /// Reads the parameters of a frame: the exact form, and the tolerated ones that
    /// [`LayoutInfo::forms`] names. Surplus bytes are ignored (errata E11).
    ///
    /// # Errors
    /// [`DecodeError`] when the parameter count fits no accepted form.
    fn decode(params: &[u8]) -> Result<Self, DecodeError>;

    /// Writes the parameters in their exact form.
    fn encode(&self, writer: &mut Writer<'_>);

    /// Checks the fields against their ranges. A flag is on for any byte but 0, and where a rail
    /// may be ([`Range::Absolute`]) depends on more than the command: these two are not checked.
    ///
    /// # Errors
    /// [`RangeError`] for the first field that is out of its range.
    #[inline]
    fn check(&self) -> Result<(), RangeError> {
        self.check_fields(|_| true)
    }

    /// Checks those fields that `wanted` picks.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    fn check_fields(&self, wanted: impl Fn(&Field) -> bool) -> Result<(), RangeError> {
        let _ = wanted;
        Ok(())
    }
}

/// A value the controller can be asked for.
pub trait Readable: Layout {
    /// What the request carries; [`NoArgs`] for most.
    type Query: Layout;
    /// The command's row.
    const ROW: &'static Row;
}

/// A value that can be set, or an action that can be ordered.
pub trait Writable: Layout {
    /// The command's row.
    const ROW: &'static Row;
}

/// A [`Writable`] that may go through the controller's queue.
pub trait Queueable: Writable {}

/// The empty layout.
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
