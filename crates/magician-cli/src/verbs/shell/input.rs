//! Input of a shell: lines from a terminal or a script, and signals.

use std::io::{self, BufRead, IsTerminal};
use std::sync::mpsc;

use tokio::sync::mpsc as channel;

use super::editor::LineEditor;
use crate::context::Context;
use crate::failure::Failure;
use crate::interrupt::Signal;

/// Input of a shell.
pub(super) enum Input {
    Line(String),
    /// The user at the terminal abandoned the line.
    Abandoned,
    End,
    /// Signal from outside: Ctrl-C in a script, or SIGTERM.
    Signal(Signal),
}

/// Lines, read on a thread of their own so that signals and the connection are handled meanwhile. A
/// line is read only on request, since the previous verb may use the terminal.
pub(super) struct LineReader {
    wanted: mpsc::Sender<()>,
    lines: channel::Receiver<io::Result<Input>>,
    is_requested: bool,
    #[cfg(unix)]
    terminal: Option<rustix::termios::Termios>,
}

impl LineReader {
    /// Opens a script on stdin or, with `typed`, a line editor that completes the words of this
    /// command line.
    pub(super) fn open(typed: Option<clap::Command>) -> Self {
        let (wanted, wishes) = mpsc::channel();
        let (sender, lines) = channel::channel(1);
        std::thread::spawn(move || {
            let mut read = reader(typed);
            while wishes.recv().is_ok() {
                if sender.blocking_send(read()).is_err() {
                    break;
                }
            }
        });
        Self {
            wanted,
            lines,
            is_requested: false,
            #[cfg(unix)]
            terminal: rustix::termios::tcgetattr(io::stdin()).ok(),
        }
    }

    /// Returns the next input.
    pub(super) fn next(&mut self, context: &mut Context) -> Result<Input, Failure> {
        if !self.is_requested {
            self.is_requested = self.wanted.send(()).is_ok();
        }
        let read = context.run_without_arm(async |_, signals| {
            Ok(tokio::select! {
                read = self.lines.recv() => read,
                signal = signals.next() => Some(Ok(Input::Signal(signal))),
            })
        })?;
        match read {
            Some(Ok(Input::Signal(signal))) => Ok(Input::Signal(signal)),
            // The end of a closed terminal is not an end that the user asked for; its SIGHUP may
            // come later.
            None | Some(Ok(Input::End) | Err(_)) if self.is_hung_up() => {
                Ok(Input::Signal(Signal::HangUp))
            }
            Some(Ok(input)) => {
                self.is_requested = false;
                Ok(input)
            }
            Some(Err(error)) => Err(Failure::invalid(format!("stdin cannot be read: {error}"))),
            None => Ok(Input::End),
        }
    }

    /// True if the lines came from a terminal that has been closed.
    fn is_hung_up(&self) -> bool {
        #[cfg(unix)]
        let typed = self.terminal.is_some();
        // A closed Windows console ends its programs by an event instead.
        #[cfg(not(unix))]
        let typed = false;
        typed && !io::stdin().is_terminal()
    }
}

/// Restores the terminal's mode if the shell ends while a line is being typed.
#[cfg(unix)]
impl Drop for LineReader {
    fn drop(&mut self) {
        use rustix::termios::{OptionalActions, tcsetattr};
        if let Some(terminal) = self.terminal.take().filter(|_| self.is_requested) {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &terminal);
        }
    }
}

/// Returns a function that reads one line per call.
fn reader(typed: Option<clap::Command>) -> Box<dyn FnMut() -> io::Result<Input>> {
    if let Some(description) = typed {
        let mut typing = LineEditor::open(description);
        return Box::new(move || match &mut typing {
            Ok(typing) => typing.next(),
            Err(error) => Err(io::Error::new(error.kind(), error.to_string())),
        });
    }
    let mut stdin = io::stdin().lock();
    Box::new(move || {
        let mut line = String::new();
        Ok(match stdin.read_line(&mut line)? {
            0 => Input::End,
            _ => Input::Line(line),
        })
    })
}
