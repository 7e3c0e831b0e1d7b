//! Settings file: precedence, and errors in it.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::magician::command;
use serde_json::{Value, json};

/// Directory with a settings file.
struct Place {
    dir: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        Self { dir }
    }

    fn with(text: &str) -> Self {
        let place = Self::new();
        std::fs::write(place.path(), text).expect("written");
        place
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
fn a_setting_is_kept_shown_and_forgotten() {
    let place = Place::new();
    assert_eq!(
        place.setting("tool"),
        json!({"key": "tool", "value": null, "source": "default"})
    );
    let (status, out, err) = place.run(&["config", "set", "tool", "Pen"]);
    assert_eq!((status, out.as_str(), err.as_str()), (0, "pen\n", ""));
    assert_eq!(place.run(&["config", "set", "surface", "-61.5"]).0, 0);
    assert_eq!(
        place.run(&["config", "set", "draw.travel-speed", "150"]).0,
        0
    );
    assert_eq!(
        place.text(),
        "tool = \"pen\"\nsurface = -61.5\n\n[draw]\ntravel_speed = 150\n"
    );
    assert_eq!(place.run(&["config", "get", "surface"]).1, "-61.5\n");
    assert_eq!(place.run(&["config", "unset", "tool"]).0, 0);
    assert!(!place.text().contains("tool"));
    let (_, out, _) = place.run(&["config"]);
    assert!(out.contains("surface") && out.contains("-61.5"), "{out}");
    assert!(out.contains(&place.path().display().to_string()), "{out}");
}

#[test]
fn a_flag_goes_before_the_environment_and_that_before_the_file() {
    let place = Place::with("port = \"tcp:127.0.0.1:1\"\n");
    let mut file = place.command(&["--json", "pose"]);
    let (status, _, err) = outcome(&mut file);
    assert_eq!(status, 4, "{err}");
    assert!(err.contains("127.0.0.1 port 1"), "{err}");
    let mut environment = place.command(&["pose"]);
    environment.env("MAGICIAN_PORT", "sim");
    assert_eq!(outcome(&mut environment).0, 0);
    let mut flag = place.command(&["--port", "sim", "pose"]);
    flag.env("MAGICIAN_PORT", "tcp:127.0.0.1:1");
    assert_eq!(outcome(&mut flag).0, 0);
    let mut shown = place.command(&["--json", "config", "get", "port"]);
    shown.env("MAGICIAN_PORT", "sim");
    let (_, out, _) = outcome(&mut shown);
    let shown: Value = serde_json::from_str(&out).expect("an object");
    assert_eq!(
        shown,
        json!({"key": "port", "value": "sim", "source": "environment"})
    );
    // An empty variable counts as not set.
    let mut empty = place.command(&["--json", "config", "get", "port"]);
    empty.env("MAGICIAN_PORT", "");
    assert!(outcome(&mut empty).1.contains("127.0.0.1:1"));
}

#[test]
fn every_verb_takes_the_port_of_the_file() {
    let place = Place::with("port = \"sim\"\n");
    for arguments in [
        &["pose"][..],
        &["home"],
        &["queue"],
        &["move", "220", "0", "0"],
        &["doctor", "--yes"],
    ] {
        let (status, _, err) = place.run(arguments);
        assert_eq!(status, 0, "{arguments:?}: {err}");
    }
}

#[test]
fn a_broken_file_is_told_with_its_place_by_whoever_depends_on_it() {
    let place = Place::with("# mine\nprot = \"sim\"\n");
    let (status, _, err) = place.run(&["pose"]);
    assert_eq!(status, 3);
    for part in [
        "unknown setting `prot`",
        "config.toml:2:1",
        "did you mean `port`?",
        "^^^^",
    ] {
        assert!(err.contains(part), "{part}: {err}");
    }
    let (status, _, err) = place.run(&["--json", "pose"]);
    let error: Value = serde_json::from_str(&err).expect("an object");
    assert_eq!(status, 3);
    assert_eq!(error["error"]["kind"], "invalid-input");
    let message = error["error"]["message"].as_str().expect("text");
    assert!(message.contains("line 2, column 1"), "{message}");
    assert_eq!(place.run(&["config", "set", "tool", "pen"]).0, 3);
    assert_eq!(place.text(), "# mine\nprot = \"sim\"\n");
    // Verbs that do not use the settings still work.
    assert_eq!(place.run(&["forward", "0", "45", "45", "0"]).0, 0);
}

#[test]
fn mistakes_are_usage_and_change_nothing() {
    let place = Place::new();
    for arguments in [
        &["config", "set", "prot", "sim"][..],
        &["config", "set", "port", "nowhere"],
        &["config", "set", "window", "9"],
        &["config", "set", "sheet", "1"],
        &["config", "get", "speed"],
        &["config", "unset", "speed"],
    ] {
        assert_eq!(place.run(arguments).0, 2, "{arguments:?}");
    }
    assert!(!Path::new(&place.path()).exists());
}

#[cfg(unix)]
#[test]
fn a_file_that_is_a_link_stays_one() {
    let place = Place::new();
    let real = place.dir.path().join("real.toml");
    std::fs::write(&real, "# mine\n").expect("written");
    std::os::unix::fs::symlink(&real, place.path()).expect("a link");
    assert_eq!(place.run(&["config", "set", "port", "sim"]).0, 0);
    assert!(place.path().is_symlink());
    let text = std::fs::read_to_string(&real).expect("a file");
    assert_eq!(text, "# mine\nport = \"sim\"\n");
}
