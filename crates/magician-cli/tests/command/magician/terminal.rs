//! Runs the command on a terminal, for tests that act as a user.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// Beginning of a complete redraw.
const CLEARED: &str = "\x1b[2J";

/// Program on its own pseudo-terminal.
pub(crate) struct Terminal {
    pub(crate) child: Child,
    pub(crate) screen: File,
    /// Kept open, so that the last output and the terminal's final mode can be read.
    pub(crate) line: File,
    seen: String,
}

impl Terminal {
    /// Runs a command with stdin, stdout and stderr on a terminal of 80 by 24.
    pub(crate) fn running(command: Command) -> Self {
        Self::with_stdout(command, None)
    }

    /// Runs it with another stdout.
    pub(crate) fn with_stdout(mut command: Command, stdout: Option<Stdio>) -> Self {
        // CLOEXEC: a child that inherited this end would keep the terminal open after it is closed.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let screen = openpt(flags).expect("a terminal");
        grantpt(&screen)
            .and_then(|()| unlockpt(&screen))
            .expect("ours");
        let size = Winsize {
            ws_row: 24,
            ws_col: 80,
            ws_xpixel: 0,
            ws_ypixel: 0,
        };
        tcsetwinsize(&screen, size).expect("it takes a size");
        let name = ptsname(&screen, Vec::new()).expect("a name");
        let open = || {
            let path = name.to_str().expect("UTF-8");
            let file = File::options().read(true).write(true).open(path);
            file.expect("it opens")
        };
        let line = open();
        let child = command
            .env("TERM", "xterm")
            .stdin(open())
            .stdout(stdout.unwrap_or_else(|| open().into()))
            .stderr(open())
            .spawn()
            .expect("the command starts");
        let screen = File::from(screen);
        Self {
            child,
            screen,
            line,
            seen: String::new(),
        }
    }

    /// Reads until this text has been written.
    pub(crate) fn until(&mut self, text: &str) {
        self.read_until(text, |seen| {
            let at = seen.find(text)?;
            Some(at + text.len())
        });
    }

    /// Reads until this text is visible in a line, however the cursor moved to write it.
    pub(crate) fn until_seen(&mut self, text: &str) {
        self.read_until(text, |seen| {
            plain(seen).contains(text).then_some(seen.len())
        });
    }

    /// Reads until the progress shows this step or a later one; a busy machine skips steps.
    pub(crate) fn until_step(&mut self, step: u32) {
        self.read_until("a step that is done", |seen| {
            let text = plain(seen);
            let mut counts = text.match_indices(" steps done").filter_map(|(end, _)| {
                let (done, _) = text[..end].rsplit_once('/')?;
                let digits = done.rsplit(|c: char| !c.is_ascii_digit()).next()?;
                digits.parse::<u32>().ok()
            });
            counts.any(|done| done >= step).then_some(seen.len())
        });
    }

    /// Reads until both texts were shown, the first before the second; they may come together.
    pub(crate) fn until_both_seen(&mut self, [first, second]: [&str; 2]) {
        self.read_until(second, |seen| {
            let text = plain(seen);
            let (_, rest) = text.split_once(first)?;
            rest.contains(second).then_some(seen.len())
        });
    }

    /// Redraws with Ctrl-L until this text is visible. For parts that change by themselves, of
    /// which only the difference is drawn.
    pub(crate) fn until_drawn(&mut self, text: &str) {
        self.until_drawn_with("", text);
    }

    /// Does the same, typing keys each time. For an order that a stop may overtake and that may be
    /// given twice.
    pub(crate) fn until_drawn_with(&mut self, keys: &str, text: &str) {
        let deadline = Instant::now() + Duration::from_secs(120);
        self.seen.clear();
        while Instant::now() < deadline {
            self.types(keys);
            self.types("\x0c");
            // One or two frames; if one takes longer, it is read with the next.
            let frames = Instant::now() + Duration::from_millis(150);
            while let Some(left) = frames.checked_duration_since(Instant::now()) {
                self.read(left);
                if plain(&self.seen).contains(text) {
                    return;
                }
            }
            if let Some(anew) = self.seen.rfind(CLEARED) {
                self.seen.drain(..anew);
            }
        }
        panic!("no {text:?} in {:?}", self.seen);
    }

    /// Reads the next output. Returns false after a timeout.
    fn read(&mut self, patience: Duration) -> bool {
        let patience = Timespec::try_from(patience).expect("a short time");
        let mut wait = [PollFd::new(&self.screen, PollFlags::IN)];
        if poll(&mut wait, Some(&patience)).expect("it polls") == 0 {
            return false;
        }
        let mut bytes = [0; 512];
        let count = self.screen.read(&mut bytes).expect("it goes on");
        let text = String::from_utf8_lossy(&bytes[..count]);
        self.seen.push_str(&text);
        true
    }

    fn read_until(&mut self, text: &str, end: impl Fn(&str) -> Option<usize>) {
        // A deadline, so that the test fails instead of hanging.
        let deadline = Instant::now() + Duration::from_secs(120);
        loop {
            if let Some(end) = end(&self.seen) {
                self.seen.drain(..end);
                return;
            }
            let left = deadline.saturating_duration_since(Instant::now());
            assert!(self.read(left), "no {text:?} in {:?}", self.seen);
        }
    }

    /// Sends a signal to the program.
    pub(crate) fn tell(&self, signal: Signal) {
        let pid = Pid::from_child(&self.child);
        kill_process(pid, signal).expect("it is there");
    }

    /// Waits until the program is stopped, as by Ctrl-Z.
    pub(crate) fn until_stopped(&self) {
        let deadline = Instant::now() + Duration::from_secs(60);
        let stat = format!("/proc/{}/stat", self.child.id());
        loop {
            let stat = std::fs::read_to_string(&stat).expect("it is there");
            let (_, rest) = stat.rsplit_once(") ").expect("a name");
            if rest.starts_with('T') {
                return;
            }
            assert!(Instant::now() < deadline, "it is not stopped");
            std::thread::yield_now();
        }
    }

    /// Stops a job by these keys. Asserts its message and the exit status of an interruption.
    pub(crate) fn interrupts(&mut self, keys: &str, said: &str) {
        self.types(keys);
        self.until_seen(said);
        assert_eq!(self.child.wait().expect("it ends").code(), Some(130));
    }

    /// Closes the terminal: its programs get SIGHUP.
    pub(crate) fn closes(&mut self) {
        self.screen = File::open("/dev/null").expect("it opens");
    }

    pub(crate) fn types(&mut self, keys: &str) {
        self.screen.write_all(keys.as_bytes()).expect("typed");
    }
}

/// Removes escape sequences from text. Movements of the cursor and runs of spaces become one space.
fn plain(seen: &str) -> String {
    let mut pieces = seen.split("\x1b[");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let end = piece.find(|sign: char| sign.is_ascii_alphabetic());
        let (order, rest) = piece.split_at(end.map_or(piece.len(), |end| end + 1));
        if order.ends_with('H') {
            text.push(' ');
        }
        text.push_str(rest);
    }
    let mut last = None;
    text.retain(|sign| last.replace(sign) != Some(' ') || sign != ' ');
    text
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
