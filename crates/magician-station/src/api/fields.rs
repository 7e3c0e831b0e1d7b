//! Encoding of a command's fields from JSON to bytes.

use magician_protocol::{LayoutInfo, MAX_PARAMS, Writer, encode_text};
use serde_json::{Map, Value};

/// Encodes fields with the same parser as the command line, so that both accept the same values.
///
/// # Errors
/// What is wrong, as a sentence.
pub(crate) fn encode(layout: &LayoutInfo, given: &Map<String, Value>) -> Result<Vec<u8>, String> {
    let pairs_of_text: Vec<_> = given
        .iter()
        .map(|(name, value)| (name.as_str(), cli_form(value)))
        .collect();
    let pairs: Vec<_> = pairs_of_text
        .iter()
        .map(|(name, value)| (*name, value.as_str()))
        .collect();
    let mut bytes = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut bytes);
    encode_text(layout, &pairs, &mut writer).map_err(|error| error.to_string())?;
    let count = writer.finish().map_err(|error| error.to_string())?;
    Ok(bytes.get(..count).unwrap_or_default().to_vec())
}

/// Converts a JSON value to its form on the command line.
fn cli_form(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(cli_form).collect();
            items.join(",")
        }
        // An output of a path: ratio, address and level.
        Value::Object(parts) => {
            let parts: Vec<_> = parts.values().map(cli_form).collect();
            parts.join(":")
        }
        // Numbers, true, false and null read as on the command line.
        value => value.to_string(),
    }
}
