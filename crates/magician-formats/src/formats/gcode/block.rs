//! A line of G-code, sorted into codes and numbers by letter.

use std::ops::Range;

use magician_host::{Message, message};

use super::lexer::{Item, Words};
use super::parameters::{Key, Parameters};
use crate::formats::span::SpanDiagnostic;

/// Largest number of codes on a line. A choice above any program.
const MAX_CODES: usize = 16;

/// A G or M code.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Code {
    pub(super) letter: u8,
    /// Ten times its number: 901 is G90.1.
    pub(super) tenths: u32,
    pub(super) range: Range<usize>,
}

impl Code {
    pub(super) fn is(&self, letter: u8, number: u32) -> bool {
        self.letter == letter && self.tenths == number * 10
    }
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (letter, number) = (char::from(self.letter), self.tenths / 10);
        match self.tenths % 10 {
            0 => write!(f, "{letter}{number}"),
            part => write!(f, "{letter}{number}.{part}"),
        }
    }
}

/// M codes followed by free text.
const WITH_TEXT: [u32; 9] = [0, 1, 23, 28, 32, 117, 118, 486, 928];
/// M codes that do not claim an S on their line, so that it remains the laser's power.
const WITHOUT_S: [u32; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 30, 60];

/// A sorted line. It is reused for all lines to avoid allocation.
#[derive(Debug, Default)]
pub(super) struct Block {
    numbers: [f64; 26],
    ranges: [(usize, usize); 26],
    /// Bit set of the letters that have a number.
    given: u32,
    pub(super) codes: Vec<Code>,
    /// First letter without a number.
    pub(super) bare: Option<(char, Range<usize>)>,
    /// Parameters set by the line, with value and place.
    pub(super) sets: Vec<(Key, f64, Range<usize>)>,
    /// Parts left out, with reason and place.
    pub(super) left_out: Vec<(Message, Range<usize>)>,
    /// From the first word to the last.
    pub(super) range: Range<usize>,
}

fn index(letter: u8) -> usize {
    usize::from(letter.wrapping_sub(b'A')) % 26
}

impl Block {
    /// Sorts a line, using the parameter values before it.
    pub(super) fn fill(&mut self, line: &str, values: &Parameters) -> Result<(), SpanDiagnostic> {
        self.given = 0;
        self.codes.clear();
        self.bare = None;
        self.range = 0..0;
        self.sets.clear();
        self.left_out.clear();
        for item in Words::new(line, values) {
            let word = match item? {
                Item::Word(word) => word,
                Item::Set(key, value, range) => {
                    self.sets.push((key, value, range));
                    continue;
                }
                Item::LeftOut(why, range) => {
                    self.left_out.push((why, range));
                    continue;
                }
            };
            if self.range.end == 0 {
                self.range.start = word.range.start;
            }
            self.range.end = word.range.end;
            match (word.letter, word.number) {
                (b'N', _) => {}
                (letter @ (b'G' | b'M'), Some(number)) => {
                    self.push(letter, number, word.range)?;
                    if self.is_followed_by_text() {
                        break;
                    }
                }
                (letter, Some(number)) => self.set(letter, number, &word.range)?,
                (letter, None) if self.bare.is_none() => {
                    self.bare = Some((char::from(letter), word.range));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn push(&mut self, letter: u8, number: f64, range: Range<usize>) -> Result<(), SpanDiagnostic> {
        let tenths = (number * 10.0).round();
        let whole = (number * 10.0 - tenths).abs() < 1e-6;
        if !(whole && (0.0..100_000.0).contains(&tenths)) {
            let letter = char::from(letter);
            return Err(SpanDiagnostic::new(
                range,
                message!("unknown code {letter}{number}", letter, number),
            ));
        }
        if self.codes.len() == MAX_CODES {
            return Err(SpanDiagnostic::new(
                range,
                message!("too many codes on one line"),
            ));
        }
        let tenths = tenths as u32;
        self.codes.push(Code {
            letter,
            tenths,
            range,
        });
        Ok(())
    }

    fn is_followed_by_text(&self) -> bool {
        let last = self.codes.last();
        last.is_some_and(|code| WITH_TEXT.iter().any(|number| code.is(b'M', *number)))
    }

    fn set(&mut self, letter: u8, number: f64, range: &Range<usize>) -> Result<(), SpanDiagnostic> {
        let at = index(letter);
        if self.number(letter).is_some_and(|known| known != number) {
            let letter = char::from(letter);
            let message = message!("{letter} appears twice on one line", letter);
            return Err(SpanDiagnostic::new(range.clone(), message));
        }
        self.given |= 1 << at;
        if let (Some(to), Some(place)) = (self.numbers.get_mut(at), self.ranges.get_mut(at)) {
            (*to, *place) = (number, (range.start, range.end));
        }
        Ok(())
    }

    /// Returns a line with only these numbers, at the place of this one.
    pub(super) fn with_numbers(&self, numbers: &[(u8, f64)]) -> Self {
        let mut block = Self {
            range: self.range.clone(),
            ..Self::default()
        };
        for (letter, number) in numbers {
            let at = index(*letter);
            block.given |= 1 << at;
            if let Some(to) = block.numbers.get_mut(at) {
                *to = *number;
            }
        }
        block.ranges = [(self.range.start, self.range.end); 26];
        block
    }

    /// Removes a code; true if it was present.
    pub(super) fn remove(&mut self, letter: u8, number: u32) -> bool {
        let before = self.codes.len();
        self.codes.retain(|code| !code.is(letter, number));
        self.codes.len() < before
    }

    /// Removes the number of a letter and returns it.
    pub(super) fn take(&mut self, letter: u8) -> Option<f64> {
        let number = self.number(letter);
        self.given &= !(1 << index(letter));
        number
    }

    /// True if the line is empty.
    pub(super) fn is_empty(&self) -> bool {
        self.given == 0 && self.codes.is_empty() && self.bare.is_none()
    }

    /// Returns the number of a letter.
    pub(super) fn number(&self, letter: u8) -> Option<f64> {
        let at = index(letter);
        if self.given & (1 << at) == 0 {
            return None;
        }
        self.numbers.get(at).copied()
    }

    /// Returns the place of a letter's word, or the whole line.
    pub(super) fn range_of(&self, letter: u8) -> Range<usize> {
        let at = index(letter);
        match self.ranges.get(at) {
            Some((start, end)) if self.given & (1 << at) != 0 => *start..*end,
            _ => self.range.clone(),
        }
    }

    /// True if any of these letters has a number.
    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        letters.iter().any(|letter| self.number(*letter).is_some())
    }

    pub(super) fn has(&self, letter: u8, number: u32) -> bool {
        self.codes.iter().any(|code| code.is(letter, number))
    }

    pub(super) fn has_g(&self) -> bool {
        self.codes.iter().any(|code| code.letter == b'G')
    }

    /// Returns the power on this line: an S that does not belong to a pause, a fan or another code.
    pub(super) fn power(&self) -> Option<f64> {
        let own = |code: &Code| match code.letter {
            b'G' => code.is(b'G', 4) || code.is(b'G', 10),
            _ => !WITHOUT_S.iter().any(|number| code.is(b'M', *number)),
        };
        self.number(b'S').filter(|_| !self.codes.iter().any(own))
    }

    /// True if the line belongs to an unknown M code, so that its letters have an unknown meaning.
    pub(super) fn is_foreign(&self) -> bool {
        let foreign = |code: &Code| {
            let known = WITHOUT_S.iter().chain(&[106, 107, 280, 300]);
            !known.clone().any(|number| code.is(b'M', *number))
        };
        !self.has_g() && self.codes.iter().any(foreign)
    }
}
