//! Keyboard input from a terminal that may disappear.

use std::fs::File;
use std::io::{self, IsTerminal};
use std::time::Duration;

use ratatui::crossterm::event::{self, Event};

/// Source of keys: stdin if it is a terminal, otherwise the controlling terminal.
pub(crate) struct Keyboard {
    #[cfg_attr(not(unix), expect(dead_code, reason = "only on Unix"))]
    other: Option<File>,
}

/// Result of a wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Waited {
    /// An event of the keyboard or the terminal.
    Came(Event),
    /// Timeout.
    Nothing,
    /// The terminal is gone.
    Gone,
}

impl Keyboard {
    /// Finds the keyboard. Fails if there is no terminal.
    pub(crate) fn find() -> io::Result<Self> {
        let other = if io::stdin().is_terminal() || cfg!(not(unix)) {
            None
        } else {
            Some(File::open("/dev/tty")?)
        };
        Ok(Self { other })
    }

    /// Waits for an event, at most `patience`.
    pub(crate) fn wait(&self, patience: Duration) -> io::Result<Waited> {
        // crossterm may have buffered events, so it is polled before the line. But if the terminal
        // is gone its poll would loop for ever waiting for a byte, so that is checked first.
        if self.line(Duration::ZERO)? == TerminalInput::Gone {
            return Ok(Waited::Gone);
        }
        if event::poll(Duration::ZERO)? {
            return event::read().map(Waited::Came);
        }
        match self.line(patience)? {
            TerminalInput::Gone => Ok(Waited::Gone),
            TerminalInput::Silent => Ok(Waited::Nothing),
            TerminalInput::Ready if event::poll(Duration::ZERO)? => event::read().map(Waited::Came),
            TerminalInput::Ready => Ok(Waited::Nothing),
            TerminalInput::Untold if event::poll(patience)? => event::read().map(Waited::Came),
            TerminalInput::Untold => Ok(Waited::Nothing),
        }
    }

    /// Returns the state of the line, waiting at most `patience`.
    #[cfg(unix)]
    fn line(&self, patience: Duration) -> io::Result<TerminalInput> {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        use rustix::io::Errno;
        use std::os::fd::AsFd;

        let stdin = io::stdin();
        let line = self.other.as_ref().map_or(stdin.as_fd(), AsFd::as_fd);
        let mut lines = [PollFd::new(&line, PollFlags::IN)];
        let patience = Timespec::try_from(patience).map_err(io::Error::other)?;
        match poll(&mut lines, Some(&patience)) {
            Ok(0) => return Ok(TerminalInput::Silent),
            // Interrupted by a signal, such as SIGWINCH. The caller polls again.
            Err(Errno::INTR) => return Ok(TerminalInput::Silent),
            told => told?,
        };
        let [line] = lines;
        let told = line.revents();
        Ok(if told.contains(PollFlags::NVAL) {
            TerminalInput::Untold
        } else if told.intersects(PollFlags::HUP | PollFlags::ERR) {
            TerminalInput::Gone
        } else {
            TerminalInput::Ready
        })
    }

    #[cfg(not(unix))]
    fn line(&self, _: Duration) -> io::Result<TerminalInput> {
        Ok(TerminalInput::Untold)
    }
}

/// State of the terminal's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    not(unix),
    expect(dead_code, reason = "other systems do not report it")
)]
enum TerminalInput {
    Ready,
    Silent,
    Gone,
    /// Unknown: this system does not report it.
    Untold,
}
