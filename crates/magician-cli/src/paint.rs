//! Colours on terminals that support them, and protection of the terminal from control characters
//! in names and files.

use std::fmt::{self, Display};
use std::io::{self, IsTerminal, Write};

use magician_protocol::{is_deceptive, visible_lines};

/// True if this is a terminal that interprets escape sequences. On Windows this enables them on the
/// console.
pub(crate) fn is_terminal_with_escapes(to: &impl IsTerminal) -> bool {
    #[cfg(windows)]
    let interprets_escapes = ratatui::crossterm::ansi_support::supports_ansi;
    #[cfg(not(windows))]
    let interprets_escapes = || true;
    to.is_terminal() && interprets_escapes()
}

/// Colours, or their absence: enabled only on a terminal that supports them and without `NO_COLOR`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    on: bool,
}

/// Returns the width for text on stderr, in columns: the terminal's, but 60 to 100 for readability;
/// 100 elsewhere.
pub(crate) fn width_of_stderr() -> usize {
    let width = terminal_size::terminal_size_of(io::stderr());
    let width = width.filter(|_| io::stderr().is_terminal());
    width.map_or(100, |(width, _)| usize::from(width.0).clamp(60, 100))
}

/// True if stderr is a terminal other than a dumb one, in a UTF-8 locale, so that box-drawing
/// characters can be used.
pub(crate) fn draws_on_stderr() -> bool {
    let variable = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    let place = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .find_map(variable);
    let place = place.unwrap_or_default().to_ascii_lowercase();
    let utf8 = cfg!(windows) || place.contains("utf-8") || place.contains("utf8");
    let dumb = variable("TERM").is_some_and(|term| term == "dumb");
    is_terminal_with_escapes(&io::stderr()) && utf8 && !dumb
}

/// Colours, as parameters of the SGR escape sequence.
const ERROR: &str = "1;31";
const GOOD: &str = "32";
const NAME: &str = "1";
const DIM: &str = "2";
const NOTE: &str = "33";
const HEADING: &str = "1;4";
/// Only escape sequences that this program writes to a terminal in a line of text.
const SEQUENCES: [&str; 7] = [ERROR, GOOD, NAME, DIM, NOTE, HEADING, "0"];

/// Text in a colour.
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
    pub(crate) fn wanted(to: &impl IsTerminal) -> Self {
        let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        Self {
            on: is_terminal_with_escapes(to) && !set("NO_COLOR") && !dumb,
        }
    }

    /// Returns the text with all control characters made visible but our own colours, so that a
    /// terminal obeys nothing from an arm's name or a file. Every line for people passes through
    /// here.
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

    /// True if colours are enabled.
    pub(crate) fn is_on(self) -> bool {
        self.on
    }

    /// Returns the paint without colours.
    pub(crate) const fn plain() -> Self {
        Self { on: false }
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

    /// Paints the word that introduces an error, and failed entries of a list.
    pub(crate) fn error(self, text: impl Display) -> impl Display {
        self.with(ERROR, text)
    }

    /// Paints entries that are in order.
    pub(crate) fn good(self, text: impl Display) -> impl Display {
        self.with(GOOD, text)
    }

    /// Paints the subject of a list.
    pub(crate) fn name(self, text: impl Display) -> impl Display {
        self.with(NAME, text)
    }

    /// Paints text of secondary importance.
    pub(crate) fn dim(self, text: impl Display) -> impl Display {
        self.with(DIM, text)
    }

    /// Paints text that needs attention.
    pub(crate) fn note(self, text: impl Display) -> impl Display {
        self.with(NOTE, text)
    }

    /// Paints a heading.
    pub(crate) fn heading(self, text: impl Display) -> impl Display {
        self.with(HEADING, text)
    }
}

/// Writes a line for people to stderr. An unwritable stderr is ignored.
pub(crate) fn print_stderr(text: impl Display) {
    let text = Paint::for_stderr().harmless(text);
    let _ = writeln!(io::stderr().lock(), "{text}");
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
        // Without colours our own sequences do not occur, so they count as foreign and are shown as
        // text.
        let ours = Paint { on: false }.harmless("\x1b[1mbold");
        assert_eq!(ours, r"\u{1b}[1mbold");
    }
}
