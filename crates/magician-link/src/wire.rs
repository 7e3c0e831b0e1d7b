//! Encoding and decoding of commands without a row in the protocol's table.

use serde_json::{Map, Value, json};

use crate::error::LinkError;
use crate::methods::{Method, Wire};
use crate::params::CallParams;
use crate::results::shape;

/// Encodes the parameters of a frame as hexadecimal digits.
///
/// # Errors
/// A number that does not fit its type.
pub(crate) fn encode(given: &CallParams) -> Result<String, LinkError> {
    let mut bytes = Vec::new();
    for (param, value) in given.in_order() {
        let beyond = || LinkError::params(format!("`{}` does not fit", param.name));
        match param.wire {
            Some(Wire::U8) => {
                let number = match value {
                    Value::Bool(on) => Some(u64::from(*on)),
                    value => value.as_u64(),
                };
                let byte = number.and_then(|number| u8::try_from(number).ok());
                bytes.push(byte.ok_or_else(beyond)?);
            }
            Some(Wire::F32) => {
                let number = value.as_f64().ok_or_else(beyond)? as f32;
                if !number.is_finite() {
                    return Err(beyond());
                }
                bytes.extend(number.to_le_bytes());
            }
            Some(Wire::Text) => {
                bytes.extend(value.as_str().unwrap_or_default().bytes());
                // The controller reads up to the zero.
                bytes.push(0);
            }
            None => {}
        }
    }
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Decodes the parameters of a frame into an answer. Values that the frame is too short for are
/// left out.
pub(crate) fn decode(method: &Method, hex: &str) -> Value {
    let bytes: Vec<u8> = { hex.as_bytes().chunks(2) }
        .filter_map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok())
        .collect();
    let mut rest = bytes.as_slice();
    let mut object = Map::new();
    for field in &method.results {
        let value = match field.wire {
            Some(Wire::U8) => rest.split_first().map(|(byte, after)| {
                rest = after;
                json!(byte)
            }),
            Some(Wire::F32) => rest.split_first_chunk().map(|(number, after)| {
                rest = after;
                json!(f32::from_le_bytes(*number))
            }),
            Some(Wire::Text) => {
                let text = rest.split(|byte| *byte == 0).next().unwrap_or_default();
                let text = String::from_utf8_lossy(text).into_owned();
                // A text takes the rest of the frame.
                rest = &[];
                Some(json!(text))
            }
            None => None,
        };
        let value = value.and_then(|value| shape(field, &value, &Value::Null));
        if let Some(value) = value {
            object.insert(field.name.clone(), value);
        }
    }
    Value::Object(object)
}
