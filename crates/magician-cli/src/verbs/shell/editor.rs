//! Lines that a person types: with editing, completion, and a history that lasts.

use std::ffi::OsString;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::PathBuf;

use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{Behavior, Config, Editor};

use super::complete::Words;
use super::input::Input;

const PROMPT: &str = "magician> ";
/// Lines of history that are kept.
const KEPT: usize = 1000;

/// A line editor on the terminal.
pub(super) struct Typing {
    editor: Editor<Words, FileHistory>,
    history: Option<PathBuf>,
}

impl Typing {
    pub(super) fn open() -> io::Result<Self> {
        let config = Config::builder()
            .max_history_size(KEPT)
            .map_err(plain)?
            .history_ignore_space(true)
            .completion_type(rustyline::CompletionType::List)
            // Every line of what is pasted is a line to do.
            .bracketed_paste(false)
            .behavior(match io::stdout().is_terminal() {
                true => Behavior::Stdio,
                // The output goes elsewhere; the line is still edited here.
                false => Behavior::PreferTerm,
            })
            .build();
        let mut editor = Editor::with_config(config).map_err(plain)?;
        editor.set_helper(Some(Words::new()));
        let history = place(|name| std::env::var_os(name));
        if let Some(path) = &history {
            // No history, none that can be read, no place for one: a shell works without.
            let _ = path.parent().map(fs::create_dir_all);
            let _ = editor.load_history(path);
        }
        Ok(Self { editor, history })
    }

    /// Reads a line.
    pub(super) fn next(&mut self) -> io::Result<Input> {
        match self.editor.readline(PROMPT) {
            Ok(line) => {
                self.remember(&line);
                Ok(Input::Line(line))
            }
            Err(ReadlineError::Eof) => Ok(Input::End),
            Err(ReadlineError::Interrupted) => Ok(Input::Abandoned),
            // The window changed its size: the line begins anew.
            Err(ReadlineError::Signal(_)) => Ok(Input::Abandoned),
            Err(error) => Err(plain(error)),
        }
    }

    fn remember(&mut self, line: &str) {
        if line.trim().is_empty() || line.to_ascii_lowercase().contains("password") {
            return;
        }
        let new = self.editor.add_history_entry(line).unwrap_or(false);
        if let (true, Some(path)) = (new, &self.history) {
            let _ = self.editor.append_history(path);
        }
    }
}

fn plain(error: ReadlineError) -> io::Error {
    match error {
        ReadlineError::Io(error) => error,
        error => io::Error::other(error.to_string()),
    }
}

/// The file of the history: in the directory for state that outlives a program.
fn place(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|value| !value.is_empty());
    let state = set("XDG_STATE_HOME").map(PathBuf::from);
    let state = state.filter(|path| path.is_absolute());
    let local = || match cfg!(windows) {
        true => set("LOCALAPPDATA").map(PathBuf::from),
        false => set("HOME").map(|home| PathBuf::from(home).join(".local/state")),
    };
    Some(state.or_else(local)?.join("magician").join("history"))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn the_history_has_its_place_or_none() {
        let with = |name: &'static str, value: &'static str| {
            place(move |asked| (asked == name).then(|| value.into()))
        };
        assert_eq!(
            with("XDG_STATE_HOME", "/state"),
            Some("/state/magician/history".into())
        );
        assert_eq!(
            with("HOME", "/home/me"),
            Some("/home/me/.local/state/magician/history".into())
        );
        assert_eq!(with("XDG_STATE_HOME", "relative"), None);
        assert_eq!(with("HOME", ""), None);
    }
}
