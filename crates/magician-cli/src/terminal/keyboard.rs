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
pub(crate) enum WaitResult {
    /// An event of the keyboard or the terminal.
    Event(Event),
    /// Timeout.
    Timeout,
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
    pub(crate) fn wait(&self, timeout: Duration) -> io::Result<WaitResult> {
        // crossterm may have buffered events, so it is polled before the line. But if the terminal
        // is gone its poll would loop for ever waiting for a byte, so that is checked first.
        if self.line(Duration::ZERO)? == TerminalInput::Gone {
            return Ok(WaitResult::Gone);
        }
        if event::poll(Duration::ZERO)? {
            return event::read().map(WaitResult::Event);
        }
        match self.line(timeout)? {
            TerminalInput::Gone => Ok(WaitResult::Gone),
            TerminalInput::Silent => Ok(WaitResult::Timeout),
            TerminalInput::Ready if event::poll(Duration::ZERO)? => {
                event::read().map(WaitResult::Event)
            }
            TerminalInput::Ready => Ok(WaitResult::Timeout),
            TerminalInput::Unknown if event::poll(timeout)? => event::read().map(WaitResult::Event),
            TerminalInput::Unknown => Ok(WaitResult::Timeout),
        }
    }

    /// Returns the state of the line, waiting at most `patience`.
    #[cfg(unix)]
    fn line(&self, timeout: Duration) -> io::Result<TerminalInput> {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        use rustix::io::Errno;
        use std::os::fd::AsFd;

        let stdin = io::stdin();
        let line = self.other.as_ref().map_or(stdin.as_fd(), AsFd::as_fd);
        let mut lines = [PollFd::new(&line, PollFlags::IN)];
        let timeout = Timespec::try_from(timeout).map_err(io::Error::other)?;
        match poll(&mut lines, Some(&timeout)) {
            Ok(0) => return Ok(TerminalInput::Silent),
            // Interrupted by a signal, such as SIGWINCH. The caller polls again.
            Err(Errno::INTR) => return Ok(TerminalInput::Silent),
            events => events?,
        };
        let [line] = lines;
        let events = line.revents();
        Ok(if events.contains(PollFlags::NVAL) {
            TerminalInput::Unknown
        } else if events.intersects(PollFlags::HUP | PollFlags::ERR) {
            TerminalInput::Gone
        } else {
            TerminalInput::Ready
        })
    }

    #[cfg(not(unix))]
    fn line(&self, _: Duration) -> io::Result<TerminalInput> {
        Ok(TerminalInput::Unknown)
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
    Unknown,
}
