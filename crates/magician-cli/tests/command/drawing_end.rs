//! Ends of drawings: the pen is lifted, the tool is parked. An unhomed arm does not draw.
#![cfg(unix)]

use std::process::{Child, Output, Stdio};

use crate::magician::drawing::{Fixture, PAPER, last};
use crate::magician::{command, run, signal};
use serde_json::{Value, json};

/// Starts a drawing and waits until the pen moves on the paper.
fn drawing(fixture: &Fixture, more: &[&str]) -> Child {
    let mut draw = fixture.draw(more);
    draw.arg("--json");
    draw.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = draw.spawn().expect("it starts");
    fixture.until_drawn(2.0);
    assert!(child.try_wait().expect("a child").is_none(), "{more:?}");
    child
}

fn error(output: &Output) -> (Value, String) {
    let error = error_object(output);
    let message = error["message"].as_str().unwrap_or_default();
    (error["kind"].clone(), message.to_owned())
}

fn error_object(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stderr);
    let error = text.lines().last().unwrap_or_default();
    let error: Value = serde_json::from_str(error).unwrap_or_else(|_| panic!("{output:?}"));
    error["error"].clone()
}

#[test]
fn first_signal_lifts_the_pen_and_the_drawing_can_be_resumed() {
    let fixture = Fixture::homed("3");
    for (name, more, up) in [
        ("-INT", &[][..], 10.0),
        ("-TERM", &["--resume"], 10.0),
        ("-INT", &["--stay", "--resume"], 0.0),
        ("-INT", &["--resume", "--park", "200,-80,30"], 10.0),
        ("-INT", &["--lift", "20"], 20.0),
        ("-INT", &["--lift", "20", "--resume"], 20.0),
    ] {
        let child = drawing(&fixture, more);
        signal(name, &child);
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let (kind, message) = error(&output);
        assert_eq!(kind, "interrupted");
        let said = match up {
            0.0 => "the pen stays down".to_owned(),
            up => format!("the pen is up by {up:.1} mm"),
        };
        assert!(message.contains(&said), "{more:?}: {message}");
        assert!(message.contains("the arm stands at x "), "{message}");
        assert!(
            (fixture.number("pose", "z") - PAPER - up).abs() < 0.5,
            "{more:?}"
        );
        let queue = last(&fixture.run(&["queue"]));
        assert_eq!(queue["left_space"], 32);
    }
    let park = ["--park", "200,-80,30", "--resume"];
    let draw = ["draw", "line.svg", "--surface", "-50", "--speed", "10"];
    let done = fixture.run(&[&draw[..], &park].concat());
    assert!(done.status.success(), "{done:?}");
    let end = json!({"at": [200.0, -80.0, 30.0], "pen": "up", "parked": true});
    assert_eq!(last(&done)["end"], end);
    let again = fixture.run(&[&draw[..], &["--resume"]].concat());
    assert_eq!(again.status.code(), Some(3), "{again:?}");
}

#[test]
fn a_second_signal_moves_nothing_and_settings_are_restored() {
    let fixture = Fixture::homed("0.3");
    let before = fixture.settings();
    let mut child = drawing(&fixture, &["--lift", "60"]);
    // The first signal stops it, those within half a second are ignored, and the next one counts:
    // the lift takes seconds.
    while child.try_wait().expect("a child").is_none() {
        signal("-INT", &child);
    }
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    let (kind, message) = error(&output);
    assert_eq!(kind, "interrupted");
    assert!(message.starts_with("interrupted twice: "), "{message}");
    // At 0.3 of real speed the arm reports the same pose for 67 ms of wall time, which may look
    // like rest.
    let mut stands = fixture.number("pose", "z");
    let mut equal = 0;
    while equal < 8 {
        let now = fixture.number("pose", "z");
        equal = if now == stands { equal + 1 } else { 0 };
        stands = now;
    }
    assert!(stands < PAPER + 59.0, "{stands}");
    assert_eq!(fixture.settings(), before);
    assert_eq!(
        fixture.unrestored(),
        0,
        "nothing is left to the next command"
    );
    assert_eq!(fixture.number("pose", "z"), stands);
    assert_eq!(last(&fixture.run(&["queue"]))["left_space"], 32);
    // The run can still be resumed.
    let again = drawing(&fixture, &["--lift", "60", "--resume"]);
    signal("-INT", &again);
    assert_eq!(
        again.wait_with_output().expect("it ends").status.code(),
        Some(130)
    );
}

#[test]
fn run_reports_the_state_of_its_tool() {
    let fixture = Fixture::homed("50");
    let end = |arguments: &[&str]| {
        let done = run(&[&["--port", "sim", "--json"], arguments].concat());
        assert_eq!(done.status, 0, "{done:?}");
        done.objects().pop().expect("a result")["end"].clone()
    };
    fixture.write(
        "down.gcode",
        "G21 G90\nG0 X220 Y0 Z10\nG1 Z-40 F900\nG1 X240\n",
    );
    let path = |name: &str| fixture.dir.path().join(name).display().to_string();
    let (svg, down) = (path("line.svg"), path("down.gcode"));
    let height = |end: &Value| end["at"][2].as_f64().expect("a height");
    let usual = end(&["draw", &svg]);
    assert_eq!((&usual["pen"], height(&usual)), (&json!("up"), -50.0));
    let stays = end(&["draw", &svg, "--stay"]);
    assert_eq!((&stays["pen"], height(&stays)), (&json!("down"), -60.0));
    // A pen that the file leaves down is lifted.
    assert_eq!(height(&end(&["run", &down])), -30.0);
    assert_eq!(height(&end(&["run", &down, "--lift", "4"])), -36.0);
    assert_eq!(height(&end(&["run", &down, "--stay"])), -40.0);
    let parked = json!({"at": [210.0, 60.0, -20.0], "pen": "up", "parked": true});
    assert_eq!(end(&["run", &down, "--park", "210,60,-20"]), parked);
    // A laser job ends where it is unless it is parked.
    assert_eq!(end(&["engrave", &svg]), Value::Null);
    let parked = json!({"at": [210.0, 60.0, 0.0], "pen": null, "parked": true});
    assert_eq!(end(&["engrave", &svg, "--park", "210,60,0"]), parked);

    let both = run(&["draw", &svg, "--stay", "--park", "210,60,0"]);
    assert_eq!(both.status, 2, "{both:?}");
    for more in [&[][..], &["--check"]] {
        let draw = ["--port", "sim", "--json", "draw", &svg, "--park", "400,0,0"];
        let far = run(&[&draw[..], more].concat());
        assert_eq!(far.status, if more.is_empty() { 3 } else { 10 }, "{far:?}");
        assert!(far.err.contains("the tool cannot be parked"), "{far:?}");
    }
    let config = path("config.toml");
    std::fs::write(&config, "park = \"210,60,-20\"\n").expect("written");
    let mut usual = command();
    usual.env("MAGICIAN_CONFIG", &config);
    let usual = usual.args(["--port", "sim", "--json", "draw", &svg]);
    let usual = usual.output().expect("it runs");
    assert_eq!(last(&usual)["end"]["parked"], true, "{usual:?}");
}
