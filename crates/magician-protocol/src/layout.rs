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
    /// Its name, as in JSON and on the command line.
    pub name: &'static str,
    /// How it lies on the wire.
    pub ty: FieldType,
    /// Its unit, or what it is instead of a quantity.
    pub unit: &'static str,
    /// Values it may take.
    pub range: Range,
    /// What it means.
    pub doc: &'static str,
    /// Whether a host may leave it out.
    pub optional: bool,
    /// Whether a controller accepts a frame that ends before it: a sender leaves out all such
    /// fields of a layout or none.
    pub omittable: bool,
    /// What a host sends when the field is left out; `None` sends nothing.
    pub default: Option<u8>,
}

/// A parameter count that is not the layout's own but is accepted from the hosts that send it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Form {
    /// Parameter bytes.
    pub len: usize,
    /// How the bytes map to the layout.
    pub kind: FormKind,
    /// The senders of this form, with the errata number.
    pub note: &'static str,
}

/// How a tolerated form maps to its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum FormKind {
    /// The missing tail is zero.
    Zeros,
    /// The layout begins after this many bytes.
    Skip(usize),
    /// Every number comes as one byte.
    Bytes,
}

/// The fields of one form of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LayoutInfo {
    /// Name of the Rust type.
    pub name: &'static str,
    /// Its fields in wire order.
    pub fields: &'static [Field],
    /// Tolerated forms.
    pub forms: &'static [Form],
}

/// How the parameters of a frame fit a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Normalised {
    /// The mapping, [`FormKind::Skip`]`(0)` for the layout's own form.
    pub kind: FormKind,
    /// The leniency applied, if any.
    pub note: Option<&'static str>,
}

const SURPLUS: &str = "surplus parameter bytes ignored (E11)";
const OMITTED: &str = "address or port left out (E39, E43)";
/// Longest layout that has a tolerated form, rounded up.
const LONGEST_FORM: usize = 32;

impl LayoutInfo {
    /// Bytes of the exact form, `None` when its last field takes the rest of the frame.
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

    /// Finds the form that a parameter count belongs to.
    ///
    /// # Errors
    /// [`DecodeError::Length`] when it belongs to none.
    pub fn normalise(&self, count: usize) -> Result<Normalised, DecodeError> {
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
            Some(full) if count > full => Some(SURPLUS),
            Some(_) if count == shortest => self.omission(),
            _ => {
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

    /// What to say of a frame that ends before the fields that may be left out.
    fn omission(&self) -> Option<&'static str> {
        self.fields
            .iter()
            .any(|field| field.omittable && !field.optional)
            .then_some(OMITTED)
    }

    /// Brings a tolerated form into the layout's own, then hands it to `read`.
    pub(crate) fn read_form<T>(
        &self,
        params: &[u8],
        read: impl FnOnce(&mut Reader<'_>) -> Result<T, DecodeError>,
    ) -> Result<T, DecodeError> {
        match self.normalise(params.len())?.kind {
            FormKind::Skip(count) => read(&mut Reader::new(params.get(count..).unwrap_or(&[]))),
            FormKind::Zeros => {
                let mut bytes = [0; LONGEST_FORM];
                for (to, from) in bytes.iter_mut().zip(params) {
                    *to = *from;
                }
                read(&mut Reader::new(&bytes[..self.form_size()]))
            }
            FormKind::Bytes => {
                let mut bytes = [0; LONGEST_FORM];
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
        self.size().unwrap_or(0).min(LONGEST_FORM)
    }

    /// The fields that these parameters hold, with their values. A field that a short form
    /// leaves out does not appear.
    ///
    /// # Errors
    /// As [`normalise`](Self::normalise), and [`DecodeError::List`] for a list of outputs that
    /// fits neither form.
    pub fn values<'a>(&self, params: &'a [u8]) -> Result<Fields<'a>, DecodeError> {
        let normalised = self.normalise(params.len())?;
        let (skip, as_bytes) = match normalised.kind {
            FormKind::Skip(count) => (count, false),
            FormKind::Zeros => (0, false),
            FormKind::Bytes => (0, true),
        };
        let mut reader = Reader::new(params.get(skip..).unwrap_or(&[]));
        if let Some((last, head)) = self.fields.split_last()
            && matches!(last.ty, FieldType::Outputs | FieldType::Alarms)
        {
            let mut probe = reader.clone();
            let _ = probe.slice(head.iter().filter_map(|field| field.ty.size()).sum());
            match last.ty {
                FieldType::Outputs => drop(PoList::read(&mut probe)?),
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

    /// The field of this name, without regard to case, `-` and `_`.
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

/// The value of a field, for programs that learn of the layout at run time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldValue<'a> {
    /// An unsigned number.
    Unsigned(u64),
    /// A signed number.
    Signed(i32),
    /// A number with a fraction.
    Float(f32),
    /// A byte of which 0 is off and anything else is on.
    Flag(u8),
    /// A byte with named values.
    Enum(&'static EnumInfo, u8),
    /// A fixed number of numbers, as they lie on the wire.
    Array(Scalar, &'a [u8]),
    /// Text up to its NUL, usually UTF-8.
    Text(&'a [u8]),
    /// Bytes.
    Bytes(&'a [u8]),
    /// Alarm bits.
    Alarms(AlarmSet),
    /// Outputs to switch on the way.
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

    /// The items of an array; nothing for other values.
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
    /// As the command line takes it: arrays with commas, outputs as `50:4:1,75:5:0`; a named
    /// value of an enum is followed by its name. Text is [`visible`].
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

/// A field's name on the wire side: a trailing `_` only keeps clear of Rust's keywords.
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
        _ => default.write(writer),
    }
}
