//! Hex text as it is pasted: `AA AA 02`, `AAAA02`, `0xAA, 0xAA, 0x2`.

use thiserror::Error;

/// True if a complete text is hex: hex digits, whitespace, commas and `0x` only.
#[must_use]
pub fn is_hex(text: &str) -> bool {
    Test::default().accepts(text.as_bytes())
}

/// Converts a complete hex text to bytes.
///
/// # Errors
/// As for [`Parser::push`].
pub fn bytes(text: &str) -> Result<Vec<u8>, HexError> {
    let (mut parser, mut bytes) = (Parser::default(), Vec::with_capacity(text.len() / 2));
    parser.push(text.as_bytes(), &mut bytes)?;
    parser.finish(&mut bytes)?;
    Ok(bytes)
}

/// Incremental test for hex text: hex digits, whitespace, commas and `0x` only.
#[derive(Clone, Copy, Debug, Default)]
pub struct Test {
    after_zero: bool,
}

impl Test {
    /// Checks further text; false once it cannot be hex.
    pub fn accepts(&mut self, text: &[u8]) -> bool {
        text.iter().all(|letter| {
            let after_zero = std::mem::replace(&mut self.after_zero, *letter == b'0');
            match letter {
                b'x' | b'X' => after_zero,
                letter => letter.is_ascii_hexdigit() || is_separator(*letter),
            }
        })
    }
}

fn is_separator(letter: u8) -> bool {
    letter == b',' || letter.is_ascii_whitespace() || letter == 0x0B
}

/// Reason why a text is not valid hex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum HexError {
    /// A character that hex text cannot contain, at this position.
    #[error("the text is hex only up to position {0}")]
    Letter(u64),
    /// A group with an odd number of digits that ends before this position.
    #[error("odd number of hex digits before position {0}")]
    Odd(u64),
}

/// Incremental converter from hex text to bytes: the text may be split anywhere. A group of a
/// single digit is one byte.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parser {
    position: u64,
    /// Number of digits since the last separator.
    digits: u64,
    high: Option<u8>,
}

impl Parser {
    /// Reads further text and appends its bytes to `bytes`.
    ///
    /// # Errors
    /// [`HexError::Letter`] for a character that hex text cannot contain, [`HexError::Odd`] for a
    /// group with an odd number of digits.
    pub fn push(&mut self, text: &[u8], bytes: &mut Vec<u8>) -> Result<(), HexError> {
        for letter in text {
            match char::from(*letter).to_digit(16) {
                Some(digit) => self.digit(digit as u8, bytes),
                None if is_separator(*letter) => self.finish(bytes)?,
                // `0x` begins a group. The 0 must begin a byte: `A0x` is an error.
                None if matches!(letter, b'x' | b'X')
                    && self.high == Some(0)
                    && self.digits % 2 == 1 =>
                {
                    (self.high, self.digits) = (None, 0);
                }
                None => return Err(HexError::Letter(self.position)),
            }
            self.position += 1;
        }
        Ok(())
    }

    fn digit(&mut self, digit: u8, bytes: &mut Vec<u8>) {
        self.digits += 1;
        match self.high.take() {
            None => self.high = Some(digit),
            Some(high) => bytes.push(high << 4 | digit),
        }
    }

    /// Ends a group of digits.
    ///
    /// # Errors
    /// [`HexError::Odd`] if it has an odd number of digits.
    pub fn finish(&mut self, bytes: &mut Vec<u8>) -> Result<(), HexError> {
        let digits = std::mem::take(&mut self.digits);
        match self.high.take() {
            None => Ok(()),
            // `0x2` and a lone `A` are common in logs, so one digit is a byte.
            Some(digit) if digits == 1 => {
                bytes.push(digit);
                Ok(())
            }
            Some(_) => Err(HexError::Odd(self.position)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<u8>, HexError> {
        let (mut parser, mut bytes) = (Parser::default(), Vec::new());
        for letter in text.as_bytes().chunks(1) {
            parser.push(letter, &mut bytes)?;
        }
        parser.finish(&mut bytes).map(|()| bytes)
    }

    #[test]
    fn common_notations_of_hex_are_parsed() {
        let bytes = vec![0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];
        for text in [
            "AA AA 02 0A 00 F6",
            "aaaa020a00f6",
            "0xAA,0xAA,0x2,0xA,0x0,0xF6",
            "0xAAAA020A00F6",
            "AA\tAA\r\n02,0A 0 f6\n",
            "0xAA0xAA 0x02 0X0A00 F6",
        ] {
            assert!(Test::default().accepts(text.as_bytes()), "{text}");
            assert_eq!(parse(text), Ok(bytes.clone()), "{text}");
        }
    }

    #[test]
    fn text_that_is_not_hex_is_rejected() {
        for text in ["M10", "AA-AA", "xAA", "AA x2", "capture.bin", "0xx1"] {
            assert!(!Test::default().accepts(text.as_bytes()), "{text}");
        }
        assert_eq!(parse("AAA"), Err(HexError::Odd(3)));
        assert_eq!(parse("AA ZZ"), Err(HexError::Letter(3)));
        assert_eq!(parse("A0xBB"), Err(HexError::Letter(2)));
    }
}
