//! Standard output: buffered, coloured only on a terminal, and quiet when its reader has gone away.

use std::fmt::Display;
use std::io::{self, BufWriter, IsTerminal, Stdout, Write};
use std::mem;

use clap::builder::StyledStr;
use magician_job::report::{Note, with_advice};
use magician_program::{Diagnostic, DiagnosticCode, Origin};
use magician_protocol::visible_lines;
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::json::{json, write_json};
use crate::paint::{Paint, print_stderr};
use crate::saved::{self, RecoveredSettings};
use crate::voice::Command;

/// Plain text as a JSON object.
#[derive(Serialize)]
pub(crate) struct Text {
    text: String,
}

impl From<&StyledStr> for Text {
    fn from(text: &StyledStr) -> Self {
        Self::from(text.to_string())
    }
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self { text }
    }
}

/// Adds notes to a JSON object; any other value is unchanged.
fn with_notes(value: &impl Serialize, notes: Vec<Note>) -> Result<Value, serde_json::Error> {
    // Via text: `serde_json::to_value` would widen `f32` to `f64` and print long decimals.
    let mut value = serde_json::from_str(&json(value))?;
    if let Value::Object(object) = &mut value {
        let told = object.entry("notes").or_insert_with(|| json!([]));
        if let Value::Array(told) = told {
            told.extend(notes.iter().map(|note| json!(note)));
        }
    }
    Ok(value)
}

/// Writer for results.
pub(crate) struct Output {
    to: BufWriter<Stdout>,
    pub(crate) paint: Paint,
    width: Option<usize>,
    /// Notes for the next JSON object.
    notes: Vec<Note>,
}

impl Output {
    pub(crate) fn stdout() -> Self {
        let stdout = io::stdout();
        let width = terminal_size::terminal_size_of(&stdout).map(|(width, _)| width.0.into());
        Self {
            paint: Paint::wanted(&stdout),
            width: width.filter(|_| stdout.is_terminal()),
            to: BufWriter::with_capacity(1 << 16, stdout),
            notes: Vec::new(),
        }
    }

    /// Returns the width for wrapping, in columns: the terminal's, at least 60 since narrower
    /// tables are unreadable; unlimited without a terminal.
    pub(crate) fn width(&self) -> usize {
        self.width.map_or(usize::MAX, |width| width.max(60))
    }

    /// Writes a line, with control characters made visible.
    pub(crate) fn line(&mut self, text: impl Display) -> Result<(), Failure> {
        let text = self.paint.harmless(text);
        Ok(writeln!(self.to, "{text}")?)
    }

    /// Writes a result as one JSON object on a line, with the notes so far.
    pub(crate) fn json(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        match mem::take(&mut self.notes) {
            notes if notes.is_empty() => self.event(value),
            notes => self.event(&with_notes(value, notes)?),
        }
    }

    /// Writes an intermediate JSON object. Notes wait for the result.
    pub(crate) fn event(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        write_json(&mut self.to, value)?;
        self.line("")
    }

    /// Reports settings of an earlier command: as a note to a person now, in the next JSON object
    /// otherwise.
    pub(crate) fn note_settled(&mut self, settled: &RecoveredSettings, json: bool) {
        let Some(text) = saved::note(settled) else {
            return;
        };
        let note = Diagnostic::new(Origin::NONE, text).coded(DiagnosticCode::Speed);
        self.note(&note, json);
    }

    /// Prints a note with its advice; with `json` it is added to the next object instead.
    pub(crate) fn note(&mut self, note: &Diagnostic, json: bool) {
        if json {
            self.notes.extend(Note::all(&Command, [note]))
        } else {
            let label = Paint::for_stderr().note("note:");
            let text = with_advice(&Command, note.message.as_str().to_owned(), note);
            print_stderr(format_args!("{label} {}", visible_lines(&text)));
        }
    }

    /// Prints a note at once, with `json` as a separate object, because a verb that may fail has no
    /// result to carry it.
    pub(crate) fn note_at_once(&mut self, note: &Diagnostic, json: bool) -> Result<(), Failure> {
        if !json {
            self.note(note, json);
            return Ok(());
        }
        for note in Note::all(&Command, [note]) {
            let mut event = json!(note);
            if let Value::Object(fields) = &mut event {
                fields.insert("event".to_owned(), json!("note"));
            }
            self.event(&event)?;
        }
        self.flush()
    }

    /// Writes text that clap has styled.
    pub(crate) fn styled(&mut self, text: &StyledStr) -> Result<(), Failure> {
        if self.paint.is_on() {
            write!(self.to, "{}", text.ansi())?;
        } else {
            write!(self.to, "{text}")?;
        }
        self.flush()
    }

    /// Flushes the buffer.
    pub(crate) fn flush(&mut self) -> Result<(), Failure> {
        Ok(self.to.flush()?)
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.to.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Single-precision numbers keep their shortest form if notes are added.
    #[test]
    fn notes_leave_the_rest_of_an_object_as_it_is() {
        #[derive(Serialize)]
        struct Pose {
            x: f32,
            r: f32,
            index: u64,
            y: f64,
        }
        let pose = Pose {
            x: 259.1039,
            r: -0.000_035_188_45,
            index: u64::MAX,
            y: 0.1 + 0.2,
        };
        let alone = json(&pose);
        let told = json(&with_notes(&pose, Vec::new()).expect("an object"));
        let same = alone.replace('}', ",\"notes\":[]}");
        assert_eq!(told, same);
    }
}
