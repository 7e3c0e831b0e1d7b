//! Execution order of a program: parameters, O-words and subprograms (M98) of RS-274, with bounded
//! work.
//!
//! [`Interpreter::step`] returns the lines in the order in which they are executed, with all values
//! computed. It is deterministic, so a program can be run twice: once for a survey, once for the
//! plan. Endless loops are caught by a limit on executed lines.

use magician_host::{Message, Setting, SettingValue, message};

use super::Notes;
use super::block::Block;
use super::modes::Modes;
use super::oword::{Owords, TextPosition, line_at};
use super::parameters::{Parameters, SavedParameters};
use super::{SourceLine, behind_number};
use crate::formats::span::SpanDiagnostic;
use crate::{Diagnostic, DiagnosticCode};

/// Number of lines that a program may execute beyond its own length. A choice above any real
/// drawing, which stops endless loops.
const MAX_REPEATED_LINES: u64 = 300_000;
/// Number of bytes for which a long line counts as one more, so that the limit bounds time and not
/// only lines.
const BYTES_PER_LINE: usize = 25;
/// Largest depth of calls. It stops endless recursion.
pub(super) const MAX_CALL_DEPTH: usize = 100;

/// A parsed program, which can be executed repeatedly.
#[derive(Debug)]
pub(super) struct Program<'t> {
    pub(super) text: &'t str,
    pub(super) owords: Owords,
    /// Largest number of lines to execute.
    allowed: u64,
}

impl<'t> Program<'t> {
    pub(super) fn new(text: &'t str) -> Result<Self, Diagnostic> {
        let lines = text.bytes().filter(|byte| *byte == b'\n').count() + 1;
        let all = lines + text.len() / BYTES_PER_LINE;
        Ok(Self {
            text,
            owords: Owords::of(text)?,
            allowed: MAX_REPEATED_LINES + all as u64,
        })
    }

    /// True if the program may execute a line more than once.
    pub(super) fn repeats(&self) -> bool {
        !(self.owords.all.is_empty() && self.owords.numbered.is_empty())
    }
}

/// An active call.
#[derive(Debug)]
pub(super) struct CallFrame {
    /// Return position.
    back: TextPosition,
    pub(super) of: CallKind,
    /// Remaining rounds of each active `repeat`.
    pub(super) repeats: Vec<(usize, u64)>,
}

#[derive(Debug)]
pub(super) enum CallKind {
    Main,
    Sub(SavedParameters),
    /// A numbered program, and the number of remaining repetitions.
    Numbered(u32, u64),
}

/// Result of executing a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineOutcome {
    /// The block contains its words, to be processed by the machine.
    Words,
    /// Skipped: block delete (`/`) or a controller setting (`$`).
    LeftOut,
    /// Control flow only.
    ControlFlow,
}

#[derive(Debug)]
pub(super) struct Interpreter<'p, 't> {
    pub(super) program: &'p Program<'t>,
    /// Position of the next line.
    pub(super) place: TextPosition,
    /// Main program and active calls.
    pub(super) frames: Vec<CallFrame>,
    pub(super) parameters: Parameters,
    /// Number of lines executed.
    pub(super) done: u64,
    /// True once a word was executed.
    begun: bool,
    ended: bool,
    pub(super) notes: Notes,
}

impl<'p, 't> Interpreter<'p, 't> {
    pub(super) fn new(program: &'p Program<'t>, modes: Modes) -> Self {
        let place = TextPosition {
            number: 1,
            ..TextPosition::default()
        };
        Self {
            program,
            place,
            frames: vec![CallFrame {
                back: place,
                of: CallKind::Main,
                repeats: Vec::new(),
            }],
            parameters: Parameters::new(modes),
            done: 0,
            begun: false,
            ended: false,
            notes: Notes::default(),
        }
    }

    pub(super) fn modes(&self) -> &Modes {
        &self.parameters.modes
    }

    /// Executes the next line as far as parameters and control flow are concerned. `None` at the
    /// end.
    pub(super) fn step(
        &mut self,
        block: &mut Block,
    ) -> Result<Option<(SourceLine<'t>, LineOutcome)>, Diagnostic> {
        if self.ended {
            return Ok(None);
        }
        let here = self.place;
        let Some((line, next)) = line_at(self.program.text, here) else {
            self.ended = true;
            return match self.frames.len() {
                0 | 1 => Ok(None),
                _ => Err(Diagnostic::of_file(message!(
                    "the program ends within a subprogram: M99 is missing"
                ))),
            };
        };
        self.place = TextPosition {
            at: next,
            number: here.number.saturating_add(1),
            oword: here.oword,
        };
        let stepped = self.execute_line(&line, here, block);
        let stepped = stepped.map_err(|error| line.diagnostic(error))?;
        Ok(Some((line, stepped)))
    }

    fn execute_line(
        &mut self,
        line: &SourceLine<'t>,
        here: TextPosition,
        block: &mut Block,
    ) -> Result<LineOutcome, SpanDiagnostic> {
        self.done += 1 + (line.text.len() / BYTES_PER_LINE) as u64;
        if self.done > self.program.allowed {
            let message = message!(
                "the program repeats more than {most} lines: it seems endless",
                most = MAX_REPEATED_LINES
            );
            let help = message!("end its loops, or export the file without loops");
            return Err(SpanDiagnostic::new(0..line.text.trim_end().len(), message).help(help));
        }
        match line.text.as_bytes().get(behind_number(line.text)) {
            Some(b'/' | b'$') => return Ok(LineOutcome::LeftOut),
            Some(b'%') if line.text.trim() == "%" => {
                self.ended = self.begun;
                return Ok(LineOutcome::ControlFlow);
            }
            _ => {}
        }
        self.parameters.line = line.number;
        let owords = &self.program.owords.all;
        if let Some(oword) = owords
            .get(here.oword)
            .filter(|oword| oword.place.at == here.at)
        {
            self.begun = true;
            self.place.oword = here.oword + 1;
            self.execute_oword(oword, here.oword, line)?;
            self.note_unset(line);
            return Ok(LineOutcome::ControlFlow);
        }
        block.fill(line.text, &self.parameters)?;
        self.note_unset(line);
        for (key, value, range) in block.sets.drain(..) {
            let set = self.parameters.set(key, value);
            set.map_err(|message| SpanDiagnostic::new(range, message))?;
        }
        self.begun |= !block.is_empty();
        // Most lines have no codes, so skip the searches below.
        if !block.codes.is_empty() {
            self.subprogram(block, line)?;
            let ends = block.has(b'M', 2) || block.has(b'M', 30);
            self.ended |= ends && !block.is_foreign();
        }
        self.parameters.modes.follow(block);
        Ok(LineOutcome::Words)
    }

    fn note_unset(&mut self, line: &SourceLine<'_>) {
        if let Some(number) = self.parameters.take_unset() {
            let message = message!("#{number} is read before it is set: 0 is used", number);
            let origin = line.origin(&(0..line.text.trim_end().len()));
            self.notes.add(DiagnosticCode::Assumed, origin, message);
        }
    }

    /// Executes M98 and M99.
    fn subprogram(
        &mut self,
        block: &mut Block,
        line: &SourceLine<'_>,
    ) -> Result<(), SpanDiagnostic> {
        if block.remove(b'M', 98) {
            let Some(number) = block.take(b'P') else {
                let message = message!("M98 has no P, the number of the program to call");
                return Err(SpanDiagnostic::new(block.range.clone(), message));
            };
            let times = block.take(b'L').unwrap_or(1.0).max(0.0).floor();
            let programs = &self.program.owords.numbered;
            let found = programs.get(&(number as u32));
            let Some(place) = found.filter(|_| number >= 0.0 && number.fract() == 0.0) else {
                let message = message!(
                    "M98 calls program O{number}, which is not in this file",
                    number
                );
                return Err(
                    SpanDiagnostic::new(block.range.clone(), message).help(called_file_advice())
                );
            };
            if times > 0.0 {
                let of = CallKind::Numbered(number as u32, times as u64 - 1);
                let place = *place;
                self.call(of, block.range.clone())?;
                self.place = self.after(place);
            }
        }
        if block.remove(b'M', 99) {
            self.end_of_subprogram(block, line);
        }
        Ok(())
    }

    fn end_of_subprogram(&mut self, block: &Block, line: &SourceLine<'_>) {
        match self.frames.last_mut() {
            Some(CallFrame {
                of: CallKind::Numbered(number, left),
                ..
            }) if *left > 0 => {
                *left -= 1;
                let place = self.program.owords.numbered.get(number).copied();
                self.place = self.after(place.unwrap_or_default());
            }
            Some(CallFrame {
                of: CallKind::Numbered(..),
                ..
            }) => self.leave(),
            // Outside a numbered program, M99 restarts the main program on a controller.
            _ => {
                self.ended = true;
                let message = message!("M99 would restart the program: it ends there");
                let origin = line.origin(&block.range);
                self.notes
                    .add_with(DiagnosticCode::Assumed, origin, message, |note| {
                        note.remedy((Setting::Loops, SettingValue::Any("N")), "repeats it")
                    });
            }
        }
    }

    pub(super) fn call(
        &mut self,
        of: CallKind,
        range: std::ops::Range<usize>,
    ) -> Result<(), SpanDiagnostic> {
        if self.frames.len() > MAX_CALL_DEPTH {
            let message = message!(
                "subroutines call each other more than {most} deep",
                most = MAX_CALL_DEPTH
            );
            return Err(SpanDiagnostic::new(range, message));
        }
        self.frames.push(CallFrame {
            back: self.place,
            of,
            repeats: Vec::new(),
        });
        self.parameters.level = self.frames.len() - 1;
        Ok(())
    }

    /// Returns from the last call.
    pub(super) fn leave(&mut self) {
        let Some(frame) = self.frames.pop() else {
            return;
        };
        self.place = frame.back;
        if let CallKind::Sub(saved) = frame.of {
            self.parameters.leave(saved);
        }
        self.parameters.level = self.frames.len() - 1;
    }

    /// Returns the position after a line.
    pub(super) fn after(&self, place: TextPosition) -> TextPosition {
        let next = line_at(self.program.text, place).map_or(place.at, |(_, next)| next);
        let owords = &self.program.owords.all;
        let is_one = owords
            .get(place.oword)
            .is_some_and(|oword| oword.place.at == place.at);
        TextPosition {
            at: next,
            number: place.number.saturating_add(1),
            oword: place.oword + usize::from(is_one),
        }
    }

    /// Number of non-empty lines after the end of the program. 0 for programs with subprograms,
    /// which may stand there.
    pub(super) fn left(&self) -> u32 {
        if self.program.repeats() {
            return 0;
        }
        let rest = self.program.text.get(self.place.at..).unwrap_or_default();
        let left = rest.lines().filter(|line| !line.trim().is_empty()).count();
        u32::try_from(left).unwrap_or(u32::MAX)
    }
}

pub(super) fn called_file_advice() -> Message {
    message!("put it into the file: other files are not read")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_bounded_and_long_lines_count_more() {
        let long = format!("o1 while [1]\n#1=[{}1]\no1 endwhile\n", "1+".repeat(10_000));
        for (text, most) in [
            ("o1 while [1]\no1 endwhile\n", 1000),
            ("o1 do\n#1=[#1+1]\no1 while [#1 GE 0]\n", 1000),
            ("o1 repeat [1999999999]\no1 endrepeat\n", 1000),
            (
                "o1 repeat [1999]\no2 repeat [1999]\no2 endrepeat\no1 endrepeat\n",
                1000,
            ),
            ("O1\nM98 P1 L5\nM99\n", 1000),
            (&long, 10),
        ] {
            let mut program = Program::new(text).expect("it is matched");
            program.allowed = 1000;
            let mut interpreter = Interpreter::new(&program, Modes::new(None, false));
            let mut block = Block::default();
            let mut steps = 0;
            let diagnostic = loop {
                match interpreter.step(&mut block) {
                    Ok(Some(_)) => steps += 1,
                    Ok(None) => panic!("{text} ends"),
                    Err(diagnostic) => break diagnostic.to_string(),
                }
            };
            assert!(steps <= most, "{steps} {text:.20}");
            assert!(diagnostic.starts_with("line "), "{diagnostic}");
        }
    }
}
