//! Station that ends while a program runs its own work over it, on an arm that outlives both.
#![cfg(unix)]

use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

use crate::magician::drawing::{Fixture, PAPER, last};
use crate::magician::served::Served;
use crate::magician::{command, signal};

/// Starts a station for the arm of a place.
fn serve(fixture: &Fixture) -> (Served, String) {
    let mut serve = command();
    serve.env("XDG_STATE_HOME", fixture.dir.path().join("state"));
    let arguments = ["--port", &fixture.endpoint(), "--listen", "127.0.0.1:0"];
    let served = Served::of(serve, "serve", &arguments, 1);
    let url = served.endpoints[0]
        .trim_start_matches("serving ")
        .to_owned();
    (served, url)
}

/// Starts a program at a station.
fn client(mut command: Command) -> Child {
    command.arg("--json");
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("it starts")
}

fn draw(fixture: &Fixture, url: &str, more: &[&str]) -> Child {
    client(fixture.draw_at(&["--station", url], more))
}

/// Returns message and kind of a failure.
fn error(output: &Output) -> (String, Value) {
    let text = String::from_utf8_lossy(&output.stderr);
    let error = text.lines().last().unwrap_or_default();
    let error: Value = serde_json::from_str(error).unwrap_or_else(|_| panic!("{output:?}"));
    let message = error["error"]["message"].as_str().unwrap_or_default();
    (message.to_owned(), error["error"]["kind"].clone())
}

/// Moment of a drawing at which its station ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    /// The program is connected.
    BeforeFirstMove,
    /// The arm moves towards the paper.
    Approaching,
    /// The pen is on the paper.
    Drawing,
    /// All is drawn, and the pen is being lifted.
    Ending,
}

impl Moment {
    fn wait(self, fixture: &Fixture) {
        let height = || fixture.number("pose", "z") - PAPER;
        match self {
            Self::BeforeFirstMove => {}
            Self::Approaching => {
                let (x, y) = (fixture.number("pose", "x"), fixture.number("pose", "y"));
                while (fixture.number("pose", "x") - x).hypot(fixture.number("pose", "y") - y) < 1.0
                {
                }
            }
            Self::Drawing => fixture.until_drawn(2.0),
            Self::Ending => {
                fixture.until_drawn(2.0);
                while height() < 1.0 {}
            }
        }
    }
}

#[test]
fn drawing_at_an_ending_station_lifts_the_pen_and_restores_settings() {
    use Moment::{Approaching, BeforeFirstMove, Drawing, Ending};
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    for (name, moment) in [
        ("-TERM", Drawing),
        ("-HUP", Drawing),
        ("-INT", Drawing),
        ("-TERM", BeforeFirstMove),
        ("-HUP", Approaching),
        ("-INT", Ending),
    ] {
        assert!(fixture.run(&["move", "200", "-60", "0"]).status.success());
        let (served, url) = serve(&fixture);
        let drawing = draw(&fixture, &url, &["--lift", "30"]);
        moment.wait(&fixture);
        let (status, _, told) = served.end_telling(name);
        let output = drawing.wait_with_output().expect("it ends");
        let what = format!("{name} {moment:?}: {output:?} {told}");
        assert_eq!(status.code(), Some(0), "{what}");
        assert!(!told.contains("pen may be down"), "{what}");
        if moment != Ending || !output.status.success() {
            assert_eq!(output.status.code(), Some(4), "{what}");
            let (message, kind) = error(&output);
            assert_eq!(kind, "port", "{what}");
            if moment == BeforeFirstMove {
                assert!(message.contains("station"), "{what}");
            } else {
                assert!(message.contains("the station ended: "), "{what}");
                assert!(message.contains("the arm stands at x "), "{what}");
            }
            if moment == Drawing {
                assert!(message.contains("the pen is up by 30.0 mm"), "{what}");
            }
        }
        let up = fixture.number("pose", "z") - PAPER;
        assert!(up > 9.0, "{what}: {up} mm");
        assert_eq!(fixture.settings(), before, "{what}");
        assert_eq!(fixture.unrestored(), 0, "{what}");
        assert_eq!(last(&fixture.run(&["queue"]))["left_space"], 32, "{what}");
    }
}

#[test]
fn drawing_ended_by_its_station_resumes_where_it_stopped() {
    let fixture = Fixture::homed("5");
    let (served, url) = serve(&fixture);
    let drawing = draw(&fixture, &url, &[]);
    fixture.until_drawn(2.0);
    drop(served.end("-TERM"));
    let output = drawing.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    assert_eq!(fixture.journals(), 1);
    let (_served, url) = serve(&fixture);
    let again = draw(&fixture, &url, &["--resume"]).wait_with_output();
    let again = again.expect("it ends");
    assert!(again.status.success(), "{again:?}");
}

#[test]
fn ctrl_c_that_reaches_station_and_program_at_once_lifts_the_pen() {
    let fixture = Fixture::homed("5");
    let before = fixture.settings();
    for station_first in [true, false] {
        let (mut served, url) = serve(&fixture);
        let drawing = draw(&fixture, &url, &[]);
        fixture.until_drawn(2.0);
        let both = if station_first {
            [&served.child, &drawing]
        } else {
            [&drawing, &served.child]
        };
        for child in both {
            signal("-INT", child);
        }
        let output = drawing.wait_with_output().expect("it ends");
        assert!(matches!(output.status.code(), Some(4 | 130)), "{output:?}");
        assert_eq!(served.child.wait().expect("it ends").code(), Some(0));
        let up = fixture.number("pose", "z") - PAPER;
        assert!((up - 10.0).abs() < 0.5, "{station_first}: {up} mm");
        assert_eq!(fixture.settings(), before);
    }
}

#[test]
fn second_signal_ends_the_wait_of_a_station_and_stops_the_arm() {
    let fixture = Fixture::homed("0.3");
    let (mut served, url) = serve(&fixture);
    let drawing = draw(&fixture, &url, &["--lift", "60"]);
    fixture.until_drawn(2.0);
    // Signals in the first half second are ignored, and the next one counts: the lift takes
    // seconds.
    while served.child.try_wait().expect("a child").is_none() {
        signal("-INT", &served.child);
    }
    assert_eq!(served.child.wait().expect("it ends").code(), Some(130));
    let output = drawing.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let (message, _) = error(&output);
    assert!(message.starts_with("the station ended"), "{message}");
    assert!(!message.contains("pen is up"), "{message}");
    let stands = fixture.number("pose", "z");
    assert!(stands < PAPER + 59.0, "{stands}");
    assert_eq!(fixture.number("pose", "z"), stands);
    assert_eq!(last(&fixture.run(&["queue"]))["left_space"], 32);
}

#[test]
fn ending_station_stops_the_arm_of_a_hanging_program() {
    let fixture = Fixture::homed("5");
    let (served, url) = serve(&fixture);
    let mut drawing = draw(&fixture, &url, &[]);
    fixture.until_drawn(2.0);
    signal("-STOP", &drawing);
    let (status, _, told) = served.end_telling("-TERM");
    assert_eq!(status.code(), Some(0));
    let said =
        "arm was stopped while magician held it and did not stop it in time: a pen may be down";
    assert!(told.contains(said), "{told}");
    assert_eq!(last(&fixture.run(&["queue"]))["left_space"], 32);
    let stands = last(&fixture.run(&["pose"]));
    assert_eq!(last(&fixture.run(&["pose"])), stands);
    drawing.kill().expect("killed");
    drawing.wait().expect("it ends");
}

#[test]
fn program_of_a_killed_station_reports_an_unknown_arm_state() {
    let fixture = Fixture::homed("5");
    let (mut served, url) = serve(&fixture);
    let mut drawing = fixture.draw_at(&["--station", &url], &[]);
    drawing.stdout(Stdio::piped()).stderr(Stdio::piped());
    let drawing = drawing.spawn().expect("it starts");
    fixture.until_drawn(2.0);
    served.child.kill().expect("killed");
    let output = drawing.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr);
    for untrue in ["cable", "finishes its queue", "the station ended"] {
        assert!(!said.contains(untrue), "{said}");
    }
    assert!(
        said.contains("the connection to the station broke"),
        "{said}"
    );
    assert!(said.contains("the state of the arm is unknown"), "{said}");
}

#[test]
fn move_at_an_ending_station_is_stopped_and_reported() {
    let fixture = Fixture::homed("1");
    let (served, url) = serve(&fixture);
    let slow = [
        "set",
        "PTPCommonParams",
        "velocity_ratio=2",
        "acceleration_ratio=20",
    ];
    assert!(fixture.run(&slow).status.success());
    let at = ["--station", &url, "move", "200", "150", "50"];
    let mut verb = command();
    verb.args(at)
        .env("XDG_STATE_HOME", fixture.dir.path().join("state"));
    let before = fixture.number("pose", "y");
    let moving = client(verb);
    while (fixture.number("pose", "y") - before).abs() < 0.5 {}
    let (status, _) = served.end("-HUP");
    assert_eq!(status.code(), Some(0));
    let output = moving.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let (message, _) = error(&output);
    assert!(
        message.starts_with("the station ended: the arm stands at x "),
        "{message}"
    );
    assert!(fixture.number("pose", "y") < 149.0);
}

#[test]
fn commands_left_in_the_arm_by_an_earlier_program_are_dropped_as_the_station_ends() {
    let fixture = Fixture::homed("1");
    for set in ["QueuedCmdStopExec", "QueuedCmdClear"] {
        assert!(fixture.run(&["set", set, "--yes"]).status.success());
    }
    for y in ["10", "20", "30"] {
        let (fields, y) = (["x=210", "z=0", "r=0", "ptp_mode=1"], format!("y={y}"));
        let enqueue = [&["enqueue", "PTPCmd", &y][..], &fields[..], &["--yes"]].concat();
        let queued = fixture.run(&enqueue);
        assert!(queued.status.success(), "{queued:?}");
    }
    assert_ne!(last(&fixture.run(&["queue"]))["left_space"], 32);
    let (served, _) = serve(&fixture);
    let (status, _, told) = served.end_telling("-INT");
    assert_eq!(status.code(), Some(0), "{told}");
    assert_eq!(last(&fixture.run(&["queue"]))["left_space"], 32);
}

/// The refused drawing has changed nothing and left nothing to restore.
#[test]
fn second_drawing_at_a_station_is_refused_by_name_and_changes_no_settings() {
    let fixture = Fixture::homed("5");
    let (_served, url) = serve(&fixture);
    for _ in 0..3 {
        let both = [draw(&fixture, &url, &[]), draw(&fixture, &url, &[])];
        fixture.until_drawn(1.0);
        let [mut one, two] = both;
        let (refused, mut other) = match one.try_wait().expect("a child") {
            Some(_) => (one, two),
            None => (two, one),
        };
        let refused = refused.wait_with_output().expect("it ends");
        assert_eq!(refused.status.code(), Some(4), "{refused:?}");
        let (message, kind) = error(&refused);
        assert_eq!(message, "magician has the lease of arm");
        assert_eq!(kind, "port");
        assert_eq!(fixture.unrestored(), 1, "the living one's");
        signal("-INT", &other);
        other.wait().expect("it ends");
        assert_eq!(fixture.unrestored(), 0);
    }
}

#[test]
fn drawing_of_a_client_that_was_killed_is_resumed_once_its_lease_is_free() {
    let fixture = Fixture::homed("5");
    let (_served, url) = serve(&fixture);
    let mut drawing = draw(&fixture, &url, &[]);
    fixture.until_drawn(2.0);
    drawing.kill().expect("killed");
    drawing.wait().expect("it ends");
    let mut again = fixture.draw_at(&["--station", &url], &["--resume"]);
    let again = again.output().expect("it runs");
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(again.status.success(), "{again:?}");
    assert!(
        said.contains(" s for the lease of magician, which has disconnected, to expire"),
        "{said}"
    );
}
