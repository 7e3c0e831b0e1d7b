//! Line editor of the shell, with completion and a persistent history.

use std::fs;
use std::io::{self, IsTerminal};
use std::path::PathBuf;

use magician_job::dirs;
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{Behavior, Config, Editor};

use super::complete::CommandCompleter;
use super::input::Input;

const PROMPT: &str = "magician> ";
/// Largest number of lines kept in the history.
const MAX_HISTORY: usize = 1000;

/// Line editor on the terminal.
pub(super) struct LineEditor {
    editor: Editor<CommandCompleter, FileHistory>,
    history: Option<PathBuf>,
}

impl LineEditor {
    /// Opens an editor that completes words of this command line.
    pub(super) fn open(description: clap::Command) -> io::Result<Self> {
        let config = Config::builder()
            .max_history_size(MAX_HISTORY)
            .map_err(plain)?
            .history_ignore_space(true)
            .completion_type(rustyline::CompletionType::List)
            // Pasted lines are executed one by one.
            .bracketed_paste(false)
            .behavior(if io::stdout().is_terminal() {
                Behavior::Stdio
            } else {
                // The output is redirected, but the line is still edited on the terminal.
                Behavior::PreferTerm
            })
            .build();
        let mut editor = Editor::with_config(config).map_err(plain)?;
        editor.set_helper(Some(CommandCompleter::new(description)));
        let history = dirs::state().map(|state| state.join("history"));
        if let Some(path) = &history {
            // Errors are ignored: the shell works without a history.
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
            // The window changed its size: the line starts again.
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
