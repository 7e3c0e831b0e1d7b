//! Site of several machines with separate state folders.
#![cfg(feature = "site")]

use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::magician::{Run, command};

struct Machines(TempDir);

impl Machines {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Returns `magician site` on a machine.
    fn command(&self, machine: &str, words: &[&str]) -> Command {
        let mut command = command();
        command.env("XDG_STATE_HOME", self.0.path().join(machine));
        command.env_remove("MAGICIAN_SITE");
        command.arg("site").args(words);
        command
    }

    fn site(&self, machine: &str, words: &[&str]) -> Run {
        Run::of(&mut self.command(machine, words), b"")
    }

    fn folder(&self, machine: &str) -> PathBuf {
        self.0.path().join(machine).join("magician/site/lab")
    }

    fn init(&self, machine: &str) -> Value {
        let made = self.site(machine, &["init", "lab", "--name", machine, "--json"]);
        assert_eq!(made.status, 0, "{made:?}");
        made.object()
    }

    fn invite(&self, machine: &str, words: &[&str]) -> Invited {
        let words = [&["invite", "--listen", "127.0.0.1:0", "--json"], words].concat();
        let mut child = { self.command(machine, &words) }
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdout = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        stdout.read_line(&mut line).unwrap();
        let invited: Value = serde_json::from_str(&line).unwrap_or_else(|_| panic!("{line}"));
        Invited {
            child,
            stdout,
            invited,
        }
    }
}

/// Pending invitation.
struct Invited {
    child: Child,
    stdout: BufReader<ChildStdout>,
    invited: Value,
}

impl Invited {
    fn code(&self) -> &str {
        self.invited["code"].as_str().unwrap()
    }

    /// Waits for its end. Returns its status and the events after the first.
    fn end(mut self) -> (i32, Vec<Value>) {
        let mut rest = String::new();
        self.stdout.read_to_string(&mut rest).unwrap();
        let events = rest.lines().map(|line| serde_json::from_str(line).unwrap());
        let events = events.collect();
        (self.child.wait().unwrap().code().unwrap(), events)
    }
}

impl Drop for Invited {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn site_is_created_once_with_advice_for_the_next_step() {
    let machines = Machines::new();
    let made = machines.site("desk", &["init", "lab", "--name", "desk"]);
    assert_eq!(made.status, 0, "{made:?}");
    for said in ["ca.key", "magician site invite lab", "this machine is desk"] {
        assert!(made.out.contains(said), "{said}: {made:?}");
    }
    assert!(machines.folder("desk").join("own.pem").exists());
    let again = machines.site("desk", &["init", "lab", "--name", "desk"]);
    assert_eq!(again.status, 3, "{again:?}");
    assert!(again.err.contains("magician site invite"), "{again:?}");
    let wrong = machines.site("desk", &["init", "other", "--name", "Desk 1"]);
    assert_eq!(wrong.status, 2, "{wrong:?}");
    assert!(wrong.err.contains("--name"), "{wrong:?}");
    assert_eq!(machines.site("desk", &["init", "Lab"]).status, 2);
}

#[test]
fn a_machine_joins_by_the_line_that_the_invitation_prints() {
    let machines = Machines::new();
    let made = machines.init("desk");
    let waiting = machines.invite("desk", &[]);
    let code = waiting.code().to_owned();
    assert_eq!(
        waiting.invited["line"],
        format!("magician site join {code}")
    );
    assert_eq!(waiting.invited["seconds"], 600);
    let joined = machines.site("bench", &["join", &code, "--name", "bench-2", "--json"]);
    assert_eq!(joined.status, 0, "{joined:?}");
    let joined = joined.object();
    assert_eq!(joined["machine"], "bench-2");
    assert_eq!(joined["site"], "lab");
    assert_eq!(joined["fingerprint"], made["fingerprint"]);
    assert_eq!(joined["renewed"], false);
    let (status, events) = waiting.end();
    assert_eq!(status, 0);
    assert_eq!(events.len(), 1, "{events:?}");
    assert_eq!(events[0]["event"], "joined");
    assert_eq!(events[0]["machine"], "bench-2");
    assert!(machines.folder("bench").join("own.pem").exists());

    // In lower case and without hyphens: a renewal, whatever the host's name.
    let waiting = machines.invite("desk", &["lab"]);
    let (address, symbols) = waiting.code().split_once('/').unwrap();
    let typed = format!("{address}/{}", symbols.to_lowercase().replace('-', ""));
    let renewed = machines.site("bench", &["join", &typed]);
    assert_eq!(renewed.status, 0, "{renewed:?}");
    assert!(renewed.out.contains("bench-2") && renewed.out.contains("renewed"));
    let (status, events) = waiting.end();
    assert_eq!((status, &events[0]["renewed"]), (0, &Value::Bool(true)));
}

#[test]
fn refused_machine_gets_advice() {
    let machines = Machines::new();
    machines.init("desk");
    let waiting = machines.invite("desk", &[]);
    let code = waiting.code().to_owned();
    let join = |code: &str, name: &str| machines.site("bench", &["join", code, "--name", name]);
    let taken = join(&code, "desk");
    assert_eq!(taken.status, 3, "{taken:?}");
    assert!(taken.err.contains("--name"), "{taken:?}");
    let last = code.chars().last().unwrap();
    let other = if last == '7' { '8' } else { '7' };
    let mistyped = format!("{}{other}", &code[..code.len() - 1]);
    let mistyped = join(&mistyped, "bench-2");
    assert_eq!(mistyped.status, 6, "{mistyped:?}");
    assert!(mistyped.err.contains("nothing secret was sent"));
    assert_eq!(join("no code", "bench-2").status, 2);
    // The mistyped code did not use up an attempt.
    assert_eq!(join(&code, "bench-2").status, 0);
    let (status, events) = waiting.end();
    assert_eq!(status, 0);
    let names: Vec<_> = events.iter().map(|event| &event["event"]).collect();
    assert_eq!(names, ["refused", "joined"], "{events:?}");
    assert_eq!(events[0]["reason"], "taken");
    // The invitation is over.
    let over = machines.site("other", &["join", &code, "--name", "other"]);
    assert_eq!(over.status, 4, "{over:?}");
    assert!(over.err.contains("magician site invite"), "{over:?}");
}

#[cfg(unix)]
#[test]
fn an_invitation_ends_by_ctrl_c() {
    let machines = Machines::new();
    machines.init("desk");
    let waiting = machines.invite("desk", &["--machines", "2"]);
    crate::magician::signal("-INT", &waiting.child);
    let (status, events) = waiting.end();
    assert_eq!(status, 130);
    assert!(events.is_empty(), "{events:?}");
}

#[test]
fn machines_are_listed_and_revoked() {
    let machines = Machines::new();
    let none = machines.site("desk", &["list"]);
    assert_eq!(none.status, 0, "{none:?}");
    assert!(none.out.contains("magician site init"), "{none:?}");
    machines.init("desk");
    let waiting = machines.invite("desk", &[]);
    let joined = machines.site("bench", &["join", waiting.code(), "--name", "bench-2"]);
    assert_eq!((joined.status, waiting.end().0), (0, 0));

    let list = |machine| {
        let listed = machines.site(machine, &["list", "lab", "--json"]).object();
        listed["sites"][0].clone()
    };
    let names = |site: &Value| {
        let machines = site["machines"].as_array().unwrap().iter();
        let names = machines.map(|one| (one["name"].clone(), one["revoked"].is_null()));
        names.collect::<Vec<_>>()
    };
    let desk = list("desk");
    assert_eq!(
        names(&desk),
        [("desk".into(), true), ("bench-2".into(), true)]
    );
    let bench = list("bench");
    assert_eq!(bench["machine"], "bench-2");
    assert_eq!(bench["machines"], Value::Null);
    assert_eq!(bench["fingerprint"], desk["fingerprint"]);

    let revoked = machines.site("desk", &["revoke", "bench-2"]);
    assert_eq!(revoked.status, 0, "{revoked:?}");
    assert!(machines.folder("desk").join("revoked.pem").exists());
    assert_eq!(
        names(&list("desk")),
        [("desk".into(), true), ("bench-2".into(), false)]
    );
    let listed = machines.site("desk", &["list"]);
    assert!(listed.out.contains("bench-2  revoked 2"), "{listed:?}");
    for (machine, words, status, said) in [
        ("desk", &["revoke", "bench-9"][..], 3, "site list"),
        ("desk", &["revoke", "desk"], 3, "cannot be revoked"),
        (
            "desk",
            &["revoke", "bench-2", "--site", "x"],
            3,
            "site list",
        ),
        ("bench", &["revoke", "desk"], 3, "site init"),
        ("bench", &["invite"], 3, "site init"),
        ("bench", &["list", "other"], 3, "site init"),
    ] {
        let refused = machines.site(machine, words);
        assert_eq!(refused.status, status, "{words:?} {refused:?}");
        assert!(refused.err.contains(said), "{words:?} {refused:?}");
    }
    // A revoked machine cannot return, neither by name nor by key.
    let waiting = machines.invite("desk", &[]);
    let back = machines.site("bench", &["join", waiting.code()]);
    assert_eq!(back.status, 3, "{back:?}");
    assert!(back.err.contains("revoked"), "{back:?}");
}
