//! Answers to reads, in the form of DobotLink.

use serde_json::{Map, Value, json};

use crate::methods::{Conversion, Method, ResultField};

/// Offset of the hardware version in the bytes that follow the three numbers of the firmware
/// version. Shorter replies have no hardware version.
const HARDWARE_VERSION_OFFSET: usize = 10;

/// Returns the answer made from the fields of a command.
pub(crate) fn result(method: &Method, fields: &Value) -> Value {
    let mut object = Map::new();
    for field in &method.results {
        let name = field.field.as_deref().unwrap_or_default();
        let value = fields.get(name).unwrap_or(&Value::Null);
        if let Some(value) = convert(field, value, fields) {
            object.insert(field.name.clone(), value);
        }
    }
    Value::Object(object)
}

/// Converts a value. `None` if the answer lacks this field in the current mode of the path.
pub(crate) fn convert(field: &ResultField, value: &Value, fields: &Value) -> Option<Value> {
    let real_time = || fields.get("real_time_track").and_then(Value::as_u64) == Some(1);
    match field.kind {
        Conversion::Value => Some(value.clone()),
        // Levels are numbers on the wire.
        Conversion::Bool => Some(json!(value.as_f64().is_some_and(|level| level != 0.0))),
        Conversion::Clock => Some(json!(format_time_of_day(
            value.as_u64().unwrap_or_default()
        ))),
        Conversion::Hardware => {
            let bytes = value.as_str().unwrap_or_default();
            let byte = bytes.get(2 * HARDWARE_VERSION_OFFSET..2 * HARDWARE_VERSION_OFFSET + 2);
            let byte = byte.and_then(|digits| u8::from_str_radix(digits, 16).ok());
            Some(json!(byte.unwrap_or(0)))
        }
        Conversion::Period => real_time().then(|| value.clone()),
        Conversion::Acceleration => (!real_time()).then(|| value.clone()),
    }
}

/// Formats milliseconds since the start as a time of day, `hh:mm:ss.z`, without trailing zeros in
/// the fraction.
fn format_time_of_day(ms: u64) -> String {
    // A time of day starts again after 24 h, also if the arm has run longer.
    let (seconds, fraction) = (ms / 1000 % 86_400, ms % 1000);
    let fraction = format!("{fraction:03}");
    let fraction = match fraction.trim_end_matches('0') {
        "" => "0",
        digits => digits,
    };
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    format!("{hours:02}:{minutes:02}:{:02}.{fraction}", seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uptime_is_formatted_as_time_of_day() {
        assert_eq!(format_time_of_day(0), "00:00:00.0");
        assert_eq!(format_time_of_day(3_723_450), "01:02:03.45");
        assert_eq!(format_time_of_day(86_400_007), "00:00:00.007");
    }
}
