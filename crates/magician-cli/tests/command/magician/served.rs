//! Virtual arm, proxy or station that the command serves in another process.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use super::command;

/// Server process.
pub(crate) struct Served {
    pub(crate) child: Child,
    pub(crate) stdout: BufReader<ChildStdout>,
    /// Lines on stderr before it was ready.
    pub(crate) endpoints: Vec<String>,
    /// Lines on stderr from then on.
    log: Receiver<String>,
    /// Lines that have been read from the log.
    seen: Vec<String>,
}

impl Served {
    /// Starts a virtual arm with this many endpoints.
    pub(crate) fn start(arguments: &[&str], endpoints: usize) -> Self {
        Self::verb("sim", arguments, endpoints + 1)
    }

    /// Starts a verb that prints this many lines before it is ready.
    pub(crate) fn verb(verb: &str, arguments: &[&str], lines_first: usize) -> Self {
        Self::of(command(), verb, arguments, lines_first)
    }

    /// Starts it with the environment of a command.
    pub(crate) fn of(
        mut command: Command,
        verb: &str,
        arguments: &[&str],
        lines_first: usize,
    ) -> Self {
        let mut child = command
            .arg(verb)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("stdout"));
        let mut line = String::new();
        stdout.read_line(&mut line).expect("a line");
        assert_eq!(line, "ready\n");
        let stderr = child.stderr.take().expect("stderr");
        let mut lines = BufReader::new(stderr)
            .lines()
            .map(|line| line.expect("UTF-8"));
        let endpoints = lines.by_ref().take(lines_first).collect();
        // The output must be read, or the process would block once the pipe is full.
        let (sender, log) = channel();
        std::thread::spawn(move || lines.try_for_each(|line| sender.send(line)));
        Self {
            child,
            stdout,
            endpoints,
            log,
            seen: Vec::new(),
        }
    }

    /// Returns the address after `serving udp:` and the like.
    pub(crate) fn endpoint(&self, scheme: &str) -> String {
        let prefix = format!("serving {scheme}:");
        let found = self
            .endpoints
            .iter()
            .find_map(|line| line.strip_prefix(&prefix));
        format!(
            "{scheme}:{}",
            found.unwrap_or_else(|| panic!("{:?}", self.endpoints))
        )
    }

    /// Ends the process with a signal. Returns its status and the rest of stdout.
    pub(crate) fn end(self, signal: &str) -> (ExitStatus, String) {
        let (status, rest, _) = self.end_telling(signal);
        (status, rest)
    }

    /// Like [`end`](Self::end), but also returns the output on stderr since it was ready.
    pub(crate) fn end_telling(mut self, signal: &str) -> (ExitStatus, String, String) {
        let kill = Command::new("kill")
            .args([signal, &self.child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        let status = self.child.wait().expect("it ends");
        let mut rest = String::new();
        self.stdout.read_to_string(&mut rest).expect("UTF-8");
        let mut said = std::mem::take(&mut self.seen);
        said.extend(self.log.iter());
        (status, rest, said.join("\n"))
    }

    /// Waits for a line that matches, and returns it.
    pub(crate) fn until(&mut self, what: impl Fn(&str) -> bool) -> String {
        // A deadline, so that the test fails instead of hanging.
        let deadline = Instant::now() + Duration::from_secs(120);
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let line = self.log.recv_timeout(left);
            let line = line.unwrap_or_else(|_| panic!("not said: {:?}", self.seen));
            self.seen.push(line.clone());
            if what(&line) {
                return line;
            }
        }
    }

    /// Ends it with SIGTERM. Returns its output on stderr since it was ready.
    pub(crate) fn log(self) -> Vec<String> {
        let (_, _, said) = self.end_telling("-TERM");
        said.lines().map(str::to_owned).collect()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
