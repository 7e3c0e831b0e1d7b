//! `magician proxy`: an arm shared by several programs.
#![cfg(unix)]

use crate::magician;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;

use crate::magician::run;
use crate::magician::served::Served;
use ::magician::commands::JogCmd;
use ::magician::protocol::{Ctrl, Flag, FrameBuf, JogCommand, Writable};
use serde_json::{Value, json};

/// Directory with paths for an arm and two programs.
struct Desk {
    dir: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("directory");
        Self { dir }
    }

    fn path(&self, name: &str) -> String {
        self.dir
            .path()
            .join(name)
            .to_str()
            .expect("UTF-8")
            .to_owned()
    }

    fn arm(&self) -> Served {
        let path = self.path("arm");
        Served::start(&["--pty", &path, "--speed", "max"], 1)
    }

    /// Starts a proxy for the arm with two pseudo-terminals.
    fn proxy(&self, more: &[&str]) -> Served {
        let [arm, a, b] = ["arm", "A", "B"].map(|name| self.path(name));
        let arguments = [&["--port", &arm, "--pty", &a, "--pty", &b], more].concat();
        Served::verb("proxy", &arguments, 3)
    }
}

fn pose(port: &str) -> Value {
    run(&["--port", port, "pose", "--json"]).object()
}

fn objects(said: &str) -> Vec<Value> {
    said.lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}")))
        .collect()
}

#[test]
fn two_programs_share_an_arm() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let trace = desk.path("trace.pcapng");
    let proxy = desk.proxy(&["--trace", &trace, "--tcp", "127.0.0.1:0"]);
    let [a, b] = ["A", "B"].map(|name| desk.path(name));
    assert_eq!(run(&["--port", &a, "move", "220", "40", "30"]).status, 0);
    let stands = pose(&b);
    assert_eq!((&stands["x"], &stands["z"]), (&json!(220.0), &json!(30.0)));
    let (status, rest, said) = proxy.end_telling("-TERM");
    assert_eq!((status.code(), rest.as_str()), (Some(0), ""));
    assert!(!Path::new(&a).is_symlink() && !Path::new(&b).is_symlink());
    let told = |who: &str, what: &str| {
        said.lines()
            .any(|line| line.contains(who) && line.contains(what))
    };
    assert!(
        told(&a, "request    SetPTPCmd  queued  ptp_mode="),
        "{said}"
    );
    assert!(
        told(&a, "reply      SetPTPCmd  queued  queued_cmd_index="),
        "{said}"
    );
    assert!(told(&b, "reply      GetPose  x=220 y=40"), "{said}");
    assert!(!told(&b, "SetPTPCmd"), "{said}");

    let decoded = run(&["decode", "--json", &trace]);
    assert_eq!(decoded.status, 0);
    let links: std::collections::BTreeSet<String> = (decoded.objects().iter())
        .map(|packet| packet["link"].as_str().expect("named").to_owned())
        .collect();
    let arm = format!("arm {}", desk.path("arm"));
    assert_eq!(links.into_iter().collect::<Vec<_>>(), [a, b, arm]);
}

/// Program that sends one request and waits for the answer without a limit.
struct Patient(File);

impl Patient {
    fn at(path: &str) -> Self {
        let line = File::options().read(true).write(true).open(path);
        Self(line.expect("it opens"))
    }

    /// Returns the answer to GetPose.
    fn pose(&mut self) -> [u8; 38] {
        let get_pose = FrameBuf::new(10, Ctrl::GET, &[]).expect("a frame");
        self.0.write_all(get_pose.bytes()).expect("written");
        let mut answer = [0; 38];
        self.0.read_exact(&mut answer).expect("an answer");
        answer
    }
}

#[test]
fn programs_at_the_same_time_do_not_disturb_each_other() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let proxy = desk.proxy(&["--json", "--only", "GetPose,PTPCmd"]);
    let [a, b] = ["A", "B"].map(|name| desk.path(name));
    let mut watcher = Patient::at(&b);
    let watcher = std::thread::spawn(move || (0..10).map(|_| watcher.pose()).collect::<Vec<_>>());
    for x in ["220", "230", "240", "250"] {
        assert_eq!(run(&["--port", &a, "move", x, "0", "30", "0"]).status, 0);
    }
    let watched = watcher.join().expect("every pose was answered");
    // Id and Ctrl of the reply.
    assert!(watched.iter().all(|pose| pose[3..5] == [10, 0]));
    let said = objects(&proxy.end_telling("-TERM").2);
    let count = |link: &str, event: &str, command: &str| {
        let counts = |object: &&Value| {
            object["link"] == *link && object["event"] == event && object["command"] == command
        };
        said.iter().filter(counts).count()
    };
    let passed = |link, command| ["request", "reply"].map(|event| count(link, event, command));
    assert_eq!(passed(&b, "GetPose"), [10, 10]);
    // On a slow machine the command repeats reads, but never queued commands.
    assert_eq!(passed(&a, "SetPTPCmd"), [4, 4]);
    let frames = said.iter().filter(|object| !object["command"].is_null());
    let mut commands: Vec<&str> = frames
        .filter_map(|object| object["command"].as_str())
        .collect();
    commands.sort_unstable();
    commands.dedup();
    assert_eq!(commands, ["GetPose", "SetPTPCmd"]);
}

#[test]
fn the_lines_before_ready_are_objects_too() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let proxy = desk.proxy(&["--json", "--quiet", "--udp", "127.0.0.1:0"]);
    let first = objects(&proxy.endpoints.join("\n"));
    assert_eq!(first[0], json!({"event": "proxy", "arm": desk.path("arm")}));
    assert_eq!(
        first[1],
        json!({"event": "serving", "endpoint": desk.path("A")})
    );
    assert!(pose(&desk.path("A"))["x"].is_f64());
    let said = objects(&proxy.end_telling("-TERM").2);
    assert_eq!(said.len(), 1, "the third door and nothing else: {said:?}");
}

#[test]
fn interrupt_exits_with_130() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let (status, rest) = desk.proxy(&[]).end("-INT");
    assert_eq!((status.code(), rest.as_str()), (Some(130), ""));
}

#[test]
fn failed_endpoint_is_an_error_and_leaves_no_files() {
    let twins = run(&["proxy", "--port", "sim", "--pty", "./A", "--pty", "./A"]);
    assert_eq!(twins.status, 2, "{twins:?}");
    assert!(twins.err.contains("twice"), "{twins:?}");
    let desk = Desk::new();
    let _arm = desk.arm();
    let [arm, taken, free] = ["arm", "taken", "free"].map(|name| desk.path(name));
    std::fs::write(&taken, "mine").expect("written");
    let occupied = run(&[
        "proxy", "--port", &arm, "--pty", &free, "--pty", &taken, "--json",
    ]);
    assert_eq!((occupied.status, occupied.out.as_str()), (4, ""));
    assert_eq!(occupied.error()["kind"], "port");
    assert!(!Path::new(&free).is_symlink());
    assert_eq!(std::fs::read_to_string(&taken).expect("left alone"), "mine");

    let without = run(&["proxy", "--port", &arm]);
    assert_eq!((without.status, without.out.as_str()), (2, ""));
    let unknown = run(&[
        "proxy", "--port", &arm, "--pty", &free, "--only", "Teleport",
    ]);
    assert_eq!(unknown.status, 2);
    let nowhere = run(&["proxy", "--port", &desk.path("nowhere"), "--pty", &free]);
    assert_eq!((nowhere.status, nowhere.out.as_str()), (4, ""));

    let _first = desk.proxy(&[]);
    let second = run(&["proxy", "--port", &arm, "--pty", &free]);
    assert_eq!((second.status, second.out.as_str()), (4, ""));
    assert!(second.err.contains("in use"), "{second:?}");
}

#[test]
fn lost_line_is_reconnected_while_programs_stay() {
    let desk = Desk::new();
    let arm = desk.arm();
    let mut proxy = desk.proxy(&[]);
    let mut program = Patient::at(&desk.path("A"));
    let before = program.pose();
    drop(arm);
    proxy.until(|line| line.contains("broke off"));
    // There is no answer now, and none later to requests that are sent now.
    assert_ne!(
        run(&["--port", &desk.path("B"), "--timeout", "0.2", "pose"]).status,
        0
    );
    let _arm = desk.arm();
    proxy.until(|line| line.contains("is back"));
    assert_eq!(program.pose(), before);
}

#[test]
fn jog_ends_with_its_program() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let begin = JogCmd {
        is_joint: Flag::ON,
        cmd: JogCommand::Axis1Plus,
    };
    let begin = FrameBuf::encode(JogCmd::ROW.id, Ctrl::SET, &begin).expect("a frame");
    let jog = |proxy: &mut Served| {
        let Patient(mut program) = Patient::at(&desk.path("A"));
        program.write_all(begin.bytes()).expect("written");
        proxy.until(|line| line.contains("reply      SetJOGCmd"));
        program
    };
    let own = |line: &str| {
        line.contains("proxy") && line.contains("own        SetJOGCmd  is_joint=1 cmd=0")
    };
    let mut proxy = desk.proxy(&[]);
    drop(jog(&mut proxy));
    proxy.until(own);
    // The same when the proxy itself ends.
    let _program = jog(&mut proxy);
    let (status, _, said) = proxy.end_telling("-TERM");
    assert_eq!(status.code(), Some(0));
    assert_eq!(said.lines().filter(|line| own(line)).count(), 2, "{said}");
    assert!(!said.contains("did not confirm"), "{said}");
}

#[test]
fn faults_disturb_a_line() {
    let desk = Desk::new();
    let _arm = desk.arm();
    let proxy = desk.proxy(&["--faults", "drop=1,only=replies,seed=7"]);
    let asked = run(&[
        "--port",
        &desk.path("A"),
        "--timeout",
        "1.5",
        "pose",
        "--json",
    ]);
    assert_eq!((asked.status, asked.out.as_str()), (5, ""), "{asked:?}");
    let said = proxy.log();
    assert!(
        said.iter().any(|line| line.contains("unanswered")),
        "{said:?}"
    );
    let wrong = run(&[
        "proxy",
        "--port",
        "sim",
        "--pty",
        &desk.path("C"),
        "--faults",
        "flop=1",
    ]);
    assert_eq!(wrong.status, 2, "{wrong:?}");
}

#[test]
fn a_trace_of_a_proxy_is_replayed_once_and_agrees_with_the_arms_own() {
    let desk = Desk::new();
    let [own, between] = ["own.pcapng", "between.pcapng"].map(|name| desk.path(name));
    let arm = desk.path("arm");
    let served = Served::start(&["--pty", &arm, "--speed", "max", "--trace", &own], 1);
    let proxy = desk.proxy(&["--trace", &between]);
    let script = b"alarms --clear\nmove 220 40 30 0\npose\nmove 220 -40 30 0\npose\n";
    let done = magician::run_with(&["--port", &desk.path("A"), "shell"], script);
    assert_eq!(done.status, 0, "{done:?}");
    pose(&desk.path("B"));
    proxy.end("-TERM");
    served.end("-TERM");
    let counts = [&own, &between].map(|trace| {
        let replayed = run(&["replay", trace, "--clock", "max", "--json"]);
        assert_eq!(replayed.status, 0, "{replayed:?}");
        let told = replayed.objects();
        told.last().expect("a summary")["requests"].clone()
    });
    assert_eq!(counts[0], counts[1], "what the arm heard");
}
