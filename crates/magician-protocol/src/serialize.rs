//! JSON shape of values (feature `serde`): an object with one entry for each field present.

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use crate::layout::{FieldValue, Fields};
use crate::text::Lossy;
use crate::{DecodeError, Description, Layout, MAX_PARAMS, Writer};

impl Serialize for FieldValue<'_> {
    /// Serialises numbers as numbers (NaN and infinities as strings), bytes as hex, enums and flags
    /// as their wire numbers.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Unsigned(number) => serializer.serialize_u64(*number),
            Self::Signed(number) => serializer.serialize_i32(*number),
            Self::Float(number) if number.is_finite() => serializer.serialize_f32(*number),
            // JSON has no numbers for NaN and infinities.
            Self::Float(number) => serializer.collect_str(number),
            Self::Flag(byte) | Self::Enum(_, byte) => serializer.serialize_u8(*byte),
            Self::Array(..) => serializer.collect_seq(self.items()),
            Self::Text(bytes) => serializer.collect_str(&Lossy(bytes)),
            Self::Bytes(_) => serializer.collect_str(self),
            Self::Alarms(alarms) => serializer.collect_seq(alarms.as_bytes()),
            Self::Outputs(list) => {
                let mut entries = serializer.serialize_seq(Some(list.as_slice().len()))?;
                for item in list.as_slice() {
                    entries.serialize_element(&Output {
                        ratio: item.ratio,
                        address: item.address,
                        level: item.level,
                    })?;
                }
                entries.end()
            }
        }
    }
}

#[derive(serde::Serialize)]
struct Output {
    ratio: u8,
    address: u16,
    level: u8,
}

fn serialize_fields<S: Serializer>(
    values: Result<Fields<'_>, DecodeError>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(None)?;
    for (field, value) in values.map_err(serde::ser::Error::custom)? {
        map.serialize_entry(field.name, &value)?;
    }
    map.end()
}

/// Serialises the fields of a layout as a map.
pub(crate) fn serialize_layout<L: Layout, S: Serializer>(
    layout: &L,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    // Through the wire form, so that typed values and frames have the same JSON.
    let mut params = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut params);
    layout.encode(&mut writer);
    let count = writer.finish().map_err(serde::ser::Error::custom)?;
    serialize_fields(L::INFO.values(&params[..count]), serializer)
}

impl Serialize for Description<'_> {
    /// Serialises the fields that the frame carries as a map.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serialize_fields(self.values(), serializer)
    }
}
