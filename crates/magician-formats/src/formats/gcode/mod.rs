//! G-code of pens and lasers.
//!
//! Only the syntax is common to all G-code; the meaning is that of the file's dialect. The words are read by a lexer of our
//! own: the `gcode` crate gives numbers in binary32 (coordinates are summed up here), lets an open parenthesis swallow the
//! lines after it, and takes `X1E5` for two words without a sign of it.
//!
//! | words | what becomes of them |
//! |---|---|
//! | G0 | a straight move; within a laser's path a segment without power |
//! | G1 | a segment of a continuous path, for a laser with its power |
//! | G2, G3 with I J K (G90.1: absolute) or R, P turns | arcs of the arm; lines for a laser, for helices, in the planes of G18 and G19, and for what is as flat as the tolerance |
//! | G73, G81 to G83, G85, G86, G89, G98, G99 | holes of a pen: one way down and up each |
//! | G4 P (ms; s where the program has fractions of it or settings of GRBL) or S (s) | a wait, with the laser dark |
//! | G5, G5.1 | curves, as lines within the tolerance |
//! | G17, G18, G19, G20, G21, G90, G91, G90.1, G91.1, G80, G94 | as everywhere |
//! | G54 to G59.3, G10 L2 and L20, G52, G92 to G92.3 | where the zero is, from 0 on |
//! | G53 | the arm's coordinates; of a placed program only up, as the machine's zero is not known |
//! | G28, G30 | left out, but for up (`home` in the options homes) |
//! | M3, M5, S; M106, M107 without extruding | the laser's power |
//! | M4 | that, in proportion to speed: [`Step::feed`](crate::Step::feed) |
//! | M300 S30, S50; M280 S | a servo's pen down and up, at the heights of the options |
//! | F | the speed along lines and arcs, mm/min |
//! | M0, M1, M6, another T | the arm waits for a person, who reads the comment of the line |
//! | M2, M30 | the end |
//!
//! Other M codes, E, T and rotary axes are noted and left out; other G codes that move, or say where things are, are refused.
//!
//! A program may compute: `interpreter` gives its lines in the order in which they are carried out, with the values of parameters
//! and expressions in their words. It is run twice, once for what the whole program tells (`survey`), once for the plan.

mod arc;
mod begin;
mod block;
mod cycle;
mod emit;
mod expression;
mod flow;
mod interpreter;
mod lexer;
mod machine;
mod mill;
mod modes;
mod motion;
mod offsets;
mod oword;
mod parameters;
mod pause;
mod power;
mod servo;
mod settings;
mod start;
mod survey;

use std::ops::Range;

use magician_host::{Act, Remedy};

use super::notes::Notes;
use super::{Arcs, Chords, Content, Dialect, GcodeOptions, Parsed, ReadOptions};
use crate::encoding::{Otherwise, decode};
use crate::{Diagnostic, DiagnosticCode, Origin};

use crate::formats::span::SpanDiagnostic;
use block::Block;
use interpreter::{Interpreter, Program};
use machine::Machine;
use modes::Modes;

use survey::Survey;

/// A program that repeats lines makes no more moves than this.
const MOST_STEPS: usize = 1_000_000;

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    // What is not UTF-8 stands in comments: a guess needs no note.
    let text = decode(bytes, Otherwise::Bytes)?.text;
    let program = Program::new(&text)?;
    let gcode = &options.gcode;
    let interpreter = || Interpreter::new(&program, Modes::new(gcode.begins_at(), gcode.placed));
    let survey = Survey::of(interpreter(), gcode);
    let mut machine = Machine::new(&options.title, gcode, chords, survey)?;
    let mut interpreter = interpreter();
    let mut block = Block::default();
    while let Some((line, stepped)) = interpreter.step(&mut block)? {
        machine.take(&line, stepped, &block)?;
        if program.repeats() && machine.steps() > MOST_STEPS {
            let message = format!("the program makes more than {MOST_STEPS} moves");
            let help = "reduce its repetitions, or export the file without loops";
            let origin = line.origin(&(0..line.text.trim_end().len()));
            return Err(Diagnostic::new(origin, message).help(help));
        }
    }
    let left = interpreter.left();
    let (plan, mut notes) = machine.finish()?;
    notes.extend(interpreter.notes.into_diagnostics());
    if left > 0 {
        let message = format!("{left} lines after the end of the program are left out");
        notes.push(Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut));
    }
    Ok(Parsed {
        content: Content::Plan(plan),
        notes,
    })
}

/// Place in a line of the first sign that is neither a blank nor of the line's number.
fn behind_number(line: &str) -> usize {
    let blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'\x0b';
    let bytes = line.as_bytes();
    // Most lines begin with a word.
    if let Some(b'G' | b'X' | b'Y') = bytes.first() {
        return 0;
    }
    let blanks = |from: usize| {
        let rest = bytes.get(from..).unwrap_or_default();
        from + rest.iter().take_while(|byte| blank(byte)).count()
    };
    let start = blanks(0);
    if !matches!(bytes.get(start), Some(b'n' | b'N')) {
        return start;
    }
    let digits = blanks(start + 1);
    let rest = bytes.get(digits..).unwrap_or_default();
    let number = (rest.iter()).take_while(|byte| byte.is_ascii_digit() || **byte == b'.');
    blanks(digits + number.count())
}

impl SpanDiagnostic {
    pub(super) fn help(mut self, help: &'static str) -> Self {
        self.help = Some(help);
        self
    }

    pub(super) fn remedy(self, act: impl Into<Act>, effect: &'static str) -> Self {
        self.with(Remedy::new(act, effect))
    }

    pub(super) fn with(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}

/// A line and its number.
#[derive(Clone, Copy, Debug)]
struct SourceLine<'t> {
    number: u32,
    text: &'t str,
}

impl SourceLine<'_> {
    /// The origin of some of its bytes.
    fn origin(&self, range: &Range<usize>) -> Origin {
        let count = |range: Range<usize>| {
            let part = self.text.get(range.clone());
            let count = part.map_or(range.len(), |part| part.chars().count());
            u32::try_from(count).unwrap_or(u32::MAX)
        };
        Origin {
            line: self.number,
            column: count(0..range.start).saturating_add(1),
            length: count(range.clone()),
            name: 0,
        }
    }

    fn diagnostic(&self, error: SpanDiagnostic) -> Diagnostic {
        let origin = self.origin(&error.range);
        error.into_diagnostic(origin)
    }
}
