//! Splitting of HPGL into instructions: two letters and numbers.

use std::ops::Range;

use magician_host::message;

use crate::formats::content::plot::{END_OF_TEXT, ESCAPE, Scanner, is_blank};
use crate::formats::span::SpanDiagnostic;

/// Largest magnitude of a number: HP-GL/2's own limit, 2^23.
const MAX_NUMBER: f64 = 8_388_608.0;

/// An instruction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Instruction {
    /// Letters, in upper case.
    pub(super) name: [u8; 2],
    pub(super) numbers: Vec<f64>,
    /// Non-numeric part: a label, an encoded polyline, a comment.
    pub(super) text: String,
    /// Range of bytes.
    pub(super) range: Range<usize>,
}

impl Instruction {
    pub(super) fn name(&self) -> String {
        self.name.map(char::from).iter().collect()
    }
}

/// Iterator over the instructions of a plot.
#[derive(Debug)]
pub(super) struct Instructions<'t> {
    scan: Scanner<'t>,
    end_of_text: u8,
}

impl<'t> Instructions<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self {
            scan: Scanner::new(text),
            end_of_text: END_OF_TEXT,
        }
    }

    fn instruction(&mut self, first: u8) -> Result<Instruction, SpanDiagnostic> {
        let start = self.scan.at;
        self.scan.at += 1;
        let second = self.scan.peek().filter(u8::is_ascii_alphabetic);
        let Some(second) = second else {
            let letter = char::from(first);
            let message = message!(
                "{letter} is not an instruction: instructions have two letters",
                letter
            );
            return Err(SpanDiagnostic::new(start..self.scan.at, message));
        };
        self.scan.at += 1;
        let name = [first, second].map(|letter| letter.to_ascii_uppercase());
        let mut numbers = Vec::new();
        let mut text = String::new();
        let within = self.scan.at;
        match &name {
            // Labels, including buffered ones and those for the plotter's display.
            b"LB" | b"BL" | b"PB" | b"WD" => {
                let end = self.end_of_text;
                self.scan.skip(|byte| byte != end);
                text = self
                    .scan
                    .text
                    .get(within..self.scan.at)
                    .unwrap_or_default()
                    .to_owned();
                self.scan.skip_one(end);
            }
            b"DT" => self.set_end_of_text(),
            // Symbol drawn at each point, if any.
            b"SM" => {
                self.scan.at += usize::from(self.scan.peek().is_some_and(|sign| sign.is_ascii()));
                text = self
                    .scan
                    .text
                    .get(within..self.scan.at)
                    .unwrap_or_default()
                    .to_owned();
            }
            // Comment, in quotes (HP-GL/2) or without.
            b"CO" => {
                self.scan.skip(is_blank);
                match self.scan.peek() {
                    Some(b'"') => self.numbers(&mut numbers)?,
                    _ => self.scan.skip(|byte| byte != b';'),
                }
            }
            b"PE" => {
                self.scan.skip(|byte| byte != b';' && byte != ESCAPE);
                text = self
                    .scan
                    .text
                    .get(within..self.scan.at)
                    .unwrap_or_default()
                    .to_owned();
            }
            _ => self.numbers(&mut numbers)?,
        }
        let range = start..self.scan.at;
        Ok(Instruction {
            name,
            numbers,
            text,
            range,
        })
    }

    /// Parses an instruction specific to Roland, such as `!PG` or `!VZ10`. Its name is `!` and the
    /// first letter, its text is the whole instruction.
    fn vendor_instruction(&mut self) -> Result<Instruction, SpanDiagnostic> {
        let start = self.scan.at;
        self.scan.at += 1;
        let letter = self.scan.peek().filter(u8::is_ascii_alphabetic);
        let Some(letter) = letter else {
            let message = message!("! has no letters of an instruction behind it");
            return Err(SpanDiagnostic::new(start..self.scan.at, message));
        };
        let mut letters = 2;
        while letters > 0
            && self
                .scan
                .peek()
                .is_some_and(|byte| byte.is_ascii_alphabetic())
        {
            self.scan.at += 1;
            letters -= 1;
        }
        let text = self.scan.text.get(start..self.scan.at).unwrap_or_default();
        let mut numbers = Vec::new();
        self.numbers(&mut numbers)?;
        Ok(Instruction {
            name: [b'!', letter.to_ascii_uppercase()],
            numbers,
            text: text.to_ascii_uppercase(),
            range: start..self.scan.at,
        })
    }

    /// Parses `DT` and the new terminator of labels; `DT;` restores the default.
    fn set_end_of_text(&mut self) {
        self.end_of_text = match self.scan.peek() {
            Some(b';') | None => END_OF_TEXT,
            Some(sign) => {
                // A mode may follow the terminator.
                self.scan.skip(|byte| byte != b';');
                sign
            }
        };
    }

    fn numbers(&mut self, numbers: &mut Vec<f64>) -> Result<(), SpanDiagnostic> {
        loop {
            self.scan.skip(|byte| byte == b',' || is_blank(byte));
            if self.scan.peek() == Some(b'"') {
                // A quoted comment or title.
                self.scan.at += 1;
                self.scan.skip(|byte| byte != b'"');
                self.scan.skip_one(b'"');
                continue;
            }
            let start = self.scan.at;
            let sign = |byte| byte == b'-' || byte == b'+';
            if !self
                .scan
                .peek()
                .is_some_and(|byte| byte.is_ascii_digit() || sign(byte) || byte == b'.')
            {
                return Ok(());
            }
            self.scan.at += usize::from(self.scan.peek().is_some_and(sign));
            self.scan.skip(|byte| byte.is_ascii_digit());
            self.scan.skip_one(b'.');
            self.scan.skip(|byte| byte.is_ascii_digit());
            let text = self.scan.text.get(start..self.scan.at).unwrap_or_default();
            match text.parse::<f64>() {
                Ok(number) if number.abs() <= MAX_NUMBER => numbers.push(number),
                Ok(_) => {
                    let message = message!("a number is beyond {limit}", limit = MAX_NUMBER);
                    return Err(SpanDiagnostic::new(start..self.scan.at, message));
                }
                Err(_) => {
                    return Err(SpanDiagnostic::new(
                        start..self.scan.at,
                        message!("this is not a number"),
                    ));
                }
            }
        }
    }
}

impl Iterator for Instructions<'_> {
    type Item = Result<Instruction, SpanDiagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        let first = self.scan.begin()?;
        if first.is_ascii_alphabetic() {
            return Some(self.instruction(first));
        }
        if first == b'!' {
            return Some(self.vendor_instruction());
        }
        let start = self.scan.at;
        let sign = self.scan.text.get(start..)?.chars().next()?;
        self.scan.at = self.scan.text.len();
        let range = start..start + sign.len_utf8();
        let sign = format!("{sign:?}");
        let message = message!("{sign} does not begin an instruction", sign);
        Some(Err(SpanDiagnostic::new(range, message)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<(String, Vec<f64>)> {
        let all = Instructions::new(text).map(|one| one.expect("an instruction"));
        all.map(|one| (one.name(), one.numbers)).collect()
    }

    #[test]
    fn separators_may_be_anything_or_nothing() {
        let expected = [
            ("PU".to_owned(), vec![1600.0, 2600.0]),
            ("PD".to_owned(), vec![-5.0, 0.5]),
        ];
        for text in [
            "PU1600 2600;PD-5 .5;",
            "pu 1600,2600pd-5,0.5",
            "PU1600, 2600\r\nPD -5+0.5",
            "\u{1b}.(\u{1b}.I81;;17:\u{1b}%0BPU1600 2600;LBPD1 2\u{3}PD-5.0 .5",
            "\u{1b}E\u{1b}%-12345X@PJL ENTER LANGUAGE=HPGL2\nPU1600 2600PD-5 .5\u{1b}%0A",
            "DT*;LBtext*PU1600 2600DT;PD-5 .5",
            "\u{1b}.Y\u{1b}.@;0:\u{1b}.M500;;;10;:\u{1b}.N;19:CO\"PD3 4;\"CO Circles, PD3 4;PU1600 2600:MG \"PD\";PD-5 .5",
            // Printer data: text printed next to the plot is not part of it.
            "\u{1b}E\u{1b}&l1o3A\u{1b}*p0x0YHello; \u{1b}%0BPU1600 2600\u{1b}%1A PD7 7;\u{1b}%-1BPD-5 .5\u{1b}%0ABye\u{1b}E",
        ] {
            let mut found = all(text);
            found.retain(|(name, _)| !matches!(name.as_str(), "LB" | "DT" | "CO" | "MG"));
            assert_eq!(found, expected, "{text:?}");
        }
    }

    #[test]
    fn invalid_instruction_error_has_its_position() {
        let error = |text: &str| {
            let found = Instructions::new(text).find_map(Result::err);
            found.expect("a flaw").range
        };
        assert_eq!(error("IN;1 2"), 3..4);
        assert_eq!(error("IN;P1"), 3..4);
        assert_eq!(error("PU-;"), 2..3);
        assert_eq!(error("PU1,99999999"), 4..12);
        assert_eq!(error("PU1 2;ü"), 6..8);
    }
}
