//! Layouts as data: the fields of a form with type, unit and range, tolerated parameter counts, and
//! values read through that description.
//!
//! The typed structs decode through the same description, so programs that learn of a command at
//! run time (command line, JSON, traces) and typed programs accept the same frames.

use core::fmt;

use crate::alarm::AlarmSet;
use crate::list::PoList;
use crate::range::Range;
use crate::text::{Lossy, until_nul};
use crate::visible::visible;
use crate::wire::{EnumInfo, FieldType, Reader, Scalar, Wire};
use crate::{DecodeError, Writer};

/// A field of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Field {
    /// Name, as in JSON and on the command line.
    pub name: &'static str,
    /// Type on the wire.
    pub ty: FieldType,
    /// Unit, or a word for a value without one (`flag`, `enum`).
    pub unit: &'static str,
    /// Accepted values.
    pub range: Range,
    /// Meaning, as a sentence.
    pub doc: &'static str,
    /// True if a host may leave the field out.
    pub optional: bool,
    /// True if a controller accepts a frame that ends before this field. A sender leaves out all
    /// such fields of a layout or none.
    pub omittable: bool,
    /// Value that a host sends in place of a field left out. `None` if it sends nothing.
    pub default: Option<u8>,
}

/// A tolerated form: a parameter count other than the layout's own, accepted from the hosts that
/// send it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Form {
    /// Number of parameter bytes.
    pub len: usize,
    /// Mapping of the bytes to the layout.
    pub kind: FormKind,
    /// Senders of this form, with the errata number.
    pub note: &'static str,
}

/// Mapping of a tolerated form to its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum FormKind {
    /// Missing bytes at the end are zero.
    Zeros,
    /// The layout begins after this many bytes.
    Skip(usize),
    /// Each field is a single byte.
    Bytes,
}

/// Description of one form of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LayoutInfo {
    /// Name of the Rust type.
    pub name: &'static str,
    /// Fields in wire order.
    pub fields: &'static [Field],
    /// Tolerated forms.
    pub forms: &'static [Form],
}

/// Result of matching a parameter count with a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Normalised {
    /// Mapping; [`FormKind::Skip`]`(0)` for the layout's own form.
    pub kind: FormKind,
    /// Deviation from the strict form, with its errata. `None` if exact.
    pub note: Option<&'static str>,
}

const SURPLUS_NOTE: &str = "surplus parameter bytes ignored (E11)";
const OMITTED_NOTE: &str = "address or port omitted (E39, E43)";
/// Size of a buffer for the layouts with tolerated forms, rounded up from the longest.
const FORM_BUFFER_SIZE: usize = 32;

impl LayoutInfo {
    /// Parameter bytes of the exact form. `None` if the last field takes the rest of the frame.
    #[must_use]
    pub const fn size(&self) -> Option<usize> {
        let (mut at, mut sum) = (0, 0);
        while at < self.fields.len() {
            match self.fields[at].ty.size() {
                Some(size) => sum += size,
                None => return None,
            }
            at += 1;
        }
        Some(sum)
    }

    /// Fewest parameter bytes of the layout's own form.
    #[must_use]
    pub const fn min_size(&self) -> usize {
        let (mut at, mut sum) = (0, 0);
        while at < self.fields.len() && !self.fields[at].omittable {
            sum += match self.fields[at].ty.size() {
                Some(size) => size,
                None => 0,
            };
            at += 1;
        }
        sum
    }

    /// Finds the form with this many parameter bytes.
    ///
    /// # Errors
    /// [`DecodeError::Length`] if there is no such form.
    pub fn normalise(&self, count: usize) -> Result<Normalised, DecodeError> {
        // Tolerated forms come first: a count that known hosts send is a form of its own, and not a
        // frame with surplus bytes.
        if let Some(form) = self.forms.iter().find(|form| form.len == count) {
            return Ok(Normalised {
                kind: form.kind,
                note: Some(form.note),
            });
        }
        let (shortest, full) = (self.min_size(), self.size());
        let note = match full {
            None if count >= shortest => None,
            Some(full) if count == full => None,
            Some(full) if count > full => Some(SURPLUS_NOTE),
            Some(_) if count == shortest => self.omission(),
            _ => {
                // Too short: the next larger size is expected.
                return Err(DecodeError::Length {
                    expected: full.filter(|_| count > shortest).unwrap_or(shortest),
                    found: count,
                });
            }
        };
        Ok(Normalised {
            kind: FormKind::Skip(0),
            note,
        })
    }

    /// Note for a frame that ends before its omittable fields. `None` if a host may leave them out.
    fn omission(&self) -> Option<&'static str> {
        self.fields
            .iter()
            .any(|field| field.omittable && !field.optional)
            .then_some(OMITTED_NOTE)
    }

    /// Converts a tolerated form into the layout's own and passes it to `read`.
    pub(crate) fn read_form<T>(
        &self,
        params: &[u8],
        read: impl FnOnce(&mut Reader<'_>) -> Result<T, DecodeError>,
    ) -> Result<T, DecodeError> {
        match self.normalise(params.len())?.kind {
            FormKind::Skip(count) => read(&mut Reader::new(params.get(count..).unwrap_or(&[]))),
            FormKind::Zeros => {
                let mut bytes = [0; FORM_BUFFER_SIZE];
                for (to, from) in bytes.iter_mut().zip(params) {
                    *to = *from;
                }
                read(&mut Reader::new(&bytes[..self.form_size()]))
            }
            FormKind::Bytes => {
                let mut bytes = [0; FORM_BUFFER_SIZE];
                let mut at = 0;
                for (field, from) in self.fields.iter().zip(params) {
                    if let Some(to) = bytes.get_mut(at) {
                        *to = *from;
                    }
                    at += field.ty.size().unwrap_or(0);
                }
                read(&mut Reader::new(&bytes[..self.form_size()]))
            }
        }
    }

    fn form_size(&self) -> usize {
        self.size().unwrap_or(0).min(FORM_BUFFER_SIZE)
    }

    /// Fields present in the parameters, with their values. Fields that a short form leaves out are
    /// skipped.
    ///
    /// # Errors
    /// Same as [`normalise`](Self::normalise), and [`DecodeError::List`] for a list of outputs
    /// whose length is neither a multiple of 4 nor one more, with the count in front (errata E29).
    pub fn values<'a>(&self, params: &'a [u8]) -> Result<Fields<'a>, DecodeError> {
        let normalised = self.normalise(params.len())?;
        let (skip, as_bytes) = match normalised.kind {
            FormKind::Skip(count) => (count, false),
            FormKind::Zeros => (0, false),
            FormKind::Bytes => (0, true),
        };
        let mut reader = Reader::new(params.get(skip..).unwrap_or(&[]));
        // `Fields` cannot fail half way, so the types that may be malformed are tried here.
        if let Some((last, head)) = self.fields.split_last()
            && matches!(last.ty, FieldType::Outputs | FieldType::Alarms)
        {
            let mut probe = reader.clone();
            let _ = probe.slice(head.iter().filter_map(|field| field.ty.size()).sum());
            match last.ty {
                FieldType::Outputs => drop(PoList::read(&mut probe)?),
                // `Alarms`, the other type of the condition.
                _ => drop(AlarmSet::read(&mut probe)?),
            }
        }
        if as_bytes {
            reader = Reader::new(params);
        }
        Ok(Fields {
            fields: self.fields,
            reader,
            as_bytes,
        })
    }

    /// Finds a field by name, ignoring case, `-` and `_`.
    #[must_use]
    pub fn field(&self, name: &str) -> Option<&'static Field> {
        self.fields
            .iter()
            .find(|field| crate::row::same_name(field.name, name))
    }
}

/// Iterator over the fields of a frame's parameters; see [`LayoutInfo::values`].
#[derive(Clone, Debug)]
pub struct Fields<'a> {
    fields: &'static [Field],
    reader: Reader<'a>,
    as_bytes: bool,
}

impl<'a> Iterator for Fields<'a> {
    type Item = (&'static Field, FieldValue<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let (field, rest) = self.fields.split_first()?;
        self.fields = rest;
        let value = if self.as_bytes {
            FieldValue::Unsigned(self.reader.slice(1)?.first().copied()?.into())
        } else {
            FieldValue::read(field, &mut self.reader)?
        };
        Some((field, value))
    }
}

/// The value of a field whose layout is known only at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldValue<'a> {
    /// An unsigned number.
    Unsigned(u64),
    /// A signed number.
    Signed(i32),
    /// A floating-point number.
    Float(f32),
    /// A byte where 0 is off and anything else is on.
    Flag(u8),
    /// A byte with named values.
    Enum(&'static EnumInfo, u8),
    /// A fixed-size array, as its bytes on the wire.
    Array(Scalar, &'a [u8]),
    /// Text before its NUL, usually UTF-8.
    Text(&'a [u8]),
    /// Bytes.
    Bytes(&'a [u8]),
    /// Alarm bits.
    Alarms(AlarmSet),
    /// Outputs to switch during a move.
    Outputs(PoList),
}

impl<'a> FieldValue<'a> {
    fn read(field: &Field, reader: &mut Reader<'a>) -> Option<Self> {
        Some(match field.ty {
            FieldType::Scalar(scalar) => Self::scalar(scalar, reader.slice(scalar.size())?),
            FieldType::Array(scalar, count) => {
                Self::Array(scalar, reader.slice(scalar.size() * count)?)
            }
            FieldType::Flag => Self::Flag(*reader.slice(1)?.first()?),
            FieldType::Enum(info) => Self::Enum(info, *reader.slice(1)?.first()?),
            FieldType::Text => Self::Text(until_nul(reader.rest())),
            FieldType::Bytes if reader.is_empty() => return None,
            FieldType::Bytes => Self::Bytes(reader.rest()),
            FieldType::Alarms => Self::Alarms(AlarmSet::read(reader).ok()?),
            FieldType::Outputs => Self::Outputs(PoList::read(reader).ok()?),
        })
    }

    fn scalar(scalar: Scalar, bytes: &[u8]) -> Self {
        let mut wide = [0; 8];
        for (to, from) in wide.iter_mut().zip(bytes) {
            *to = *from;
        }
        let number = u64::from_le_bytes(wide);
        match scalar {
            Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => Self::Unsigned(number),
            Scalar::I32 => Self::Signed(number as u32 as i32),
            Scalar::F32 => Self::Float(f32::from_bits(number as u32)),
        }
    }

    /// Items of an array; empty for other values.
    pub fn items(&self) -> impl Iterator<Item = FieldValue<'static>> + use<'a> {
        let (scalar, bytes) = match *self {
            Self::Array(scalar, bytes) => (scalar, bytes),
            _ => (Scalar::U8, &[][..]),
        };
        bytes
            .chunks_exact(scalar.size())
            .map(move |item| FieldValue::scalar(scalar, item))
    }
}

impl fmt::Display for FieldValue<'_> {
    /// Formats the value as the command line takes it: arrays with commas, outputs as
    /// `50:4:1,75:5:0`. An enum value is followed by its name. Text is [`visible`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unsigned(number) => number.fmt(f),
            Self::Signed(number) => number.fmt(f),
            Self::Float(number) => number.fmt(f),
            Self::Flag(byte) => byte.fmt(f),
            Self::Enum(info, byte) => match info.name_of(*byte) {
                Some(name) => write!(f, "{byte} ({name})"),
                None => byte.fmt(f),
            },
            Self::Array(..) => {
                for (at, item) in self.items().enumerate() {
                    write!(f, "{}{item}", if at == 0 { "" } else { "," })?;
                }
                Ok(())
            }
            Self::Text(bytes) => visible(Lossy(bytes)).fmt(f),
            Self::Bytes(bytes) => {
                for byte in *bytes {
                    write!(f, "{byte:02X}")?;
                }
                Ok(())
            }
            Self::Alarms(alarms) => alarms.fmt(f),
            Self::Outputs(list) => list.fmt(f),
        }
    }
}

/// Public name of a field: without the trailing `_` that avoids a Rust keyword.
pub(crate) const fn field_name(name: &'static str) -> &'static str {
    match name.as_bytes() {
        [_, .., b'_'] => name.split_at(name.len() - 1).0,
        _ => name,
    }
}

/// Writes the default of a field that the caller left out.
pub(crate) fn write_default(field: &Field, writer: &mut Writer<'_>) {
    let Some(default) = field.default else { return };
    match field.ty {
        FieldType::Scalar(Scalar::F32) => f32::from(default).write(writer),
        FieldType::Scalar(scalar) => {
            writer.put(&u64::from(default).to_le_bytes()[..scalar.size()]);
        }
        // Flags and enums are single bytes.
        _ => default.write(writer),
    }
}
