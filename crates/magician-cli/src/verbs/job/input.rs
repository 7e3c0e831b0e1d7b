//! User input while a job runs: keys at a terminal, lines of JSON otherwise.

use std::io::{self, BufRead, BufReader, IsTerminal, Read};
use std::path::Path;
use std::thread;

use serde::Deserialize;
use tokio::sync::mpsc;

use super::Job;
use super::keys::Keys;
#[cfg(unix)]
use super::keys::is_in_foreground;
use crate::context::Context;
#[cfg(unix)]
use crate::terminal::FRAME_INTERVAL;

/// Largest line, bytes; far above any valid one. Bounds the memory for input that has no line
/// feeds.
const MAX_LINE_LENGTH: u64 = 1 << 16;

/// Order from the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum UserOrder {
    /// Key that pauses or resumes.
    Toggle,
    Pause,
    Resume,
    Stop,
    Faster,
    Slower,
    /// Invalid order.
    Line(String),
    /// End of the input.
    End,
}

/// Source of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// No input: stdin is the file, or the full-screen picture reads the keys.
    None,
    Lines,
    Keys,
}

/// Stream of orders.
pub(super) struct Input {
    source: Source,
    typed: mpsc::UnboundedReceiver<UserOrder>,
    to: mpsc::UnboundedSender<UserOrder>,
    keys: Option<Keys>,
    reads: bool,
}

/// Line of JSON.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControlLine {
    #[serde(rename = "do")]
    order: LineOrder,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LineOrder {
    Pause,
    Resume,
    Stop,
}

impl Job {
    /// Returns the input for this job: stdin, unless it is the file itself.
    pub(super) fn input(&self, context: &Context) -> Input {
        let source = if self.file.file == Path::new("-") || self.way.tui {
            Source::None
        } else if !context.global.json {
            Source::Keys
        } else if context.in_shell() {
            Source::None
        } else {
            Source::Lines
        };
        let (to, typed) = mpsc::unbounded_channel();
        Input {
            source,
            typed,
            to,
            keys: None,
            reads: false,
        }
    }
}

impl Input {
    /// True if a pause may be answered, by a key or a line.
    pub(super) fn can_answer(&self, tui: bool) -> bool {
        match self.source {
            Source::None => tui,
            Source::Lines => true,
            Source::Keys => io::stdin().is_terminal(),
        }
    }

    /// Begins to listen.
    pub(super) fn listen(&mut self) {
        let to = self.to.clone();
        match self.source {
            Source::None => {}
            Source::Keys if self.keys.is_some() => {}
            Source::Keys => self.keys = Keys::listen(to),
            Source::Lines if self.reads => {}
            Source::Lines => {
                self.reads = true;
                // Never joined: nothing can wake a thread that is reading from stdin, so it ends
                // with the process.
                let read = move || {
                    lines(ForegroundStdin(io::stdin()), &to);
                    // Fails if the job has ended meanwhile.
                    let _ = to.send(UserOrder::End);
                };
                let _ = thread::Builder::new().name("stdin".to_owned()).spawn(read);
            }
        }
    }

    /// Restores the terminal until the next `listen`.
    pub(super) fn release(&mut self) {
        self.keys = None;
    }

    /// Waits for the next order; for ever without a terminal or a pipe.
    pub(super) async fn next(&mut self) -> UserOrder {
        match self.typed.recv().await {
            Some(typed) => typed,
            None => std::future::pending().await,
        }
    }
}

/// Standard input that a background process does not read: the system would stop the process
/// (SIGTTIN).
struct ForegroundStdin(io::Stdin);

impl Read for ForegroundStdin {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.0.is_terminal() {
            wait_for_foreground(&self.0)?;
        }
        self.0.read(into)
    }
}

#[cfg(unix)]
fn wait_for_foreground(stdin: &io::Stdin) -> io::Result<()> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let patience = Timespec::try_from(FRAME_INTERVAL).map_err(io::Error::other)?;
    loop {
        let polled = poll(&mut [PollFd::new(stdin, PollFlags::IN)], Some(&patience));
        match polled {
            Ok(1..) if is_in_foreground() => return Ok(()),
            // Readable, but the input belongs to the foreground process.
            Ok(1..) => thread::sleep(FRAME_INTERVAL),
            Ok(0) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

#[cfg(not(unix))]
const fn wait_for_foreground(_: &io::Stdin) -> io::Result<()> {
    Ok(())
}

/// Reads lines to the end of the input.
fn lines(from: impl Read, to: &mpsc::UnboundedSender<UserOrder>) {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    while let Ok(1..) = from
        .by_ref()
        .take(MAX_LINE_LENGTH)
        .read_until(b'\n', &mut line)
    {
        let text = String::from_utf8_lossy(&line).trim().to_owned();
        line.clear();
        if !text.is_empty() && to.send(parse_line(text)).is_err() {
            return;
        }
    }
}

fn parse_line(text: String) -> UserOrder {
    match serde_json::from_str::<ControlLine>(&text) {
        Ok(ControlLine { order }) => match order {
            LineOrder::Pause => UserOrder::Pause,
            LineOrder::Resume => UserOrder::Resume,
            LineOrder::Stop => UserOrder::Stop,
        },
        Err(_) => UserOrder::Line(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_obeyed_or_handed_back() {
        let (to, mut from) = mpsc::unbounded_channel();
        let text = "{\"do\":\"pause\"}\n\n {\"do\": \"resume\"} \nhalt\n{\"do\":\"fly\"}\n{\"do\":\"stop\",\"now\":1}\n{\"do\":\"stop\"}";
        lines(text.as_bytes(), &to);
        drop(to);
        let mut typed = Vec::new();
        while let Ok(next) = from.try_recv() {
            typed.push(next);
        }
        let line = |text: &str| UserOrder::Line(text.to_owned());
        let wanted = [
            UserOrder::Pause,
            UserOrder::Resume,
            line("halt"),
            line("{\"do\":\"fly\"}"),
            line("{\"do\":\"stop\",\"now\":1}"),
            UserOrder::Stop,
        ];
        assert_eq!(typed, wanted);
    }

    #[test]
    fn a_line_without_end_is_read_in_pieces() {
        let (to, mut from) = mpsc::unbounded_channel();
        lines(io::repeat(b'x').take(3 * MAX_LINE_LENGTH), &to);
        let first = from.try_recv().expect("a piece");
        assert_eq!(first, UserOrder::Line("x".repeat(1 << 16)));
    }
}
