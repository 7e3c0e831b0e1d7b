//! Splitting a line of G-code into words (a letter and a number each) and parameter assignments.

use std::ops::Range;

use magician_host::{Message, message};

use super::behind_number;
use super::parameters::{Key, Parameters};
use crate::formats::span::SpanDiagnostic;

/// Letters after a comma that modify the corner of a line (Fanuc): radius, chamfer, angle.
const CORNER_LETTERS: [u8; 3] = *b"RCA";
/// Largest magnitude of a number, whatever its unit. Beyond it the file is damaged.
const MAX_NUMBER: f64 = 1e9;
/// Number of digits that fit into the integer in which they are collected.
const MAX_DIGITS: u32 = 19;
/// Powers of ten that are exact in a binary64.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A word.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Word {
    /// Letter in upper case.
    pub(super) letter: u8,
    /// Number; `None` for words that are complete without one, such as the X in `G28 X`.
    pub(super) number: Option<f64>,
    /// Range of bytes in the line.
    pub(super) range: Range<usize>,
}

/// Item of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    Word(Word),
    /// Assignment of a parameter, with value and place. It takes effect after the line.
    Set(Key, f64, Range<usize>),
    /// A part addressed to a controller, left out, with reason and place.
    LeftOut(Message, Range<usize>),
}

/// Iterator over the words of a line. Blanks may occur anywhere except inside a number. Comments,
/// percent signs around a program and a checksum at the end are skipped.
#[derive(Debug)]
pub(super) struct Words<'l> {
    pub(super) line: &'l str,
    pub(super) at: usize,
    pub(super) values: &'l Parameters,
    /// True if nested comments are not closed; then the first closing parenthesis ends a comment.
    unbalanced: bool,
}

impl<'l> Words<'l> {
    pub(super) fn new(line: &'l str, values: &'l Parameters) -> Self {
        Self {
            line,
            at: 0,
            values,
            unbalanced: false,
        }
    }

    pub(super) fn peek(&self) -> Option<u8> {
        self.line.as_bytes().get(self.at).copied()
    }

    pub(super) fn pass(&mut self, passes: impl Fn(u8) -> bool) {
        while self.peek().is_some_and(&passes) {
            self.at += 1;
        }
    }

    pub(super) fn skip_blanks(&mut self) {
        self.pass(|byte| byte.is_ascii_whitespace() || byte == b'\x0b');
    }

    /// Moves to the next word and returns its first byte. `None` at the end of the code.
    pub(super) fn begin(&mut self) -> Option<u8> {
        loop {
            self.skip_blanks();
            match self.peek()? {
                b'%' => self.at += 1,
                b'(' => self.skip_comment(),
                // Some programs put a comma between words. A number after a comma has no letter and
                // is an error.
                b',' if self
                    .byte_after_comma()
                    .is_some_and(|next| next.is_ascii_alphabetic()) =>
                {
                    self.at += 1;
                }
                // A checksum ends the line, and so does the end-of-file character of DOS.
                b';' | b'*' | b'\x1a' => return None,
                byte => return Some(byte),
            }
        }
    }

    /// Returns the first byte after a comma, or `None` if it begins a corner modifier such as
    /// `,R2`.
    fn byte_after_comma(&self) -> Option<u8> {
        let rest = self.line.as_bytes().get(self.at + 1..)?;
        let next = rest.iter().find(|byte| !byte.is_ascii_whitespace())?;
        (!CORNER_LETTERS.contains(&next.to_ascii_uppercase())).then_some(*next)
    }

    /// Skips a comment to its matching parenthesis, or to the first one if parentheses are
    /// unbalanced.
    fn skip_comment(&mut self) {
        let (mut depth, start) = (0_u32, self.at);
        while let Some(byte) = self.peek().filter(|_| !self.unbalanced) {
            self.at += 1;
            match byte {
                b'(' => depth += 1,
                b')' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return;
            }
        }
        self.unbalanced = true;
        self.at = start;
        self.pass(|byte| byte != b')');
        self.at += 1;
    }

    fn word(&mut self, letter: u8) -> Result<Word, SpanDiagnostic> {
        let start = self.at;
        if let Some(word) = self.macro_word() {
            let message = message!("{word} of a Fanuc macro is not supported", word);
            let help = message!(
                "export the program without macros, or write its loops and conditions as LinuxCNC does: o1 while [..]"
            );
            return Err(SpanDiagnostic::new(start..start + word.len(), message).help(help));
        }
        self.at += 1;
        self.skip_blanks();
        let from = self.at;
        let number = self.value()?;
        if number.is_none() {
            self.at = start + 1;
        }
        let bytes = self.line.as_bytes();
        let is_number = bytes
            .get(from)
            .is_some_and(|byte| !matches!(byte, b'[' | b'#'));
        let number = number.map(|number| {
            if is_number {
                let number = self.with_decimals(from, number);
                self.with_exponent(start, from, number)
            } else {
                number
            }
        });
        let range = start..self.at;
        if number.is_some() && is_number && self.has_exponent() {
            self.pass(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-'));
            let text = self.line.get(from..self.at).unwrap_or_default();
            let message = message!("{text} may be one number or a number and a word E", text);
            let help = message!("write numbers without an exponent, and a space before E");
            return Err(SpanDiagnostic::new(start..self.at, message).help(help));
        }
        let counts = letter.is_ascii_alphabetic() && !letter.eq_ignore_ascii_case(&b'N');
        if let Some(number) = number.filter(|number| counts && number.abs() > MAX_NUMBER) {
            let letter = char::from(letter);
            let number = format!("{number:e}");
            let message = message!("{letter} is {number}, which is too large", letter, number);
            return Err(SpanDiagnostic::new(range, message));
        }
        Ok(Word {
            letter: letter.to_ascii_uppercase(),
            number,
            range,
        })
    }

    /// Adds the digits after a decimal comma. Digits without a letter can mean nothing else.
    fn with_decimals(&mut self, from: usize, whole: f64) -> f64 {
        let bytes = self.line.as_bytes();
        let has_point = bytes
            .get(from..self.at)
            .is_some_and(|text| text.contains(&b'.'));
        let digits = bytes.get(self.at + 1..).unwrap_or_default();
        let count = digits
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count();
        if has_point || count == 0 || self.peek() != Some(b',') {
            return whole;
        }
        self.at += 1 + count;
        let text = self.line.get(from..self.at).unwrap_or_default();
        text.replace(',', ".").parse().unwrap_or(whole)
    }

    /// Adds an exponent, if it cannot be a word E: it has a sign, and the words of the line are
    /// separated by blanks.
    fn with_exponent(&mut self, start: usize, from: usize, number: f64) -> f64 {
        let bytes = self.line.as_bytes();
        let at = |at: usize| bytes.get(at).copied();
        let is_blank = |byte: u8| byte.is_ascii_whitespace();
        let signed = matches!(at(self.at + 1), Some(b'+' | b'-'));
        let is_apart = start.checked_sub(1).and_then(at).is_some_and(is_blank);
        if !signed || !is_apart || !self.has_exponent() {
            return number;
        }
        let digits = bytes.get(self.at + 2..).unwrap_or_default();
        let count = { digits.iter() }
            .take_while(|byte| byte.is_ascii_digit())
            .count();
        let end = self.at + 2 + count;
        if at(end).is_some_and(|next| !is_blank(next)) {
            return number;
        }
        let text = self.line.get(from..end).unwrap_or_default();
        let Ok(number) = text.replace(',', ".").parse() else {
            return number;
        };
        self.at = end;
        number
    }

    /// Skips a part addressed to a controller, and returns why it is left out.
    fn skip_controller_part(&mut self, sign: char) -> Option<Message> {
        let start = self.at;
        self.at += sign.len_utf8();
        match sign {
            '?' | '!' | '~' => Some(message!("a request to the controller (? ! ~) is left out")),
            '$' if self.peek().is_some_and(|next| next.is_ascii_digit()) => {
                self.pass(|byte| byte.is_ascii_digit());
                Some(message!(
                    "the number of a spindle ($) is left out: there is one tool"
                ))
            }
            _ => {
                self.at = start;
                None
            }
        }
    }

    /// Returns the Fanuc macro keyword at the start of a line.
    fn macro_word(&self) -> Option<&'static str> {
        // Not after an O, whose keywords have the same names.
        if self.at != behind_number(self.line) {
            return None;
        }
        let rest = self.line.as_bytes().get(self.at..)?;
        let begins = |word: &&&str| {
            let own = rest.get(..word.len());
            own.is_some_and(|own| own.eq_ignore_ascii_case(word.as_bytes()))
        };
        let word = ["WHILE", "GOTO", "THEN", "END", "IF", "DO"]
            .iter()
            .find(begins)
            .copied()?;
        let behind = rest.get(word.len()..).unwrap_or_default();
        let next = behind.iter().find(|byte| !byte.is_ascii_whitespace());
        let fits = match word {
            "WHILE" | "IF" => next == Some(&b'['),
            "THEN" => true,
            _ => next.is_some_and(|next| next.is_ascii_digit() || matches!(next, b'#' | b'[')),
        };
        fits.then_some(word)
    }

    /// True if an `e` with whole digits directly follows the number.
    fn has_exponent(&self) -> bool {
        let rest = self.line.as_bytes().get(self.at..).unwrap_or_default();
        let Some((b'e' | b'E', rest)) = rest.split_first() else {
            return false;
        };
        let signed = matches!(rest.first(), Some(b'+' | b'-'));
        let digits = rest.get(usize::from(signed)..).unwrap_or_default();
        let count = digits
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count();
        count > 0 && digits.get(count) != Some(&b'.')
    }

    /// Parses a plain decimal number.
    pub(super) fn number(&mut self) -> Option<f64> {
        let start = self.at;
        let negative = self.peek() == Some(b'-');
        if negative || self.peek() == Some(b'+') {
            self.at += 1;
        }
        let (mut whole, mut digits, mut places, mut point) = (0_u64, 0_u32, 0_usize, false);
        while let Some(byte) = self.peek() {
            match byte {
                b'0'..=b'9' => {
                    // May wrap; numbers with too many digits are parsed again below.
                    whole = whole.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                    digits = digits.saturating_add(1);
                    places += usize::from(point);
                }
                b'.' if !point => point = true,
                _ => break,
            }
            self.at += 1;
        }
        if digits == 0 {
            return None;
        }
        // If integer and power of ten are exact, their quotient is the correctly rounded number.
        // This fast path avoids the general parser for nearly all numbers.
        let exact = digits <= MAX_DIGITS && whole <= 1 << 53;
        if let Some(ten) = POWERS_OF_TEN.get(places).filter(|_| exact) {
            let number = whole as f64 / ten;
            return Some(if negative { -number } else { number });
        }
        self.line.get(start..self.at)?.parse().ok()
    }
}

impl Words<'_> {
    /// Parses an assignment.
    fn set(&mut self) -> Result<Item, SpanDiagnostic> {
        let start = self.at;
        let key = self.key()?;
        self.skip_blanks();
        let is_set = self.peek() == Some(b'=');
        let message = if is_set {
            self.at += 1;
            self.skip_blanks();
            if let Some(value) = self.value()? {
                return Ok(Item::Set(key, value, start..self.at));
            }
            message!("{key} is set without a value", key = key.to_string())
        } else {
            message!(
                "{key} needs a letter before it or = after it",
                key = key.to_string()
            )
        };
        Err(SpanDiagnostic::new(start..self.at, message))
    }
}

impl Iterator for Words<'_> {
    type Item = Result<Item, SpanDiagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        let first = self.begin()?;
        if first.is_ascii_alphabetic() {
            return Some(self.word(first).map(Item::Word));
        }
        if first == b'#' {
            return Some(self.set());
        }
        let start = self.at;
        let sign = self.line.get(start..)?.chars().next()?;
        if let Some(why) = self.skip_controller_part(sign) {
            return Some(Ok(Item::LeftOut(why, start..self.at)));
        }
        self.at = self.line.len();
        let error = match sign {
            '[' | '0'..='9' | '.' | '-' | '+' => {
                SpanDiagnostic::new(start..start + 1, message!("a number has no letter"))
            }
            ',' => {
                let message =
                    message!("a corner that is rounded or cut off (,R ,C ,A) is not supported");
                let help = message!("export the file with the arcs and lines of its corners");
                SpanDiagnostic::new(start..start + 1, message).help(help)
            }
            _ => {
                let range = start..start + sign.len_utf8();
                let sign = format!("{sign:?}");
                SpanDiagnostic::new(range, message!("{sign} is not valid in G-code", sign))
            }
        };
        Some(Err(error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<(char, Option<f64>)> {
        let none = Parameters::none();
        let items = Words::new(line, &none).map(|item| item.expect("a word"));
        let words = items.map(|item| match item {
            Item::Word(word) => (char::from(word.letter), word.number),
            other => panic!("{other:?}"),
        });
        words.collect()
    }

    #[test]
    fn words_may_have_spaces_anywhere_or_none() {
        let expected = [('G', Some(1.0)), ('X', Some(-2.5)), ('Z', Some(0.25))];
        for line in [
            "G1X-2.5Z.25",
            "g01 x-2.50 z+0.25 ; a comment (of any kind)",
            "%G 1 X -2.5(here Y9)Z 0.25*77",
            "G1\tX-002.5\tZ.25\r",
        ] {
            assert_eq!(words(line), expected, "{line}");
        }
        assert_eq!(words("(not closed G1 X2"), []);
        assert_eq!(
            words("((a) b (c (d))) X1 (e) (f ;) Y2").len(),
            2,
            "comments within comments"
        );
        // With an unclosed comment, the first closing parenthesis ends each comment.
        assert_eq!(words("(a (b) X1 (c) Y2").len(), 2);
        let many = "(()".repeat(100_000);
        assert_eq!(words(&many), []);
        assert_eq!(
            words("G28 X Y"),
            [('G', Some(28.0)), ('X', None), ('Y', None)]
        );
        assert_eq!(words("N20"), [('N', Some(20.0))]);
    }

    #[test]
    fn numbers_are_correctly_rounded() {
        for text in [
            "0",
            "-0.0",
            "123.456",
            "0.1",
            "99999999.99999999",
            "3.14159265358979323846264338",
            "0.000000000000000000000000001",
            "9007199254740993",
            "5.",
            ".5",
        ] {
            let [(_, Some(number))] = words(&format!("N{text}"))[..] else {
                panic!("{text}")
            };
            let nearest: f64 = text.parse().unwrap();
            assert_eq!(number.to_bits(), nearest.to_bits(), "{text}");
        }
    }

    #[test]
    fn invalid_word_error_has_its_position() {
        let error = |line: &str| {
            let none = Parameters::none();
            let found = Words::new(line, &none).find_map(Result::err);
            let error = found.expect("a flaw");
            (error.range, error.message)
        };
        assert_eq!(error("X1.2e3").0, 0..6);
        assert_eq!(error("X1E-999 Y2").0, 0..7);
        assert_eq!(error("G1 #1").0, 3..5);
        assert_eq!(error("G1 ü").1, "'ü' is not valid in G-code");
        let forty = "1".repeat(40);
        let long = format!("G1 X{forty}");
        assert_eq!(error(&long).0, 3..44);
        assert_eq!(error("7 G1").1, "a number has no letter");
        // E with a fraction is a separate word, since programs for printers may have no blanks.
        assert_eq!(words("G1X10E0.5").len(), 3);
    }
}
