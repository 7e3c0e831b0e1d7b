//! Parameters from `key=value` arguments, checked against a layout; errors name the field and the
//! text.

use core::fmt;
use core::str::FromStr;

use crate::layout::{Field, LayoutInfo, write_default};
use crate::list::{PoCmd, PoList};
use crate::wire::{FieldType, Scalar, Wire};
use crate::{AlarmSet, Text, Writer};

/// Error of `key=value` arguments that do not match a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseError<'a> {
    /// No field has this name.
    UnknownField(&'a str),
    /// A required field was left out.
    Missing(&'static Field),
    /// A field was given twice.
    Twice(&'static Field),
    /// An optional field was given although an earlier one was left out.
    Gap {
        /// Field left out.
        missing: &'static Field,
        /// Field given.
        given: &'static Field,
    },
    /// The text is not a value of the field.
    Value {
        /// Field given.
        field: &'static Field,
        /// Text given.
        text: &'a str,
    },
}

impl fmt::Display for ParseError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownField(name) => write!(f, "no field '{name}'"),
            Self::Missing(field) => write!(f, "'{}' is missing: {}", field.name, Expected(field)),
            Self::Twice(field) => write!(f, "'{}' is given twice", field.name),
            Self::Gap { missing, given } => {
                write!(f, "'{}' needs '{}' too", given.name, missing.name)
            }
            Self::Value { field, text } => {
                write!(f, "'{}={text}': expected {}", field.name, Expected(field))
            }
        }
    }
}

impl core::error::Error for ParseError<'_> {}

/// Description of the values that a field takes.
struct Expected(&'static Field);

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let field = self.0;
        match field.ty {
            FieldType::Scalar(Scalar::F32) => f.write_str("a number")?,
            FieldType::Scalar(Scalar::I32) => f.write_str("a whole number")?,
            FieldType::Scalar(scalar) => write!(
                f,
                "a whole number from 0 to {}",
                u64::MAX >> (64 - 8 * scalar.size())
            )?,
            FieldType::Array(Scalar::F32, count) => write!(f, "{count} numbers with commas")?,
            FieldType::Array(_, count) => write!(f, "{count} whole numbers with commas")?,
            FieldType::Flag => f.write_str("0 or 1")?,
            FieldType::Enum(info) => {
                for (at, variant) in info.variants.iter().enumerate() {
                    let comma = if at == 0 { "" } else { ", " };
                    write!(f, "{comma}{} ({})", variant.value, variant.name)?;
                }
                return Ok(());
            }
            FieldType::Text => f.write_str("text of at most 247 bytes")?,
            FieldType::Bytes => f.write_str("bytes in hex")?,
            FieldType::Alarms => f.write_str("1 to 32 bytes with commas")?,
            FieldType::Outputs => return f.write_str("ratio:address:level with commas"),
        }
        write!(f, " ({})", field.unit)
    }
}

/// Encodes `key=value` arguments as the parameters of a layout.
///
/// Arrays are separated by commas, lists are `po=50:4:1,75:5:0`, enum values are names or numbers.
///
/// # Errors
/// [`ParseError`]; the bytes written until then must be discarded.
pub fn encode_text<'a>(
    info: &LayoutInfo,
    arguments: &[(&'a str, &'a str)],
    writer: &mut Writer<'_>,
) -> Result<(), ParseError<'a>> {
    for (at, (name, _)) in arguments.iter().enumerate() {
        let field = info.field(name).ok_or(ParseError::UnknownField(name))?;
        let before = arguments.get(..at).unwrap_or_default();
        if before
            .iter()
            .any(|(other, _)| info.field(other) == Some(field))
        {
            return Err(ParseError::Twice(field));
        }
    }
    // Fields are positional: bytes after a field left out would be decoded as that field.
    let mut gap = None;
    for field in info.fields {
        let given = arguments
            .iter()
            .find(|(name, _)| info.field(name) == Some(field));
        match (given, gap) {
            (Some(_), Some(missing)) => {
                return Err(ParseError::Gap {
                    missing,
                    given: field,
                });
            }
            (Some((_, text)), None) => {
                write_value(field, text, writer).ok_or(ParseError::Value { field, text })?
            }
            (None, _) if !field.optional => return Err(ParseError::Missing(field)),
            (None, _) if field.default.is_some() => write_default(field, writer),
            (None, _) => gap = Some(field),
        }
    }
    Ok(())
}

fn write_value(field: &Field, text: &str, writer: &mut Writer<'_>) -> Option<()> {
    match field.ty {
        FieldType::Scalar(scalar) => write_scalar(scalar, text, writer)?,
        FieldType::Array(scalar, count) => {
            if text.split(',').count() != count {
                return None;
            }
            for item in text.split(',') {
                write_scalar(scalar, item.trim(), writer)?;
            }
        }
        FieldType::Flag => match text {
            "on" | "true" | "yes" => 1u8.write(writer),
            "off" | "false" | "no" => 0u8.write(writer),
            number => write_number::<u8>(number, writer)?,
        },
        FieldType::Enum(info) => match info.value_of(text) {
            Some(value) => value.write(writer),
            // Enums are open, so values without a name are sent by number.
            None => write_number::<u8>(text, writer)?,
        },
        FieldType::Text => Text::new(text)?.write(writer),
        FieldType::Bytes => write_hex(text, writer)?,
        FieldType::Alarms => parse_alarms(text)?.write(writer),
        FieldType::Outputs => parse_outputs(text)?.write(writer),
    }
    Some(())
}

fn write_scalar(scalar: Scalar, text: &str, writer: &mut Writer<'_>) -> Option<()> {
    match scalar {
        Scalar::U8 => write_number::<u8>(text, writer),
        Scalar::U16 => write_number::<u16>(text, writer),
        Scalar::U32 => write_number::<u32>(text, writer),
        Scalar::U64 => write_number::<u64>(text, writer),
        Scalar::I32 => write_number::<i32>(text, writer),
        Scalar::F32 => write_number::<f32>(text, writer),
    }
}

fn write_number<T: FromStr + Wire>(text: &str, writer: &mut Writer<'_>) -> Option<()> {
    text.parse::<T>().ok()?.write(writer);
    Some(())
}

fn write_hex(text: &str, writer: &mut Writer<'_>) -> Option<()> {
    let pairs = text.as_bytes().chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return None;
    }
    for pair in pairs {
        let mut byte = 0;
        for digit in pair {
            byte = byte << 4 | char::from(*digit).to_digit(16)? as u8;
        }
        byte.write(writer);
    }
    Some(())
}

fn parse_alarms(text: &str) -> Option<AlarmSet> {
    let mut bytes = [0; AlarmSet::CAPACITY];
    let mut len = 0;
    for item in text.split(',') {
        *bytes.get_mut(len)? = item.trim().parse().ok()?;
        len += 1;
    }
    AlarmSet::from_bytes(bytes.get(..len)?)
}

fn parse_outputs(text: &str) -> Option<PoList> {
    let mut items = [PoCmd::default(); PoList::CAPACITY];
    let mut len = 0;
    // An empty text is an empty list.
    for entry in text.split(',').filter(|entry| !entry.trim().is_empty()) {
        let mut parts = entry.trim().split(':');
        *items.get_mut(len)? = PoCmd {
            ratio: parts.next()?.parse().ok()?,
            address: parts.next()?.parse().ok()?,
            level: parts.next()?.parse().ok()?,
        };
        parts.next().is_none().then_some(())?;
        len += 1;
    }
    PoList::new(items.get(..len)?)
}
