//! JSON that is safe to print on a terminal.

use std::io::{self, Write};

use magician_protocol::is_deceptive;
use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter};

/// Writes a value as JSON with all control and deceptive characters escaped. JSON itself only
/// requires that for C0.
pub(crate) fn write_json(to: impl Write, value: &impl Serialize) -> serde_json::Result<()> {
    value.serialize(&mut serde_json::Serializer::with_formatter(
        to,
        EscapingFormatter,
    ))
}

/// Returns the same as a string.
pub(crate) fn json(value: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    // Serializing cannot fail: our types have no map with keys other than strings and no failing
    // `Serialize`.
    let _ = write_json(&mut bytes, value);
    String::from_utf8(bytes).unwrap_or_default()
}

struct EscapingFormatter;

impl Formatter for EscapingFormatter {
    fn write_string_fragment<W: Write + ?Sized>(
        &mut self,
        to: &mut W,
        text: &str,
    ) -> io::Result<()> {
        let mut rest = text;
        while let Some(at) = rest.find(is_deceptive) {
            let (plain, from) = rest.split_at(at);
            CompactFormatter.write_string_fragment(to, plain)?;
            let mut signs = from.chars();
            for unit in signs.next().unwrap_or_default().encode_utf16(&mut [0; 2]) {
                write!(to, "\\u{unit:04x}")?;
            }
            rest = signs.as_str();
        }
        CompactFormatter.write_string_fragment(to, rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOSTILE: &str = "\x1b]0;mine\x07 \x1b[31mred \u{9b}2J \x7f \u{202e}gnp.exe\r";

    #[test]
    fn json_escapes_control_characters_and_round_trips() {
        let value = serde_json::json!({"name": HOSTILE, "tag": "\u{e0041}\n\"ä\\"});
        let text = json(&value);
        assert!(!text.contains(is_deceptive), "{text:?}");
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            value
        );
    }
}
