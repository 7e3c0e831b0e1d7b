//! Settings file: precedence, and errors in it.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::magician::command;
use serde_json::{Value, json};

/// Directory with a settings file.
struct Fixture {
    dir: tempfile::TempDir,
}

impl Fixture {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        Self { dir }
    }

    fn with(text: &str) -> Self {
        let fixture = Self::new();
        std::fs::write(fixture.path(), text).expect("written");
        fixture
    }

    fn path(&self) -> PathBuf {
        self.dir.path().join("config.toml")
    }

    fn text(&self) -> String {
        std::fs::read_to_string(self.path()).expect("a file")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = command();
        command.env("MAGICIAN_CONFIG", self.path()).args(arguments);
        command
    }

    /// Runs the command. Returns status, stdout and stderr.
    fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        outcome(&mut self.command(arguments))
    }

    fn setting(&self, key: &str) -> Value {
        let (status, out, _) = self.run(&["--json", "config", "get", key]);
        assert_eq!(status, 0);
        serde_json::from_str(&out).expect("an object")
    }
}

fn outcome(command: &mut Command) -> (i32, String, String) {
    let output = command.output().expect("it runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let status = output.status.code().expect("not killed");
    (status, text(&output.stdout), text(&output.stderr))
}

#[test]
fn setting_can_be_saved_shown_and_removed() {
    let fixture = Fixture::new();
    assert_eq!(
        fixture.setting("tool"),
        json!({"key": "tool", "value": null, "source": "default"})
    );
    let (status, out, err) = fixture.run(&["config", "set", "tool", "Pen"]);
    assert_eq!((status, out.as_str(), err.as_str()), (0, "pen\n", ""));
    assert_eq!(fixture.run(&["config", "set", "surface", "-61.5"]).0, 0);
    assert_eq!(
        fixture
            .run(&["config", "set", "draw.travel-speed", "150"])
            .0,
        0
    );
    assert_eq!(
        fixture.text(),
        "tool = \"pen\"\nsurface = -61.5\n\n[draw]\ntravel_speed = 150\n"
    );
    assert_eq!(fixture.run(&["config", "get", "surface"]).1, "-61.5\n");
    assert_eq!(fixture.run(&["config", "unset", "tool"]).0, 0);
    assert!(!fixture.text().contains("tool"));
    let (_, out, _) = fixture.run(&["config"]);
    assert!(out.contains("surface") && out.contains("-61.5"), "{out}");
    assert!(out.contains(&fixture.path().display().to_string()), "{out}");
}

#[test]
fn flag_overrides_environment_and_environment_overrides_file() {
    let fixture = Fixture::with("port = \"tcp:127.0.0.1:1\"\n");
    let mut file = fixture.command(&["--json", "pose"]);
    let (status, _, err) = outcome(&mut file);
    assert_eq!(status, 4, "{err}");
    assert!(err.contains("127.0.0.1 port 1"), "{err}");
    let mut environment = fixture.command(&["pose"]);
    environment.env("MAGICIAN_PORT", "sim");
    assert_eq!(outcome(&mut environment).0, 0);
    let mut flag = fixture.command(&["--port", "sim", "pose"]);
    flag.env("MAGICIAN_PORT", "tcp:127.0.0.1:1");
    assert_eq!(outcome(&mut flag).0, 0);
    let mut shown = fixture.command(&["--json", "config", "get", "port"]);
    shown.env("MAGICIAN_PORT", "sim");
    let (_, out, _) = outcome(&mut shown);
    let shown: Value = serde_json::from_str(&out).expect("an object");
    assert_eq!(
        shown,
        json!({"key": "port", "value": "sim", "source": "environment"})
    );
    // An empty variable counts as not set.
    let mut empty = fixture.command(&["--json", "config", "get", "port"]);
    empty.env("MAGICIAN_PORT", "");
    assert!(outcome(&mut empty).1.contains("127.0.0.1:1"));
}

#[test]
fn every_verb_takes_the_port_of_the_file() {
    let fixture = Fixture::with("port = \"sim\"\n");
    for arguments in [
        &["pose"][..],
        &["home"],
        &["queue"],
        &["move", "220", "0", "0"],
        &["doctor", "--yes"],
    ] {
        let (status, _, err) = fixture.run(arguments);
        assert_eq!(status, 0, "{arguments:?}: {err}");
    }
}

#[test]
fn invalid_file_is_reported_with_its_position_by_dependent_verbs() {
    let fixture = Fixture::with("# mine\nprot = \"sim\"\n");
    let (status, _, err) = fixture.run(&["pose"]);
    assert_eq!(status, 3);
    for part in [
        "unknown setting `prot`",
        "config.toml:2:1",
        "did you mean `port`?",
        "^^^^",
    ] {
        assert!(err.contains(part), "{part}: {err}");
    }
    let (status, _, err) = fixture.run(&["--json", "pose"]);
    let error: Value = serde_json::from_str(&err).expect("an object");
    assert_eq!(status, 3);
    assert_eq!(error["error"]["kind"], "invalid-input");
    let message = error["error"]["message"].as_str().expect("text");
    assert!(message.contains("line 2, column 1"), "{message}");
    assert_eq!(fixture.run(&["config", "set", "tool", "pen"]).0, 3);
    assert_eq!(fixture.text(), "# mine\nprot = \"sim\"\n");
    // Verbs that do not use the settings still work.
    assert_eq!(fixture.run(&["forward", "0", "45", "45", "0"]).0, 0);
}

#[test]
fn mistakes_are_usage_errors_and_change_nothing() {
    let fixture = Fixture::new();
    for arguments in [
        &["config", "set", "prot", "sim"][..],
        &["config", "set", "port", "nowhere"],
        &["config", "set", "window", "9"],
        &["config", "set", "sheet", "1"],
        &["config", "get", "speed"],
        &["config", "unset", "speed"],
    ] {
        assert_eq!(fixture.run(arguments).0, 2, "{arguments:?}");
    }
    assert!(!Path::new(&fixture.path()).exists());
}

#[cfg(unix)]
#[test]
fn symlinked_file_stays_a_symlink() {
    let fixture = Fixture::new();
    let real = fixture.dir.path().join("real.toml");
    std::fs::write(&real, "# mine\n").expect("written");
    std::os::unix::fs::symlink(&real, fixture.path()).expect("a link");
    assert_eq!(fixture.run(&["config", "set", "port", "sim"]).0, 0);
    assert!(fixture.path().is_symlink());
    let text = std::fs::read_to_string(&real).expect("a file");
    assert_eq!(text, "# mine\nport = \"sim\"\n");
}
