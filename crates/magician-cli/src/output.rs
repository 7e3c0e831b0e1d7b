//! Standard output: buffered, painted only on a terminal, quiet when nobody reads it.

use std::fmt::{self, Display};
use std::io::{self, BufWriter, IsTerminal, Stdout, Write};

use clap::builder::StyledStr;
use serde::Serialize;

use crate::failure::Failure;

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
        self.with("1;31", text)
    }

    /// What is as it should be.
    pub(crate) fn good(self, text: impl Display) -> impl Display {
        self.with("32", text)
    }

    /// What a list is about.
    pub(crate) fn name(self, text: impl Display) -> impl Display {
        self.with("1", text)
    }

    /// What only accompanies.
    pub(crate) fn dim(self, text: impl Display) -> impl Display {
        self.with("2", text)
    }

    /// What deserves a look.
    pub(crate) fn note(self, text: impl Display) -> impl Display {
        self.with("33", text)
    }

    /// A heading.
    pub(crate) fn heading(self, text: impl Display) -> impl Display {
        self.with("1;4", text)
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

/// Where results go.
pub(crate) struct Output {
    to: BufWriter<Stdout>,
    pub(crate) paint: Paint,
    width: Option<usize>,
}

impl Output {
    pub(crate) fn stdout() -> Self {
        let stdout = io::stdout();
        let width = terminal_size::terminal_size_of(&stdout).map(|(width, _)| width.0.into());
        Self {
            paint: Paint::wanted(&stdout),
            width: width.filter(|_| stdout.is_terminal()),
            to: BufWriter::with_capacity(1 << 16, stdout),
        }
    }

    /// Columns to keep within: the terminal's, at least 60; without a terminal no bound.
    pub(crate) fn width(&self) -> usize {
        self.width.map_or(usize::MAX, |width| width.max(60))
    }

    /// Writes a line.
    pub(crate) fn line(&mut self, text: impl Display) -> Result<(), Failure> {
        Ok(writeln!(self.to, "{text}")?)
    }

    /// Writes one object on a line.
    pub(crate) fn json(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        serde_json::to_writer(&mut self.to, value)?;
        self.line("")
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
