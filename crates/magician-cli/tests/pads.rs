//! `magician jog`, `teach` and `watch` as a person at a terminal meets them.
#![cfg(target_os = "linux")]

mod magician;

use std::process::Command;

use magician::served::Served;
use magician::terminal::Terminal;
use magician::{command, run, run_with};
use serde_json::Value;

const UP: &str = "\x1b[A";
const LEFT: &str = "\x1b[D";

/// A virtual arm at real speed in another process, and a program at it.
struct Place {
    served: Served,
    terminal: Terminal,
}

impl Place {
    fn at(arguments: &[&str], shown: &str) -> Self {
        let served = Served::start(&["--tcp", "127.0.0.1:0", "--speed", "1"], 1);
        let mut command = command();
        command
            .args(["--port", &served.door("tcp")])
            .args(arguments);
        let mut terminal = Terminal::running(command);
        terminal.until("\x1b[?1049h");
        terminal.until_seen("link up");
        let mut place = Self { served, terminal };
        place.shows("", shown);
        place
    }

    /// Another program's look at the arm.
    fn look(&self, arguments: &[&str]) -> Value {
        let door = self.served.door("tcp");
        run(&[&["--port", &door, "--json"], arguments].concat()).object()
    }

    fn axis(&self, name: &str) -> f64 {
        self.look(&["pose"])[name].as_f64().expect("a number")
    }

    /// Types keys and sees what they come to. Only what changes is drawn, unless all of it is asked for, with Ctrl-L.
    fn shows(&mut self, keys: &str, text: &str) {
        self.terminal.types(keys);
        self.terminal.types("\x0c");
        self.terminal.until_seen(text);
    }

    /// Waits until the arm has been seen to stand.
    fn stands(&self) {
        let stands = (0..1000).any(|_| self.look(&["pose"]) == self.look(&["pose"]));
        assert!(stands, "it moves on");
    }

    /// Sees the program end with this status and say this.
    fn ends(mut self, status: i32, said: &str) {
        self.terminal.until("\x1b[?1049l");
        self.terminal.until("\x1b[?25h");
        self.terminal.until(said);
        let ended = self.terminal.child.wait().expect("it ends");
        assert_eq!(ended.code(), Some(status));
    }
}

#[test]
fn jog_steps_and_refuses_what_is_out_of_reach() {
    let mut place = Place::at(&["jog"], "x 199.40 mm");
    place.terminal.types(UP);
    place.terminal.until_seen("command 1 finished");
    assert!((place.axis("x") - 204.404).abs() < 0.001);
    place.shows("++", "step 50 mm");
    place.terminal.types(UP);
    place.terminal.until_drawn("x 254.40 mm");
    place.terminal.until_drawn("stands");
    place.shows(UP, "limit 282.0 mm");
    assert!((place.axis("x") - 254.404).abs() < 0.001);
    place.shows("?", "stop, whatever moves");
    place.terminal.types("xq");
    place.ends(0, "left at: x  254.40");
}

#[test]
fn jog_goes_on_while_the_key_repeats_and_stops_when_it_does_not() {
    let mut place = Place::at(&["jog"], "x 199.40 mm");
    place.shows("m", "hold: moves while held");
    // What a terminal without releases makes of a held key.
    let moved = (0..1000).any(|_| {
        place.terminal.types(LEFT);
        place.axis("y") > 5.0
    });
    assert!(moved, "the arm does not move");
    place.stands();
    let y = place.axis("y");
    assert!(y > 5.0 && y < 200.0, "{y}");
    // The speed is given back.
    place.shows(".", "speed 75 %");
    let ratio = |place: &Place| place.look(&["get", "JOGCommonParams"])["velocity_ratio"].clone();
    assert_eq!(ratio(&place), 75.0);
    place.terminal.types("q");
    place.terminal.until("left at:");
    assert_eq!(ratio(&place), 50.0);
}

#[test]
fn releases_end_a_jog_where_the_terminal_tells_them() {
    let mut place = Place::at(&["jog"], "x 199.40 mm");
    // A release of another key shows that they are told; then the key is held, and the terminal says nothing more.
    place.shows("m\x1b[120;1:3u", "hold: moves until release");
    place.terminal.types("\x1b[1;1:1D");
    let moved = (0..1000).any(|_| place.axis("y") > 20.0);
    assert!(moved, "the arm does not move on while the key is held");
    place.terminal.types("\x1b[1;1:3D");
    place.stands();
    place.terminal.types("\x1b[1;1:1C");
    let moved = (0..1000).any(|_| place.axis("y") < 15.0);
    assert!(moved, "the arm does not move back");
    // The window loses the focus: nobody sees the release.
    place.terminal.types("\x1b[O");
    place.stands();
    place.terminal.types("q");
    place.ends(0, "left at:");
}

#[test]
fn ctrl_c_and_signals_stop_the_arm() {
    for signal in [None, Some("-TERM"), Some("-HUP")] {
        let mut place = Place::at(&["jog"], "x 199.40 mm");
        place.shows("++", "step 50 mm");
        let before = place.look(&["pose"]);
        place.terminal.types("w");
        let moves = (0..1000).any(|_| place.look(&["pose"]) != before);
        assert!(moves, "the step does not begin");
        match signal {
            None => place.terminal.types("\x03"),
            Some(signal) => {
                let id = place.terminal.child.id().to_string();
                let kill = Command::new("kill").args([signal, &id]).status();
                assert!(kill.expect("kill runs").success());
            }
        }
        place.terminal.until("\x1b[?1049l");
        place.terminal.until("the arm stands at x ");
        assert_eq!(place.look(&["pose"]), place.look(&["pose"]));
        place.ends_with(130);
    }
}

impl Place {
    fn ends_with(mut self, status: i32) {
        let ended = self.terminal.child.wait().expect("it ends");
        assert_eq!(ended.code(), Some(status));
    }
}

#[test]
fn an_arm_that_goes_away_is_said_and_can_be_left() {
    let mut place = Place::at(&["jog"], "x 199.40 mm");
    place.served.child.kill().expect("it lives");
    place.terminal.until_seen("the line broke");
    place.shows("", "LINK LOST, looking for it");
    place.terminal.types("\x03");
    place.terminal.until("\x1b[?1049l");
    place.ends_with(130);
}

#[test]
fn one_step_needs_no_terminal() {
    let there = run(&["--port", "sim", "--json", "jog", "x", "10"]);
    assert_eq!(there.status, 0, "{there:?}");
    let x = there.object()["x"].as_f64().expect("a number");
    assert!((x - 209.404).abs() < 0.001, "{x}");
    let script = b"home\njog j1 -5\njog z 2.5\njog x 200\n";
    let script = run_with(&["--port", "sim", "--json", "shell"], script);
    let poses = script.objects();
    assert_eq!(poses[1]["j1"], -5.0);
    assert_eq!(script.status, 3);
    let error = script.error();
    assert_eq!(error["kind"], "unreachable");
    assert!(error["limit"].is_number() && error["value"].is_number());
    let wrong = run(&["--port", "sim", "jog", "up", "10"]);
    assert_eq!(wrong.status, 2);
    assert!(wrong.err.contains("x, y, z, r"), "{}", wrong.err);
}

#[test]
fn pads_are_refused_without_a_person() {
    let refused = run(&["--port", "sim", "jog"]);
    assert_eq!((refused.status, refused.out.as_str()), (2, ""));
    assert!(refused.err.contains("jog x 10"), "{}", refused.err);
}
