//! What a person types while a job runs: keys at a terminal, lines of JSON elsewhere.

use std::io::{self, BufRead, BufReader, IsTerminal, Read};
use std::path::Path;
use std::thread;

use serde::Deserialize;
use tokio::sync::mpsc;

use super::Job;
use super::keys::Keys;
#[cfg(unix)]
use super::keys::is_in_front;
use crate::context::Context;
#[cfg(unix)]
use crate::terminal::FRAME;

/// No line of ours is as long.
const LONGEST: u64 = 1 << 16;

/// What is wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Typed {
    /// The key that pauses, and goes on.
    Toggle,
    Pause,
    Resume,
    Stop,
    Faster,
    Slower,
    /// A line that means nothing.
    Line(String),
    /// There will be no more lines.
    End,
}

/// The source of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// None: stdin is the file, or the screen has the keys.
    Nowhere,
    Lines,
    Keys,
}

/// Where it comes from.
pub(super) struct Input {
    source: Source,
    typed: mpsc::UnboundedReceiver<Typed>,
    to: mpsc::UnboundedSender<Typed>,
    keys: Option<Keys>,
    reads: bool,
}

/// A line of JSON that is obeyed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControlLine {
    #[serde(rename = "do")]
    order: Order,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Order {
    Pause,
    Resume,
    Stop,
}

impl Job {
    /// What can be listened to: stdin, where it is not the file.
    pub(super) fn input(&self, context: &Context) -> Input {
        let source = if self.file.file == Path::new("-") || self.way.tui {
            Source::Nowhere
        } else if !context.global.json {
            Source::Keys
        } else if context.in_shell() {
            Source::Nowhere
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
    /// Whether somebody may answer a pause: at the keyboard, or by lines.
    pub(super) fn can_answer(&self, tui: bool) -> bool {
        match self.source {
            Source::Nowhere => tui,
            Source::Lines => true,
            Source::Keys => io::stdin().is_terminal(),
        }
    }

    /// Listens from now on, if there can be a person.
    pub(super) fn listen(&mut self) {
        let to = self.to.clone();
        match self.source {
            Source::Nowhere => {}
            Source::Keys if self.keys.is_some() => {}
            Source::Keys => self.keys = Keys::listen(to),
            Source::Lines if self.reads => {}
            Source::Lines => {
                self.reads = true;
                // It ends with the process: nothing wakes a thread that reads a line.
                let read = move || {
                    lines(InFront(io::stdin()), &to);
                    // The job may be over.
                    let _ = to.send(Typed::End);
                };
                let _ = thread::Builder::new().name("stdin".to_owned()).spawn(read);
            }
        }
    }

    /// Gives the terminal back until it listens again.
    pub(super) fn release(&mut self) {
        self.keys = None;
    }

    /// The next input; pending for ever without a terminal or a pipe.
    pub(super) async fn next(&mut self) -> Typed {
        match self.typed.recv().await {
            Some(typed) => typed,
            None => std::future::pending().await,
        }
    }
}

/// stdin; if that is a terminal, while this program is in the foreground: the system stops a background process that
/// reads a terminal.
struct InFront(io::Stdin);

impl Read for InFront {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.0.is_terminal() {
            wait_in_front(&self.0)?;
        }
        self.0.read(into)
    }
}

#[cfg(unix)]
fn wait_in_front(stdin: &io::Stdin) -> io::Result<()> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let patience = Timespec::try_from(FRAME).map_err(io::Error::other)?;
    loop {
        let told = poll(&mut [PollFd::new(stdin, PollFlags::IN)], Some(&patience));
        match told {
            Ok(1..) if is_in_front() => return Ok(()),
            // There is input for the foreground process.
            Ok(1..) => thread::sleep(FRAME),
            Ok(0) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

#[cfg(not(unix))]
const fn wait_in_front(_: &io::Stdin) -> io::Result<()> {
    Ok(())
}

/// Reads lines to their end.
fn lines(from: impl Read, to: &mpsc::UnboundedSender<Typed>) {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    while let Ok(1..) = from.by_ref().take(LONGEST).read_until(b'\n', &mut line) {
        let text = String::from_utf8_lossy(&line).trim().to_owned();
        line.clear();
        if !text.is_empty() && to.send(meaning(text)).is_err() {
            return;
        }
    }
}

fn meaning(text: String) -> Typed {
    match serde_json::from_str::<ControlLine>(&text) {
        Ok(ControlLine { order }) => match order {
            Order::Pause => Typed::Pause,
            Order::Resume => Typed::Resume,
            Order::Stop => Typed::Stop,
        },
        Err(_) => Typed::Line(text),
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
        let line = |text: &str| Typed::Line(text.to_owned());
        let wanted = [
            Typed::Pause,
            Typed::Resume,
            line("halt"),
            line("{\"do\":\"fly\"}"),
            line("{\"do\":\"stop\",\"now\":1}"),
            Typed::Stop,
        ];
        assert_eq!(typed, wanted);
    }

    #[test]
    fn a_line_without_end_is_read_in_pieces() {
        let (to, mut from) = mpsc::unbounded_channel();
        lines(io::repeat(b'x').take(3 * LONGEST), &to);
        let first = from.try_recv().expect("a piece");
        assert_eq!(first, Typed::Line("x".repeat(1 << 16)));
    }
}
