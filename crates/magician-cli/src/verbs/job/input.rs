//! What a person types while a job runs: keys at a terminal, lines of JSON elsewhere.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::thread;

use serde::Deserialize;
use tokio::sync::mpsc;

use super::Job;
use crate::context::Context;

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
    /// A line that means nothing.
    Line(String),
}

/// Where it comes from.
pub(super) struct Input {
    typed: mpsc::UnboundedReceiver<Typed>,
    #[cfg(unix)]
    _keys: Option<keys::Keys>,
}

/// A line of JSON that is obeyed.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
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
    /// Begins to listen, if somebody can be there: not where stdin is the file.
    pub(super) fn input(&self, context: &Context) -> Input {
        let (sender, typed) = mpsc::unbounded_channel();
        let is_file = self.file.file == Path::new("-");
        let json = context.global.json;
        if json && !is_file && !context.in_shell && is_ours() {
            // It ends with the process: nothing wakes who reads a line.
            let read = move || lines(io::stdin(), &sender);
            let _ = thread::Builder::new().name("stdin".to_owned()).spawn(read);
            return Input {
                typed,
                #[cfg(unix)]
                _keys: None,
            };
        }
        Input {
            typed,
            #[cfg(unix)]
            _keys: (!json && !is_file)
                .then(|| keys::Keys::listen(sender))
                .flatten(),
        }
    }
}

impl Input {
    /// The next input; pending for ever without a terminal or a pipe.
    pub(super) async fn next(&mut self) -> Typed {
        match self.typed.recv().await {
            Some(typed) => typed,
            None => std::future::pending().await,
        }
    }
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
    match serde_json::from_str::<Line>(&text) {
        Ok(Line { order }) => match order {
            Order::Pause => Typed::Pause,
            Order::Resume => Typed::Resume,
            Order::Stop => Typed::Stop,
        },
        Err(_) => Typed::Line(text),
    }
}

/// Whether stdin may be read: who reads a terminal in the background is stopped by the system.
fn is_ours() -> bool {
    #[cfg(unix)]
    {
        use std::io::IsTerminal;
        !io::stdin().is_terminal() || keys::in_front()
    }
    #[cfg(not(unix))]
    true
}

/// Keys, one by one. Ctrl-C stays a signal.
#[cfg(unix)]
mod keys {
    use std::io::{self, IsTerminal};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread;

    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::process::getpgrp;
    use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};
    use tokio::sync::mpsc;

    use super::Typed;

    /// How often it is looked whether anybody listens still.
    const LOOKS: Timespec = Timespec {
        tv_sec: 0,
        tv_nsec: 100_000_000,
    };

    /// While it lasts, keys are heard as they are pressed; then the terminal is as it was.
    pub(super) struct Keys {
        before: Termios,
        over: Arc<AtomicBool>,
    }

    /// Whether this program has the terminal. One that does not control it is not stopped for reading it.
    pub(super) fn in_front() -> bool {
        tcgetpgrp(io::stdin()).map_or(true, |group| group == getpgrp())
    }

    impl Keys {
        pub(super) fn listen(to: mpsc::UnboundedSender<Typed>) -> Option<Self> {
            let terminal = io::stdin().is_terminal() && io::stderr().is_terminal();
            if !terminal || !in_front() {
                return None;
            }
            let before = tcgetattr(io::stdin()).ok()?;
            let mut keys = before.clone();
            keys.local_modes &= !(LocalModes::ICANON | LocalModes::ECHO);
            tcsetattr(io::stdin(), OptionalActions::Now, &keys).ok()?;
            let over = Arc::new(AtomicBool::new(false));
            let keys = Self {
                before,
                over: Arc::clone(&over),
            };
            let read = thread::Builder::new().name("keys".to_owned());
            read.spawn(move || listen(&over, &to)).ok()?;
            Some(keys)
        }
    }

    impl Drop for Keys {
        fn drop(&mut self) {
            self.over.store(true, Ordering::SeqCst);
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
        }
    }

    fn listen(over: &AtomicBool, to: &mpsc::UnboundedSender<Typed>) {
        let stdin = io::stdin();
        while !over.load(Ordering::SeqCst) {
            let mut wait = [PollFd::new(&stdin, PollFlags::IN)];
            match poll(&mut wait, Some(&LOOKS)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => continue,
                Ok(_) => {}
                Err(_) => return,
            }
            let mut keys = [0; 16];
            let Ok(count @ 1..) = rustix::io::read(&stdin, &mut keys) else {
                return;
            };
            for key in keys.iter().take(count) {
                let typed = match key {
                    b'p' | b'P' => Typed::Toggle,
                    b' ' | b's' | b'S' => Typed::Stop,
                    _ => continue,
                };
                if to.send(typed).is_err() {
                    return;
                }
            }
        }
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
