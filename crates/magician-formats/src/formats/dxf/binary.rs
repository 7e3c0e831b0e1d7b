//! Conversion of binary DXF to text with the same pairs.

use std::fmt::Write;

use magician_host::message;

use crate::Diagnostic;

const SENTINEL: &[u8] = b"AutoCAD Binary DXF\r\n\x1A\0";

/// Converts a binary file to text; `None` if the file is not binary.
pub(super) fn to_text(bytes: &[u8]) -> Result<Option<String>, Diagnostic> {
    let Some(rest) = bytes.strip_prefix(SENTINEL) else {
        return Ok(None);
    };
    // The first code is 0, stored in one byte up to release 12 and in two since. The next byte is a
    // letter of `SECTION` or the high byte.
    let wide = rest.get(1) == Some(&0);
    let mut reader = Reader { rest };
    let mut text = String::new();
    while !reader.rest.is_empty() {
        let pair = reader.pair(wide, &mut text);
        pair.ok_or_else(|| Diagnostic::of_file(message!("the binary DXF file is cut short")))?;
    }
    Ok(Some(text))
}

struct Reader<'b> {
    rest: &'b [u8],
}

impl<'b> Reader<'b> {
    fn pair(&mut self, wide: bool, text: &mut String) -> Option<()> {
        let code = match (wide, self.rest.first()?) {
            (false, 255) => {
                self.take::<1>()?;
                i16::from_le_bytes(self.take()?)
            }
            (false, _) => u8::from_le_bytes(self.take()?).into(),
            (true, _) => i16::from_le_bytes(self.take()?),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{code}");
        let _ = match code {
            290..=299 => writeln!(text, "{}", u8::from_le_bytes(self.take()?)),
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => {
                writeln!(text, "{}", i16::from_le_bytes(self.take()?))
            }
            90..=99 | 420..=429 | 440..=459 | 1071 => {
                writeln!(text, "{}", i32::from_le_bytes(self.take()?))
            }
            160..=169 => writeln!(text, "{}", i64::from_le_bytes(self.take()?)),
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => {
                writeln!(text, "{}", f64::from_le_bytes(self.take()?))
            }
            310..=319 | 1004 => {
                let length = u8::from_le_bytes(self.take()?);
                self.rest = self.rest.get(usize::from(length)..)?;
                writeln!(text)
            }
            _ => {
                let value = String::from_utf8_lossy(self.string()?);
                // A line end within a value would start another pair.
                writeln!(text, "{}", value.replace(['\r', '\n'], " "))
            }
        };
        Some(())
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (value, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*value)
    }

    fn string(&mut self) -> Option<&'b [u8]> {
        let end = self.rest.iter().position(|byte| *byte == 0)?;
        let (value, rest) = self.rest.split_at_checked(end)?;
        self.rest = rest.get(1..)?;
        Some(value)
    }
}
