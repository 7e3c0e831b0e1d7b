//! Reader of G-code for pens and lasers.
//!
//! All G-code shares its syntax, while the meaning of words depends on the dialect. The lexer is
//! our own. The `gcode` crate returns binary32 numbers (coordinates are summed up here), lets an
//! unclosed parenthesis swallow the following lines, and silently splits `X1E5` into two words.
//!
//! | words | result |
//! |---|---|
//! | G0 | straight move; within a laser path a segment without power |
//! | G1 | segment of a continuous path, for a laser with its power |
//! | G2, G3 with I J K (G90.1: absolute) or R, P turns | arcs of the arm; lines for a laser, for helices, in the planes of G18 and G19, and where the arc is flat within the tolerance |
//! | G73, G81 to G83, G85, G86, G89, G98, G99 | holes of a pen: one move down and up each |
//! | G4 P (ms; s if the program has fractions of it or settings of GRBL) or S (s) | wait with the laser off |
//! | G5, G5.1 | curves, as lines within the tolerance |
//! | G17, G18, G19, G20, G21, G90, G91, G90.1, G91.1, G80, G94 | standard meaning |
//! | G54 to G59.3, G10 L2 and L20, G52, G92 to G92.3 | origin, initially 0 |
//! | G53 | the arm's coordinates; in a placed program only a lift, because the machine's origin is unknown |
//! | G28, G30 | left out, except for a lift (the option `home` homes) |
//! | M3, M5, S; M106, M107 without extruding | laser power |
//! | M4 | laser power in proportion to speed: [`Step::feed`](crate::Step::feed) |
//! | M300 S30, S50; M280 S | pen down and up by a servo, at the heights of the options |
//! | F | speed along lines and arcs, mm/min |
//! | M0, M1, M6, another T | pause for a person, with the comment of the line as its message |
//! | M2, M30 | end |
//!
//! Other M codes, E, T and rotary axes are left out with a note. Other G codes that move or define
//! positions are refused.
//!
//! A program may compute. `interpreter` returns its lines in execution order, with parameters and
//! expressions evaluated. The program runs twice: `survey` collects facts that depend on all of it
//! (is it a laser's, what S is full power), then `machine` builds the plan.

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

use magician_host::{Act, Message, Remedy, message};

use super::notes::Notes;
use super::{Arcs, Chords, Content, Dialect, GcodeOptions, Parsed, ReadOptions};
use crate::encoding::{Fallback, decode};
use crate::{Diagnostic, DiagnosticCode, Origin};

use crate::formats::span::SpanDiagnostic;
use block::Block;
use interpreter::{Interpreter, Program};
use machine::Machine;
use modes::Modes;

use survey::Survey;

/// Largest number of moves of a program that repeats lines. It bounds memory.
const MAX_STEPS: usize = 1_000_000;

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    // Invalid UTF-8 occurs only in comments, so a guess needs no note.
    let text = decode(bytes, Fallback::Bytes)?.text;
    let program = Program::new(&text)?;
    let gcode = &options.gcode;
    let interpreter = || Interpreter::new(&program, Modes::new(gcode.begins_at(), gcode.placed));
    let survey = Survey::of(interpreter(), gcode);
    let mut machine = Machine::new(&options.title, gcode, chords, survey)?;
    let mut interpreter = interpreter();
    let mut block = Block::default();
    while let Some((line, stepped)) = interpreter.step(&mut block)? {
        machine.take(&line, stepped, &block)?;
        if program.repeats() && machine.steps() > MAX_STEPS {
            let message = message!("the program makes more than {most} moves", most = MAX_STEPS);
            let help = message!("reduce its repetitions, or export the file without loops");
            let origin = line.origin(&(0..line.text.trim_end().len()));
            return Err(Diagnostic::new(origin, message).help(help));
        }
    }
    let left = interpreter.left();
    let (plan, mut notes) = machine.finish()?;
    notes.extend(interpreter.notes.into_diagnostics());
    if left > 0 {
        let message = message!(
            "{left} lines after the end of the program are left out",
            left
        );
        notes.push(Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut));
    }
    Ok(Parsed {
        content: Content::Plan(plan),
        notes,
    })
}

/// Returns the index of the first character after blanks and the line number.
fn behind_number(line: &str) -> usize {
    let blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'\x0b';
    let bytes = line.as_bytes();
    // Fast path: most lines begin with a word.
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
    pub(super) fn help(mut self, help: Message) -> Self {
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

/// A line with its number.
#[derive(Clone, Copy, Debug)]
struct SourceLine<'t> {
    number: u32,
    text: &'t str,
}

impl SourceLine<'_> {
    /// Returns the origin of a range of its bytes.
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
