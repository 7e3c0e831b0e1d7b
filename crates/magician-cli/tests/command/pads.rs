//! `magician jog`, `teach` and `watch` at a terminal.
#![cfg(target_os = "linux")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::magician::homed::mark_homed;
use crate::magician::served::Served;
use crate::magician::terminal::Terminal;
use crate::magician::{command, run, run_with};
use magician_program::{Action, Content, Format, Plan, ReadOptions, Tool};
use serde_json::{Value, json};

const UP: &str = "\x1b[A";
const LEFT: &str = "\x1b[D";

/// Virtual arm at real speed in another process, and a program connected to it.
struct Fixture {
    served: Served,
    terminal: Terminal,
}

impl Fixture {
    fn at(arguments: &[&str], shown: &str) -> Self {
        Self::within(Path::new("."), arguments, shown)
    }

    /// Creates a place whose program runs in this directory.
    fn within(dir: &Path, arguments: &[&str], shown: &str) -> Self {
        let served = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "1"], 1);
        mark_homed(command(), &served.endpoint("tcp"));
        let mut command = command();
        command
            .args(["--port", &served.endpoint("tcp")])
            .args(arguments)
            .current_dir(dir);
        let mut terminal = Terminal::running(command);
        terminal.until("\x1b[?1049h");
        terminal.until_drawn("link up");
        let mut fixture = Self { served, terminal };
        fixture.shows("", shown);
        fixture
    }

    /// Reads the arm's state as another program.
    fn look(&self, arguments: &[&str]) -> Value {
        let endpoint = self.served.endpoint("tcp");
        run(&[&["--port", &endpoint, "--json"], arguments].concat()).object()
    }

    fn axis(&self, name: &str) -> f64 {
        self.look(&["pose"])[name].as_f64().expect("a number")
    }

    /// Types keys and waits for their effect.
    fn shows(&mut self, keys: &str, text: &str) {
        self.terminal.types(keys);
        self.terminal.until_drawn(text);
    }

    /// Waits until the arm stands.
    fn stands(&self) {
        let stands = (0..1000).any(|_| self.look(&["pose"]) == self.look(&["pose"]));
        assert!(stands, "it moves on");
    }

    /// Waits for the end of the program. Asserts its status and message.
    fn ends(mut self, status: i32, said: &str) {
        self.terminal.until("\x1b[?1049l");
        self.terminal.until("\x1b[?25h");
        self.terminal.until(said);
        let ended = self.terminal.child.wait().expect("it ends");
        assert_eq!(ended.code(), Some(status));
    }
}

#[test]
fn jog_steps_and_refuses_unreachable_targets() {
    let mut fixture = Fixture::at(&["jog"], "x 259.10");
    fixture.terminal.types(UP);
    fixture.terminal.until_drawn("command 2 finished");
    assert!((fixture.axis("x") - 264.104).abs() < 0.001);
    fixture.shows("++", "step 50 mm");
    fixture.terminal.types(UP);
    fixture.terminal.until_drawn("x 314.10 mm");
    fixture.terminal.until_drawn("stands");
    fixture.shows(UP, "is out of reach");
    assert!((fixture.axis("x") - 314.104).abs() < 0.001);
    fixture.shows("?", "stop all motion");
    fixture.terminal.types("xq");
    fixture.ends(0, "left at: x  314.10");
}

#[test]
fn jog_continues_only_while_the_key_repeats() {
    let mut fixture = Fixture::at(&["jog"], "x 259.10");
    fixture.shows("m", "hold: moves while held");
    // A terminal without release events repeats a held key.
    let moved = (0..1000).any(|_| {
        fixture.terminal.types(LEFT);
        fixture.axis("y") > 5.0
    });
    assert!(moved, "the arm does not move");
    fixture.stands();
    let y = fixture.axis("y");
    assert!(y > 5.0 && y < 200.0, "{y}");
    // The speed is restored.
    fixture.shows(".", "speed 75 %");
    let ratio =
        |fixture: &Fixture| fixture.look(&["get", "JOGCommonParams"])["velocity_ratio"].clone();
    assert_eq!(ratio(&fixture), 75.0);
    fixture.terminal.types("q");
    fixture.terminal.until("left at:");
    assert_eq!(ratio(&fixture), 50.0);
}

#[test]
fn key_releases_end_a_jog_if_the_terminal_reports_them() {
    let mut fixture = Fixture::at(&["jog"], "x 259.10");
    // The release of another key shows that releases are reported; then the key is held without
    // further events.
    fixture.shows("m\x1b[120;1:3u", "hold: moves until release");
    fixture.terminal.types("\x1b[1;1:1D");
    let moved = (0..1000).any(|_| fixture.axis("y") > 20.0);
    assert!(moved, "the arm does not move on while the key is held");
    fixture.terminal.types("\x1b[1;1:3D");
    fixture.stands();
    fixture.terminal.types("\x1b[1;1:1C");
    let moved = (0..1000).any(|_| fixture.axis("y") < 15.0);
    assert!(moved, "the arm does not move back");
    // The window loses the focus, so the release will not be seen.
    fixture.terminal.types("\x1b[O");
    fixture.stands();
    // A suspended program could not end a jog, so it ends the jog and is not suspended.
    fixture.terminal.types("\x1b[1;1:1D");
    let y = fixture.axis("y");
    let moved = (0..1000).any(|_| fixture.axis("y") > y + 5.0);
    assert!(moved, "the arm does not move again");
    let id = fixture.terminal.child.id().to_string();
    let told = Command::new("kill").args(["-TSTP", &id]).status();
    assert!(told.expect("kill runs").success());
    fixture.stands();
    fixture.terminal.types("q");
    fixture.ends(0, "left at:");
}

#[test]
fn leaving_the_pad_switches_the_laser_off() {
    let mut fixture = Fixture::at(&["jog"], "x 259.10");
    fixture.shows("l", "goggles");
    fixture.shows("y", "the laser burns");
    assert_eq!(fixture.look(&["get", "EndEffectorLaser"])["is_on"], 1);
    fixture.terminal.types("q");
    fixture.terminal.until("left at:");
    assert_eq!(fixture.look(&["get", "EndEffectorLaser"])["is_on"], 0);
    fixture.ends_with(0);
}

#[test]
fn leaving_the_pad_reports_active_suction() {
    for (pad, keys, status) in [("jog", "q", 0), ("jog", "\x03", 130), ("teach", "q", 0)] {
        let mut fixture = Fixture::at(&[pad], "x 259.10");
        fixture.shows("p", "suction on");
        fixture.terminal.types(keys);
        let note = "the suction cup is still on (`magician suction off` switches it off)";
        fixture.terminal.until_seen(note);
        assert_eq!(
            fixture.look(&["get", "EndEffectorSuctionCup"])["is_sucked"],
            1
        );
        fixture.ends_with(status);
    }
}

#[test]
fn ctrl_c_and_signals_stop_the_arm() {
    for signal in [None, Some("-TERM"), Some("-HUP")] {
        let mut fixture = Fixture::at(&["jog"], "x 259.10");
        fixture.shows("++", "step 50 mm");
        let before = fixture.look(&["pose"]);
        fixture.terminal.types("w");
        let moves = (0..1000).any(|_| fixture.look(&["pose"]) != before);
        assert!(moves, "the step does not begin");
        match signal {
            None => fixture.terminal.types("\x03"),
            Some(signal) => {
                let id = fixture.terminal.child.id().to_string();
                let kill = Command::new("kill").args([signal, &id]).status();
                assert!(kill.expect("kill runs").success());
            }
        }
        fixture.terminal.until("\x1b[?1049l");
        fixture.terminal.until("the arm stands at x ");
        assert_eq!(fixture.look(&["pose"]), fixture.look(&["pose"]));
        fixture.ends_with(130);
    }
}

impl Fixture {
    fn ends_with(mut self, status: i32) {
        let ended = self.terminal.child.wait().expect("it ends");
        assert_eq!(ended.code(), Some(status));
    }
}

#[test]
fn lost_arm_is_reported_and_the_pad_can_be_left() {
    let mut fixture = Fixture::at(&["jog"], "x 259.10");
    fixture.served.child.kill().expect("it lives");
    fixture.terminal.until_drawn("the line broke");
    fixture.shows("", "LINK LOST, reconnecting");
    fixture.terminal.types("\x03");
    fixture.terminal.until("\x1b[?1049l");
    fixture.ends_with(130);
}

/// Returns the plan of a taught file.
fn taught(path: &Path) -> Plan {
    let bytes = std::fs::read(path).expect("a file");
    let format = Format::of(&path.to_string_lossy(), &bytes).expect("a format");
    let reading = magician_program::read(format, &bytes, &ReadOptions::default());
    match reading.expect("it reads back").content {
        Content::Plan(plan) => plan,
        other => panic!("{other:?}"),
    }
}

#[test]
fn teach_stores_points_plays_them_and_saves_them() {
    for name in ["pick.playback", "pick.plan.json"] {
        let dir = tempfile::tempdir().expect("directory");
        let path = dir.path().join(name);
        let file = path.to_str().expect("UTF-8");
        let rescue = dir.path().join(format!("{name}~"));
        let mut fixture = Fixture::at(&["teach", file, "--tool", "suction"], "x 259.10");
        fixture.shows("\r", "P1 stored");
        fixture.terminal.types(UP);
        fixture.terminal.until_drawn("x 264.10");
        fixture.terminal.until_drawn("stands");
        fixture.shows("\rt", "2 rows");
        fixture.shows("SP0.5\r", "MOVL 264.1 0.0 -8.5 suck 0.5s");
        fixture.shows("nput\x7f\x7f\x7f\x7f\x7ftake\r", "take MOVL");
        assert_eq!(
            Plan::from_json(&std::fs::read(&rescue).expect("kept"))
                .expect("a plan")
                .steps
                .len(),
            4
        );
        fixture.shows("O", "play");
        fixture.terminal.until_drawn("played");
        assert_eq!(
            fixture.look(&["get", "EndEffectorSuctionCup"])["is_sucked"],
            1
        );
        fixture.shows("\x13", "saved to");
        assert!(!rescue.exists());
        fixture.terminal.types("q");
        fixture.ends(0, ": 2 rows");
        let plan = taught(&path);
        let moves: Vec<_> = plan
            .steps
            .iter()
            .filter_map(|step| step.action.target())
            .collect();
        assert_eq!(moves.len(), 2);
        assert!((moves[0][0] - 259.104).abs() < 0.001 && (moves[1][0] - 264.104).abs() < 0.001);
        assert_eq!(plan.tool, Some(Tool::Suction));
        let last = plan.steps.last().expect("a step");
        assert_eq!(
            (plan.name_of(&last.origin), &last.action),
            (Some("take"), &Action::Wait(500))
        );
        assert_eq!(std::fs::read_dir(dir.path()).expect("read").count(), 1);
    }
}

#[test]
fn unsaved_points_are_offered_at_the_next_start() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("pick.playback");
    let file = path.to_str().expect("UTF-8");
    let mut fixture = Fixture::at(&["teach", file], "x 259.10");
    fixture.shows("\r", "P1 stored");
    let id = fixture.terminal.child.id().to_string();
    let kill = Command::new("kill").args(["-KILL", &id]).status();
    assert!(kill.expect("kill runs").success());
    let mut fixture = Fixture::at(&["teach", file], "left unsaved last time");
    fixture.shows("y", "1 rows");
    fixture.shows("q", "not saved. Save it?");
    fixture.terminal.types("y");
    fixture.ends(0, ": 1 rows");
    assert_eq!(
        taught(&path)
            .steps
            .iter()
            .filter(|step| step.action.target().is_some())
            .count(),
        1
    );
    // Left without saving, the unsaved lesson is gone.
    let mut fixture = Fixture::at(&["teach", file], "P1 MOVJ");
    fixture.shows("x", "0 rows");
    fixture.terminal.types("qn");
    fixture.ends(0, "nothing was saved");
    assert_eq!(std::fs::read_dir(dir.path()).expect("read").count(), 1);
}

#[test]
fn lesson_continues_with_its_tool() {
    let dir = tempfile::tempdir().expect("directory");
    let path = dir.path().join("pick.playback");
    let file = path.to_str().expect("UTF-8");
    let mut fixture = Fixture::at(&["teach", file], "x 259.10");
    fixture.shows("\r", "P1 stored");
    let id = fixture.terminal.child.id().to_string();
    let kill = Command::new("kill").args(["-KILL", &id]).status();
    assert!(kill.expect("kill runs").success());
    let arguments = ["teach", file, "--tool", "pen"];
    let mut fixture = Fixture::at(&arguments, "left unsaved last time");
    fixture.shows("y", "the arm uses the tool that");
    fixture.shows("", "x 259.10");
    fixture.terminal.types("qy");
    let bias = fixture.look(&["get", "EndEffectorParams"]);
    assert_eq!(bias["x_bias"], 59.7);
    fixture.ends(0, ": 1 rows");
}

#[test]
fn unnamed_lesson_asks_for_a_name_and_overwrites_no_file() {
    let dir = tempfile::tempdir().expect("directory");
    let there = dir.path().join("there.plan.json");
    std::fs::write(&there, "mine").expect("written");
    let mut fixture = Fixture::within(dir.path(), &["teach"], "lesson.playback");
    fixture.shows("\r\x13", "save as");
    let erase = "\x7f".repeat("lesson.playback".len());
    fixture.shows(&format!("{erase}there.plan.json\r"), "already exists");
    fixture.shows("n", "1 rows");
    assert_eq!(std::fs::read_to_string(&there).expect("text"), "mine");
    fixture.shows(&format!("\x13{erase}there.plan.json\r"), "already exists");
    fixture.shows("y", "saved to");
    fixture.terminal.types("q");
    fixture.ends(0, ": 1 rows");
    assert_eq!(taught(&there).steps.len(), 1);
    assert_eq!(std::fs::read_dir(dir.path()).expect("read").count(), 1);
}

#[test]
fn releasing_the_unlock_key_stores_the_position() {
    let dir = tempfile::tempdir().expect("directory");
    let port = dir.path().join("arm");
    let port = port.to_str().expect("UTF-8");
    let mut sim = command();
    sim.args(["sim", "--pty", port, "--tui"]);
    let mut sim = Terminal::with_stdout(sim, Some(Stdio::piped()));
    sim.until_seen("from above");
    mark_homed(command(), port);
    let mut teach = command();
    teach
        .args(["--port", port, "teach"])
        .current_dir(dir.path());
    let mut teach = Terminal::running(teach);
    teach.until_drawn("link up");
    teach.until_drawn("by hand too");
    sim.types("u\x1b[A\x1b[A");
    sim.until_drawn("the unlock key is held");
    teach.until_drawn("x 269.10");
    sim.types("u");
    teach.until_drawn("P1 stored: the arm's key was released");
    teach.until_drawn("MOVJ 269.1 0.0 -8.5");
    teach.types("qn");
    teach.until("nothing was saved");
    assert_eq!(teach.child.wait().expect("it ends").code(), Some(0));
}

#[test]
fn watch_shows_a_moving_arm_without_affecting_it() {
    let mut fixture = Fixture::at(&["watch"], "x 259.10");
    let endpoint = fixture.served.endpoint("tcp");
    let moved = run(&["--port", &endpoint, "--json", "move", "220", "40", "30"]);
    assert_eq!(moved.status, 0, "{moved:?}");
    run(&["--port", &endpoint, "io", "mux", "6", "digital-output"]);
    run(&["--port", &endpoint, "io", "set", "6", "1"]);
    fixture.terminal.until_drawn("x 220.00 mm");
    fixture.terminal.until_drawn("done 2");
    fixture.terminal.until_drawn("6o●");
    fixture.terminal.until_drawn("tool stands");
    fixture.shows("?", "Nothing here moves");
    fixture.terminal.types("x");
    let before = fixture.look(&["queue"]);
    fixture.terminal.types("q");
    fixture.terminal.until("\x1b[?25h");
    assert_eq!(fixture.look(&["queue"]), before);
    fixture.ends_with(0);
}

#[test]
fn watch_prints_lines_without_a_terminal() {
    for (json, arguments) in [
        (true, &["--json", "watch"][..]),
        (false, &["watch", "--rate", "50"]),
    ] {
        let mut child = command()
            .args(["--port", "sim"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let mut lines = BufReader::new(child.stdout.take().expect("stdout")).lines();
        for _ in 0..3 {
            let line = lines.next().expect("a line").expect("UTF-8");
            if json {
                let state: Value = serde_json::from_str(&line).expect("JSON");
                assert_eq!(
                    (&state["j2"], &state["left_space"]),
                    (&json!(45.0), &json!(32))
                );
                assert_eq!(
                    (&state["alarms"], &state["link"]),
                    (&json!([0]), &json!("up"))
                );
            } else {
                assert!(line.contains("done 0 free 32 alarms 0x00"), "{line}");
            }
        }
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        assert_eq!(child.wait().expect("it ends").code(), Some(130));
    }
}

#[test]
fn one_step_needs_no_terminal() {
    let there = run(&["--port", "sim", "--json", "jog", "x", "10"]);
    assert_eq!(there.status, 0, "{there:?}");
    let x = there.object()["x"].as_f64().expect("a number");
    assert!((x - 269.104).abs() < 0.001, "{x}");
    let script = b"home\njog j1 -5\njog z 2.5\njog x 200\n";
    let script = run_with(&["--port", "sim", "--json", "shell"], script);
    let poses = script.objects();
    assert_eq!(poses[1]["j1"], -5.0);
    assert_eq!(script.status, 3);
    let error = script.error();
    assert_eq!(error["kind"], "unreachable");
    assert!(error["limit"].is_number() && error["value"].is_number());
    let railless = run(&["--port", "sim", "--json", "jog", "l", "10"]);
    assert_eq!(railless.error()["kind"], "invalid-input");
    let wrong = run(&["--port", "sim", "jog", "up", "10"]);
    assert_eq!(wrong.status, 2);
    assert!(wrong.err.contains("x, y, z, r"), "{}", wrong.err);
}

#[test]
fn pads_are_refused_without_a_terminal() {
    let refused = run(&["--port", "sim", "jog"]);
    assert_eq!((refused.status, refused.out.as_str()), (2, ""));
    assert!(refused.err.contains("jog x 10"), "{}", refused.err);
    let refused = run(&["--port", "sim", "teach", "a.playback"]);
    assert_eq!(refused.status, 2);
    let refused = run(&["--port", "sim", "teach", "a.svg"]);
    assert_eq!(refused.status, 2);
    assert!(refused.err.contains(".playback"), "{}", refused.err);
}
