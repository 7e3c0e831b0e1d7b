//! Control flow by O-words: branches, loops and subroutines.

use magician_host::message;

use super::SourceLine;
use super::interpreter::{CallFrame, CallKind, Interpreter, MAX_CALL_DEPTH, called_file_advice};
use super::lexer::Words;
use super::oword::{Keyword, Label, Oword, TextPosition, line_at};
use crate::formats::span::SpanDiagnostic;

/// Largest number of arguments of a call: RS-274 of LinuxCNC has #1 to #30.
const MAX_ARGUMENTS: usize = 30;

impl<'p, 't> Interpreter<'p, 't> {
    /// Returns the position after an O-word.
    fn after_oword(&self, at: usize) -> TextPosition {
        let oword = self.program.owords.all.get(at);
        oword.map_or(self.place, |oword| self.after(oword.place))
    }

    /// Executes an O-word.
    pub(super) fn execute_oword(
        &mut self,
        oword: &'p Oword,
        own: usize,
        line: &SourceLine<'t>,
    ) -> Result<(), SpanDiagnostic> {
        let all = &self.program.owords.all;
        match oword.keyword {
            Keyword::Sub => self.place = self.after_oword(oword.other),
            Keyword::Call => return self.call_sub(oword, line),
            Keyword::EndSub | Keyword::Return => {
                let value = self.optional(oword, line)?;
                if let Some(CallFrame {
                    of: CallKind::Sub(_),
                    ..
                }) = self.frames.last()
                {
                    self.leave();
                    self.parameters.value = value;
                } else {
                    let label = oword.label.to_string();
                    let message = message!("{label} returns, but it was not called", label);
                    return Err(SpanDiagnostic::new(0..oword.rest, message));
                }
            }
            Keyword::If => self.branch(own, line)?,
            // Execution reaches these lines only at the end of the branch before them, so skip to
            // the end.
            Keyword::ElseIf | Keyword::Else => {
                let mut end = own;
                while all[end].keyword != Keyword::EndIf {
                    end = all[end].other;
                    self.done += 1;
                }
                self.place = self.after_oword(end);
            }
            Keyword::While => {
                if self.condition(oword, line)? == 0.0 {
                    self.place = self.after_oword(oword.other);
                }
            }
            Keyword::EndWhile => self.place = all[oword.other].place,
            Keyword::DoWhile => {
                if self.condition(oword, line)? != 0.0 {
                    self.place = self.after_oword(oword.other);
                }
            }
            Keyword::Repeat => {
                let times = self.condition(oword, line)?.round().max(0.0) as u64;
                if times == 0 {
                    self.place = self.after_oword(oword.other);
                } else if let Some(frame) = self.frames.last_mut() {
                    frame.repeats.retain(|(begin, _)| *begin != own);
                    frame.repeats.push((own, times));
                }
            }
            Keyword::EndRepeat => self.repeat(oword.other),
            Keyword::Break => {
                self.place = self.after_oword(all[oword.other].other);
            }
            Keyword::Continue => match all[oword.other].keyword {
                Keyword::Repeat => self.repeat(oword.other),
                Keyword::While => self.place = all[oword.other].place,
                // In `do .. while` the condition at the end decides, so go on there.
                _ => self.place = all[all[oword.other].other].place,
            },
            Keyword::Do | Keyword::EndIf => {}
        }
        Ok(())
    }

    /// Continues a `repeat` if rounds are left, else leaves it.
    fn repeat(&mut self, begin: usize) {
        let frame = self.frames.last_mut();
        let mut counts = frame.into_iter().flat_map(|frame| &mut frame.repeats);
        let again = match counts.find(|(own, _)| *own == begin) {
            Some((_, left)) if *left > 1 => {
                *left -= 1;
                true
            }
            _ => false,
        };
        let end = self.program.owords.all[begin].other;
        self.place = self.after_oword(if again { begin } else { end });
    }

    /// Enters the first branch of an `if` whose condition holds.
    fn branch(&mut self, begin: usize, line: &SourceLine<'t>) -> Result<(), SpanDiagnostic> {
        let all = &self.program.owords.all;
        let mut at = begin;
        loop {
            let oword = &all[at];
            let holds = match oword.keyword {
                Keyword::If => self.condition(oword, line)? != 0.0,
                Keyword::ElseIf => {
                    let Some((line, _)) = line_at(self.program.text, oword.place) else {
                        return Ok(());
                    };
                    self.done += 1;
                    self.condition(oword, &line)? != 0.0
                }
                _ => true,
            };
            if holds {
                self.place = self.after_oword(at);
                return Ok(());
            }
            at = oword.other;
        }
    }

    fn call_sub(&mut self, oword: &Oword, line: &SourceLine<'t>) -> Result<(), SpanDiagnostic> {
        let label = match oword.label {
            Label::Computed => self.computed(oword, line)?,
            ref known => known.clone(),
        };
        let mut words = Words::new(line.text, &self.parameters);
        words.at = oword.rest;
        let mut arguments = Vec::new();
        while let Some(byte) = words.begin() {
            if byte != b'[' || arguments.len() == MAX_ARGUMENTS {
                let message = message!(
                    "call takes up to {most} values in brackets, as in o100 call [1] [#2]",
                    most = MAX_ARGUMENTS
                );
                return Err(SpanDiagnostic::new(words.at..words.at + 1, message));
            }
            arguments.push(words.bracket(0)?);
        }
        let Some(sub) = self.program.owords.sub(&label) else {
            let message = message!(
                "{label} is called, but this file has no such subroutine",
                label = label.to_string()
            );
            return Err(SpanDiagnostic::new(0..oword.rest, message).help(called_file_advice()));
        };
        if self.frames.len() > MAX_CALL_DEPTH {
            let message = message!(
                "subroutines call each other more than {most} deep",
                most = MAX_CALL_DEPTH
            );
            return Err(SpanDiagnostic::new(0..oword.rest, message));
        }
        let saved = self.parameters.enter(&arguments);
        self.call(CallKind::Sub(saved), 0..oword.rest)?;
        self.place = self.after_oword(sub);
        Ok(())
    }

    fn computed(&self, oword: &Oword, line: &SourceLine<'t>) -> Result<Label, SpanDiagnostic> {
        let mut words = Words::new(line.text, &self.parameters);
        words.pass(|byte| !matches!(byte, b'[' | b'#'));
        let number = words.value()?.unwrap_or(-1.0);
        match number {
            number if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) => {
                Ok(Label::Number(number as u32))
            }
            number => {
                let message = message!("unknown subroutine o{number}", number);
                Err(SpanDiagnostic::new(0..oword.rest, message))
            }
        }
    }

    /// Evaluates the mandatory value of an O-word.
    fn condition(&self, oword: &Oword, line: &SourceLine<'_>) -> Result<f64, SpanDiagnostic> {
        self.optional(oword, line)?.ok_or_else(|| {
            let label = oword.label.to_string();
            let message = message!("{label} has no value in brackets", label);
            SpanDiagnostic::new(0..oword.rest, message)
        })
    }

    fn optional(
        &self,
        oword: &Oword,
        line: &SourceLine<'_>,
    ) -> Result<Option<f64>, SpanDiagnostic> {
        let mut words = Words::new(line.text, &self.parameters);
        words.at = oword.rest;
        let value = match words.begin() {
            None => return Ok(None),
            Some(b'[') => words.bracket(0)?,
            Some(_) => words.value()?.unwrap_or_default(),
        };
        match words.begin() {
            None => Ok(Some(value)),
            Some(_) => Err(SpanDiagnostic::new(
                words.at..line.text.trim_end().len(),
                message!("unexpected text after the value of an O-word"),
            )),
        }
    }
}
