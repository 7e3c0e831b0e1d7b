//! Encoded polylines (PE) of HP-GL/2: numbers in base 64 or 32, least significant digit first.
//!
//! A number is doubled, plus 1 if it is negative. In base 64 a digit is a character from 63 on, and
//! the last digit a character from 191 on. In base 32 (flag 7) the last digit is a character from
//! 95 on. Flags are `:` for a pen, `<` for a move with the pen up, `>` for the number of fractional
//! bits, `=` for an absolute point. Points without a flag are relative to the previous one, and
//! drawn.

use magician_host::message;

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::formats::span::SpanDiagnostic;

/// Lowest character of a digit before the last.
const FIRST_DIGIT: u8 = 63;
/// Lowest character of the last digit in base 64.
const LAST_DIGIT_BASE_64: u8 = 191;
/// Lowest character of the last digit in base 32.
const LAST_DIGIT_BASE_32: u8 = 95;
/// Largest number of digits. More would exceed any sheet.
const MAX_DIGITS: u32 = 8;
/// Largest number of fractional bits.
const MAX_BITS: f64 = 26.0;

/// Item of an encoded polyline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Item {
    Pen(f64),
    Up,
    Absolute,
    /// A point, scaled by the fractional bits.
    Point([f64; 2]),
}

/// Reason why no number could be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ReadError {
    /// The last digit is missing.
    CutOff,
    /// A character is not a digit.
    Damaged,
}

/// Decodes a polyline. Returns its items, and true if the last number is cut off. `None` if a
/// character is not a digit.
pub(super) fn items(bytes: &[u8]) -> Option<(Vec<Item>, bool)> {
    let mut items = Vec::new();
    match gather(bytes, &mut items) {
        Ok(()) => Some((items, false)),
        Err(ReadError::CutOff) => Some((items, true)),
        Err(ReadError::Damaged) => None,
    }
}

fn gather(bytes: &[u8], items: &mut Vec<Item>) -> Result<(), ReadError> {
    let mut numbers = Numbers {
        bytes,
        base: 64,
        last: LAST_DIGIT_BASE_64,
    };
    let mut share = 1.0;
    while let Some((byte, rest)) = numbers.bytes.split_first() {
        let flag = matches!(byte, b':' | b'<' | b'>' | b'=' | b'7');
        if flag || *byte < FIRST_DIGIT {
            // Blanks may stand between numbers.
            numbers.bytes = rest;
        }
        match byte {
            b':' => items.push(Item::Pen(numbers.next()?)),
            b'<' => items.push(Item::Up),
            b'=' => items.push(Item::Absolute),
            b'7' => (numbers.base, numbers.last) = (32, LAST_DIGIT_BASE_32),
            b'>' => {
                let bits = numbers.next()?;
                if bits.abs() > MAX_BITS {
                    return Err(ReadError::Damaged);
                }
                share = libm::exp2(-bits);
            }
            byte if *byte >= FIRST_DIGIT => {
                let point = [numbers.next()?, numbers.next()?];
                items.push(Item::Point(point.map(|number| number * share)));
            }
            _ => {}
        }
    }
    Ok(())
}

struct Numbers<'b> {
    bytes: &'b [u8],
    base: u64,
    last: u8,
}

impl Numbers<'_> {
    fn next(&mut self) -> Result<f64, ReadError> {
        let (mut value, mut digits) = (0_u64, 0);
        loop {
            let (byte, rest) = self.bytes.split_first().ok_or(ReadError::CutOff)?;
            self.bytes = rest;
            // In base 32 a character has seven significant bits.
            let byte = match self.base {
                32 => byte & 0x7F,
                _ => *byte,
            };
            if byte < FIRST_DIGIT {
                continue;
            }
            let ends = byte >= self.last;
            let digit = u64::from(byte - if ends { self.last } else { FIRST_DIGIT });
            if digit >= self.base || digits == MAX_DIGITS {
                return Err(ReadError::Damaged);
            }
            value += digit * self.base.pow(digits);
            digits += 1;
            if ends {
                let size = (value >> 1) as f64;
                return Ok(if value & 1 == 1 { -size } else { size });
            }
        }
    }
}

/// Returns characters below 256 as bytes, or `None` if another occurs.
fn as_bytes(text: &str) -> Option<Vec<u8>> {
    let bytes = text.chars().map(|sign| u8::try_from(u32::from(sign)));
    bytes.collect::<Result<_, _>>().ok()
}

impl Plotter<'_> {
    /// Handles PE. Afterwards absolute or relative mode is as before, and the pen stays up after a
    /// move with the pen up.
    pub(super) fn encoded(&mut self, instruction: &Instruction) -> Result<(), SpanDiagnostic> {
        // If the file was re-saved as UTF-8, each byte became a character, and its UTF-8 bytes are
        // not valid digits. So try bytes first, then characters.
        let read = items(&self.bytes_of(&instruction.text))
            .or_else(|| items(&as_bytes(&instruction.text)?));
        let Some((items, cut_off)) = read else {
            let message =
                message!("an encoded polyline (PE) is damaged: a character in it is not a digit");
            return Err(SpanDiagnostic::new(instruction.range.clone(), message));
        };
        if cut_off {
            self.note(
                instruction,
                message!("the end of an encoded polyline (PE) is cut off"),
            );
        }
        let (mut up, mut absolute) = (false, false);
        for item in items {
            match item {
                Item::Pen(pen) => self.select(pen),
                Item::Up => up = true,
                Item::Absolute => absolute = true,
                Item::Point([x, y]) => {
                    let from = if absolute { [0.0; 2] } else { self.at };
                    if up {
                        self.lift();
                    } else {
                        self.down = true;
                    }
                    self.line([from[0] + x, from[1] + y], instruction)?;
                    (up, absolute) = (false, false);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoded_numbers_match_the_manual() {
        // 82.23 with 7 fractional bits, from the manual's example.
        let [to_64, to_32] = [&[121, 71, 196][..], b"YPs"];
        for (flags, digits) in [(&b""[..], to_64), (b"7", to_32)] {
            let bytes = [flags, digits, digits].concat();
            let point = Item::Point([10525.0, 10525.0]);
            assert_eq!(items(&bytes), Some((vec![point], false)));
        }
        let negative = [121 + 1, 71, 196, 191, b';'];
        assert_eq!(
            items(&negative[..4]),
            Some((vec![Item::Point([-10525.0, 0.0])], false))
        );
    }

    #[test]
    fn flags_and_fractions_are_decoded_and_garbage_gives_none() {
        // 1 fractional bit: 3/2, then -1/2.
        let found = items(b"7:c\r\n<=>aec").unwrap();
        let expected = vec![
            Item::Pen(2.0),
            Item::Up,
            Item::Absolute,
            Item::Point([1.5, 1.0]),
        ];
        assert_eq!(found, (expected, false));
        for none in [&b"7?????????_e"[..], b"7>?bee", &[255, 191]] {
            assert_eq!(items(none), None, "{none:?}");
        }
        for cut in [&b"7e"[..], b":", &[121, 121]] {
            assert_eq!(items(cut), Some((vec![], true)), "{cut:?}");
        }
    }
}
