//! A virtual arm or a proxy served by the command, for the tests that need one in another process.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use super::command;

/// A virtual arm in a process of its own.
pub(crate) struct Served {
    pub(crate) child: Child,
    pub(crate) stdout: BufReader<ChildStdout>,
    /// What stderr said before it was ready.
    pub(crate) doors: Vec<String>,
    /// What it says from then on.
    log: Receiver<String>,
    /// What of that has been looked at.
    seen: Vec<String>,
}

impl Served {
    /// A virtual arm with so many doors.
    pub(crate) fn start(arguments: &[&str], doors: usize) -> Self {
        Self::verb("sim", arguments, doors + 1)
    }

    /// A verb that says so many lines before it is ready.
    pub(crate) fn verb(verb: &str, arguments: &[&str], lines_first: usize) -> Self {
        Self::of(command(), verb, arguments, lines_first)
    }

    /// The same, in an environment.
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
        let doors = lines.by_ref().take(lines_first).collect();
        // The output has to be read, or the arm would wait for it.
        let (sender, log) = channel();
        std::thread::spawn(move || lines.try_for_each(|line| sender.send(line)));
        Self {
            child,
            stdout,
            doors,
            log,
            seen: Vec::new(),
        }
    }

    /// The address after `serving udp:`.
    pub(crate) fn door(&self, scheme: &str) -> String {
        let prefix = format!("serving {scheme}:");
        let found = self
            .doors
            .iter()
            .find_map(|line| line.strip_prefix(&prefix));
        format!(
            "{scheme}:{}",
            found.unwrap_or_else(|| panic!("{:?}", self.doors))
        )
    }

    /// Ends it with a signal; its status and the rest of its stdout.
    pub(crate) fn end(self, signal: &str) -> (ExitStatus, String) {
        let (status, rest, _) = self.end_telling(signal);
        (status, rest)
    }

    /// As [`end`](Self::end), with what it has said on stderr since it was ready.
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

    /// Waits until it says this; the line.
    pub(crate) fn until(&mut self, what: impl Fn(&str) -> bool) -> String {
        // A test that waits for what never comes should fail, not hang.
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

    /// Ends it with SIGTERM; what stderr said since it was ready.
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
