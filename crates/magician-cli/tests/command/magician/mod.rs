//! Runs the built command as a shell does.
#![cfg_attr(
    not(target_os = "linux"),
    allow(dead_code, reason = "terminals and signals are tried elsewhere only")
)]

#[cfg(unix)]
pub(crate) mod device;
#[cfg(unix)]
pub(crate) mod drawing;
#[cfg(unix)]
pub(crate) mod homed;
#[cfg(unix)]
pub(crate) mod served;
#[cfg(target_os = "linux")]
pub(crate) mod terminal;

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::Value;

/// Result of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) status: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Returns the command without the tester's environment.
pub(crate) fn command() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_magician"));
    for variable in [
        "MAGICIAN_PORT",
        "MAGICIAN_TOOL",
        "MAGICIAN_WINDOW",
        "NO_COLOR",
    ] {
        command.env_remove(variable);
    }
    // Empty settings file.
    command.env("MAGICIAN_CONFIG", "/dev/null");
    // A state folder per test: arms of other tests have the same serial number.
    let state = format!(
        "{}/state-{}-{:?}",
        env!("CARGO_TARGET_TMPDIR"),
        std::process::id(),
        std::thread::current().id()
    );
    command.env("XDG_DATA_HOME", format!("{state}/data"));
    command.env("XDG_STATE_HOME", state);
    command
}

/// Runs the command with these arguments and an empty stdin.
pub(crate) fn run(arguments: &[&str]) -> Run {
    run_with(arguments, b"")
}

/// Runs the command with these arguments and bytes on stdin.
pub(crate) fn run_with(arguments: &[&str], stdin: &[u8]) -> Run {
    Run::of(command().args(arguments), stdin)
}

impl Run {
    /// Runs a command to its end, with bytes on stdin.
    pub(crate) fn of(command: &mut Command, stdin: &[u8]) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut pipe = child.stdin.take().expect("stdin");
        let bytes = stdin.to_vec();
        let writer = std::thread::spawn(move || pipe.write_all(&bytes));
        let output = child.wait_with_output().expect("the command ends");
        let _ = writer.join();
        Run {
            status: output.status.code().expect("not killed"),
            out: String::from_utf8(output.stdout).expect("UTF-8"),
            err: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }

    /// Returns the JSON objects on stdout, one per line.
    pub(crate) fn objects(&self) -> Vec<Value> {
        let lines = self.out.lines();
        lines
            .map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}")))
            .collect()
    }

    /// Returns the only JSON object on stdout.
    pub(crate) fn object(&self) -> Value {
        let mut objects = self.objects();
        assert_eq!(objects.len(), 1, "{self:?}");
        objects.remove(0)
    }

    /// Returns the error object, the only content of stderr.
    pub(crate) fn error(&self) -> Value {
        let object: Value = serde_json::from_str(&self.err).unwrap_or_else(|_| panic!("{self:?}"));
        object["error"].clone()
    }
}

/// Sends a signal, such as `-INT`.
#[cfg(unix)]
pub(crate) fn signal(name: &str, child: &std::process::Child) {
    let id = child.id().to_string();
    let kill = Command::new("kill").args([name, &id]).status();
    assert!(kill.expect("kill runs").success());
}

/// Returns the path of a sample file of the program crate.
pub(crate) fn sample(name: &str) -> String {
    let root = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("../magician-program/samples").join(name);
    path.to_str().expect("UTF-8").to_owned()
}
