//! Standard output: buffered, painted only on a terminal, quiet when nobody reads it.

use std::fmt::{self, Display};
use std::io::{self, BufWriter, IsTerminal, Stdout, Write};
use std::mem;

use clap::builder::StyledStr;
use magician_program::{NoteCode, Origin, Problem};
use magician_protocol::{is_deceptive, visible_lines};
use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::saved::{self, Settled};
use crate::verbs::job::Note;

/// Whether this is a terminal that obeys escape sequences. Windows consoles do when told to, which this does.
pub(crate) fn obeys(to: &impl IsTerminal) -> bool {
    #[cfg(windows)]
    let obeys = ratatui::crossterm::ansi_support::supports_ansi;
    #[cfg(not(windows))]
    let obeys = || true;
    to.is_terminal() && obeys()
}

/// Colours, or none: only on a terminal that can, and not with `NO_COLOR`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    on: bool,
}

/// Columns of the terminal at stderr, within what can be read at a glance; elsewhere the most of it.
pub(crate) fn width_of_stderr() -> usize {
    let width = terminal_size::terminal_size_of(io::stderr());
    let width = width.filter(|_| io::stderr().is_terminal());
    width.map_or(100, |(width, _)| usize::from(width.0).clamp(60, 100))
}

/// Whether stderr shows more signs than ASCII: a terminal that is not dumb, in a place where text is UTF-8.
pub(crate) fn draws_on_stderr() -> bool {
    let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    let place = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .find_map(variable);
    let place = place.unwrap_or_default().to_ascii_lowercase();
    let utf8 = cfg!(windows) || place.contains("utf-8") || place.contains("utf8");
    let dumb = variable("TERM").is_some_and(|term| term == "dumb");
    obeys(&io::stderr()) && utf8 && !dumb
}

/// The colours that there are.
const ERROR: &str = "1;31";
const GOOD: &str = "32";
const NAME: &str = "1";
const DIM: &str = "2";
const NOTE: &str = "33";
const HEADING: &str = "1;4";
/// All that this program says to a terminal in a line of text.
const SEQUENCES: [&str; 7] = [ERROR, GOOD, NAME, DIM, NOTE, HEADING, "0"];

/// A text in a colour.
struct Painted<T> {
    text: T,
    code: Option<&'static str>,
}

impl<T: Display> Display for Painted<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.code {
            Some(code) => {
                write!(f, "\x1b[{code}m")?;
                self.text.fmt(f)?;
                f.write_str("\x1b[0m")
            }
            None => self.text.fmt(f),
        }
    }
}

impl Paint {
    fn wanted(to: &impl IsTerminal) -> Self {
        let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        Self {
            on: obeys(to) && !set("NO_COLOR") && !dumb,
        }
    }

    /// The text as a terminal may be given it: it obeys our own colours and nothing else, whatever an arm is called and
    /// whatever stands in a file. Every line for people goes through here.
    pub(crate) fn harmless(self, text: impl Display) -> String {
        let text = text.to_string();
        if !text.contains(is_deceptive) {
            return text;
        }
        let mut pieces = text.split('\x1b');
        let mut to = visible_lines(pieces.next().unwrap_or_default()).to_string();
        for piece in pieces {
            let ours = piece
                .strip_prefix('[')
                .and_then(|code| code.split_once('m'));
            match ours.filter(|(code, _)| self.on && SEQUENCES.contains(code)) {
                Some((code, rest)) => to += &format!("\x1b[{code}m{}", visible_lines(rest)),
                None => to += &format!("{}{}", visible_lines('\x1b'), visible_lines(piece)),
            }
        }
        to
    }

    /// Whether there are colours.
    pub(crate) fn is_on(self) -> bool {
        self.on
    }

    pub(crate) fn for_stderr() -> Self {
        Self::wanted(&io::stderr())
    }

    fn with<T: Display>(self, code: &'static str, text: T) -> impl Display {
        Painted {
            text,
            code: self.on.then_some(code),
        }
    }

    /// What an error begins with, and what is wrong in a list.
    pub(crate) fn error(self, text: impl Display) -> impl Display {
        self.with(ERROR, text)
    }

    /// What is as it should be.
    pub(crate) fn good(self, text: impl Display) -> impl Display {
        self.with(GOOD, text)
    }

    /// What a list is about.
    pub(crate) fn name(self, text: impl Display) -> impl Display {
        self.with(NAME, text)
    }

    /// What only accompanies.
    pub(crate) fn dim(self, text: impl Display) -> impl Display {
        self.with(DIM, text)
    }

    /// What deserves a look.
    pub(crate) fn note(self, text: impl Display) -> impl Display {
        self.with(NOTE, text)
    }

    /// A heading.
    pub(crate) fn heading(self, text: impl Display) -> impl Display {
        self.with(HEADING, text)
    }
}

/// Writes a line for people to stderr. A stderr that cannot be written to is no reason to stop.
pub(crate) fn tell(text: impl Display) {
    let text = Paint::for_stderr().harmless(text);
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Writes a value as JSON that a terminal obeys nothing of: JSON itself escapes C0 alone.
pub(crate) fn write_json(to: impl Write, value: &impl Serialize) -> serde_json::Result<()> {
    value.serialize(&mut serde_json::Serializer::with_formatter(to, Harmless))
}

/// The same as text.
pub(crate) fn json(value: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    // Neither a string nor a number of ours has no form in JSON.
    let _ = write_json(&mut bytes, value);
    String::from_utf8(bytes).unwrap_or_default()
}

struct Harmless;

impl Formatter for Harmless {
    fn write_string_fragment<W: Write + ?Sized>(
        &mut self,
        to: &mut W,
        text: &str,
    ) -> io::Result<()> {
        let mut rest = text;
        while let Some(at) = rest.find(is_deceptive) {
            let (plain, from) = rest.split_at(at);
            CompactFormatter.write_string_fragment(to, plain)?;
            let mut signs = from.chars();
            for unit in signs.next().unwrap_or_default().encode_utf16(&mut [0; 2]) {
                write!(to, "\\u{unit:04x}")?;
            }
            rest = signs.as_str();
        }
        CompactFormatter.write_string_fragment(to, rest)
    }
}

/// A text as JSON has it.
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

/// Adds notes to an object; any other value stays unchanged.
fn with_notes(value: &impl Serialize, notes: Vec<Note>) -> Result<Value, serde_json::Error> {
    // By way of the text: a value in memory makes long decimals of single-precision numbers.
    let mut value = serde_json::from_str(&json(value))?;
    if let Value::Object(object) = &mut value {
        let told = object.entry("notes").or_insert_with(|| json!([]));
        if let Value::Array(told) = told {
            told.extend(notes.iter().map(|note| json!(note)));
        }
    }
    Ok(value)
}

/// Where results go.
pub(crate) struct Output {
    to: BufWriter<Stdout>,
    pub(crate) paint: Paint,
    width: Option<usize>,
    /// What the next object in JSON says besides.
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

    /// Columns to keep within: the terminal's, at least 60; without a terminal no bound.
    pub(crate) fn width(&self) -> usize {
        self.width.map_or(usize::MAX, |width| width.max(60))
    }

    /// Writes a line.
    pub(crate) fn line(&mut self, text: impl Display) -> Result<(), Failure> {
        let text = self.paint.harmless(text);
        Ok(writeln!(self.to, "{text}")?)
    }

    /// Writes one object on a line.
    pub(crate) fn json(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        match mem::take(&mut self.notes) {
            notes if notes.is_empty() => self.event(value),
            notes => self.event(&with_notes(value, notes)?),
        }
    }

    /// Writes one object of those that come while the verb is at it: notes are for its result.
    pub(crate) fn event(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        write_json(&mut self.to, value)?;
        self.line("")
    }

    /// A person is told now; who reads JSON finds it in the next object.
    pub(crate) fn settled(&mut self, settled: &Settled, json: bool) {
        let Some(text) = saved::note(settled) else {
            return;
        };
        let note = Problem::new(Origin::NONE, text).coded(NoteCode::Speed);
        match json {
            true => self.notes.extend(Note::all([&note])),
            false => {
                let label = Paint::for_stderr().note("note:");
                tell(format_args!("{label} {}", visible_lines(&note.message)));
            }
        }
    }

    /// Writes text that clap has styled.
    pub(crate) fn styled(&mut self, text: &StyledStr) -> Result<(), Failure> {
        match self.paint.on {
            true => write!(self.to, "{}", text.ansi())?,
            false => write!(self.to, "{text}")?,
        }
        self.flush()
    }

    /// Hands on what is buffered.
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

    const HOSTILE: &str = "\x1b]0;mine\x07 \x1b[31mred \u{9b}2J \x7f \u{202e}gnp.exe\r";

    #[test]
    fn a_terminal_obeys_no_more_than_our_own_colours() {
        let shown =
            |paint: Paint| paint.harmless(format_args!("{} is {HOSTILE}", paint.name("arm")));
        let escaped = r"\u{1b}]0;mine\u{7} \u{1b}[31mred \u{9b}2J \u{7f} \u{202e}gnp.exe\u{d}";
        assert_eq!(shown(Paint { on: false }), format!("arm is {escaped}"));
        assert_eq!(
            shown(Paint { on: true }),
            format!("\x1b[1marm\x1b[0m is {escaped}")
        );
        // Without colours not even ours are obeyed: nobody has sent them.
        let ours = Paint { on: false }.harmless("\x1b[1mbold");
        assert_eq!(ours, r"\u{1b}[1mbold");
    }

    /// Numbers of the wire have their shortest form beside notes too.
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

    #[test]
    fn json_escapes_what_a_terminal_obeys_and_reads_back_the_same() {
        let value = serde_json::json!({"name": HOSTILE, "tag": "\u{e0041}\n\"ä\\"});
        let text = json(&value);
        assert!(!text.contains(is_deceptive), "{text:?}");
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            value
        );
    }
}
