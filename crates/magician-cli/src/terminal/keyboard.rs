//! Waiting for keys, on a terminal that may go away.

use std::fs::File;
use std::io::{self, IsTerminal};
use std::time::Duration;

use ratatui::crossterm::event::{self, Event};

/// Where keys come from: stdin if it is a terminal, else the terminal that controls this program.
pub(crate) struct Keyboard {
    #[cfg_attr(not(unix), expect(dead_code, reason = "there is no other"))]
    other: Option<File>,
}

/// What came of waiting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Waited {
    /// Something on the keyboard, or to do with the terminal.
    Came(Event),
    /// Nothing, for as long as was waited.
    Nothing,
    /// The terminal is gone.
    Gone,
}

impl Keyboard {
    /// The keyboard; an error if there is none.
    pub(crate) fn find() -> io::Result<Self> {
        let other = if io::stdin().is_terminal() || cfg!(not(unix)) {
            None
        } else {
            Some(File::open("/dev/tty")?)
        };
        Ok(Self { other })
    }

    /// Waits for an event, so long at most.
    pub(crate) fn wait(&self, patience: Duration) -> io::Result<Waited> {
        // The library may have read more events than it has given; but asked about a terminal that is gone, it would look
        // for its next byte for ever.
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

    /// What there is on the line, now or within some time.
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
            // A signal, such as the one for another size.
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

/// What a line tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(unix), expect(dead_code, reason = "nothing tells there"))]
enum TerminalInput {
    Ready,
    Silent,
    Gone,
    /// This system does not tell it of this line.
    Untold,
}
