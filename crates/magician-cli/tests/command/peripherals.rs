//! Rail, belt and sensors beside the arm, on a virtual arm in the process.

use crate::magician::served::Served;
use crate::magician::{Run, run, run_with};
use serde_json::json;

/// Runs lines in a shell on one new virtual arm, with JSON output.
fn script(lines: &str) -> Run {
    run_with(&["--port", "sim", "--json", "shell"], lines.as_bytes())
}

#[test]
fn rail_is_enabled_and_moved_along() {
    let run = script(
        "home\nrail\nrail on\nrail to 350\nrail by -50.5 --speed 80\nget PTPLParams\nrail off\n",
    );
    let answers = run.objects();
    let l = |at: usize| answers[at]["l"].as_f64();
    assert_eq!(answers[1], json!({"rail": false}));
    assert_eq!((l(2), l(3), l(4)), (Some(0.0), Some(350.0), Some(299.5)));
    assert_eq!(answers[5]["velocity"], json!(100.0), "given back: {run:?}");
    assert_eq!(answers[6], json!({"rail": false}));
    let beyond = script("rail on\nrail to 1200\n");
    assert!(beyond.err.contains("1200 mm, limit 1000 mm"), "{beyond:?}");
}

#[test]
fn disabled_rail_is_not_moved_along() {
    for line in ["rail to 100\n", "rail by 10\n"] {
        let run = script(line);
        assert!(run.err.contains("rail is not enabled"), "{run:?}");
        assert_eq!((run.status, run.out.as_str()), (3, ""));
    }
}

#[test]
fn the_belt_runs_moves_and_stops() {
    let run = script("conveyor run 50\nconveyor by -20 --speed 40 --motor 2\nconveyor stop\n");
    let answers = run.objects();
    assert_eq!(
        answers[..3],
        [
            json!({"motor": 1, "speed": 50.0}),
            json!({"motor": 2, "distance": -20.0}),
            json!({"motor": 1, "speed": 0.0}),
        ]
    );
    for line in [
        "conveyor run nan\n",
        "conveyor run 1e9\n",
        "conveyor by 10 --speed 0\n",
    ] {
        assert_eq!(script(line).status, 3, "{line}");
    }
}

#[test]
fn belt_speed_above_the_limit_is_refused() {
    for line in [
        "conveyor run 121\n",
        "conveyor run -500\n",
        "conveyor by 10 --speed 200\n",
    ] {
        let run = script(line);
        assert_eq!((run.status, run.out.as_str()), (3, ""), "{line}: {run:?}");
        assert!(run.err.contains("the belt reaches 120 mm/s"), "{run:?}");
    }
    assert_eq!(script("conveyor run -120\nconveyor stop\n").status, 0);
}

#[test]
fn moving_the_belt_warns_of_no_homing_and_moving_the_arm_does() {
    let dir = tempfile::tempdir().expect("directory");
    let arm = dir.path().join("arm");
    let arm = arm.to_str().expect("UTF-8");
    let _arm = Served::start(&["--pty", arm, "--speed", "max"], 1);
    let belt = run(&["--port", arm, "conveyor", "by", "120"]);
    assert_eq!((belt.status, belt.err.as_str()), (0, ""), "{belt:?}");
    let moved = run(&["--port", arm, "move", "220", "0", "20"]);
    assert!(moved.err.contains("home it"), "{moved:?}");
}

#[test]
fn pin_is_driven_only_by_its_function() {
    for (line, told) in [
        (
            "io set 6 high\n",
            "EIO 6 has no function, it has to be a digital output; nothing was sent",
        ),
        (
            "io mux 6 digital-input\nio set 6 low\n",
            "EIO 6 has another function, it has to be a digital output; nothing was sent",
        ),
        (
            "io mux 8 digital-output\nio pwm 8 1000 20\n",
            "EIO 8 has another function, it has to be a pulse-width output; nothing was sent",
        ),
    ] {
        let run = run_with(&["--port", "sim", "shell"], line.as_bytes());
        assert_eq!(run.status, 3, "{line}: {run:?}");
        assert!(run.err.contains(told), "{line}: {run:?}");
        let pin = if line.contains("pwm") {
            "8 pwm"
        } else {
            "6 digital-output"
        };
        let way_out = format!("`magician io mux {pin}` gives it that function");
        assert!(run.err.contains(&way_out), "{line}: {run:?}");
    }
    let run = script("io mux 6 digital-output\nio set 6 high\nio mux 8 pwm\nio pwm 8 1000 20\n");
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(run.objects()[1]["level"], json!(1), "{run:?}");
}

#[test]
fn running_belt_is_reported_and_stop_switches_it_off() {
    let dir = tempfile::tempdir().expect("directory");
    let path = |name: &str| dir.path().join(name).to_str().expect("UTF-8").to_owned();
    let (arm, trace) = (path("arm"), path("trace.pcapng"));
    let _arm = Served::start(&["--pty", &arm, "--speed", "max"], 1);
    let begun = run(&["--port", &arm, "conveyor", "run", "50", "--motor", "2"]);
    let note = "note: motor 2 keeps running; `magician conveyor stop --motor 2` or `magician stop` stops it";
    assert_eq!((begun.status, begun.err.trim()), (0, note), "{begun:?}");
    let stop = run(&["--port", &arm, "stop", "--trace", &trace]);
    assert_eq!((stop.status, stop.err.as_str()), (0, ""), "{stop:?}");
    let sent = run(&["decode", &trace]).out;
    let request = |name: &str| sent.find(&format!("request  {name}\n"));
    let own = [
        "SetQueuedCmdForceStopExec",
        "SetEndEffectorLaser",
        "SetQueuedCmdClear",
    ];
    let own = own.map(|name| request(name).unwrap_or_else(|| panic!("{name}: {sent}")));
    let motors: Vec<_> = sent.match_indices("request  SetEMotor\n").collect();
    assert!(own.is_sorted() && motors.len() == 2, "{sent}");
    assert!(motors.iter().all(|(at, _)| *at > own[2]), "{sent}");
    // A plan that leaves a motor running is noted too.
    let plan = path("belt.plan.json");
    let step = r#"{"command":"EMotor","values":{"index":0,"is_enabled":1,"speed":1000}}"#;
    let text = format!(r#"{{"format":"magician-plan","version":1,"steps":[{step}]}}"#);
    std::fs::write(&plan, text).expect("a plan");
    let ran = run(&["--port", &arm, "run", &plan]);
    let note = "note: motor 1 keeps running; `magician conveyor stop` or `magician stop` stops it";
    assert!(ran.status == 0 && ran.err.contains(note), "{ran:?}");
    // A program that stops its motors prints no note.
    let both = run_with(
        &["--port", &arm, "shell"],
        b"conveyor run 50\nconveyor stop\n",
    );
    assert_eq!((both.status, both.err.as_str()), (0, ""), "{both:?}");
}

#[test]
fn stop_says_which_tool_is_left_on_and_info_shows_it() {
    for (on, off, text, template, remedies) in [
        (
            "suction on",
            "suction off",
            "the suction cup is still on (`magician suction off` switches it off)",
            "the suction cup is still on",
            json!([{"action": "suction-off", "effect": "switches it off"}]),
        ),
        (
            "gripper close",
            "gripper off",
            "the gripper is still closed, and its pump runs (`magician gripper off` switches its pump off)",
            "the gripper is still closed, and its pump runs",
            json!([{"action": "gripper-off", "effect": "switches its pump off"}]),
        ),
    ] {
        let run = script(&format!("{on}\nstop\ninfo\n{off}\nstop\ninfo\n"));
        let answers = run.objects();
        let note =
            json!({"code": "left-on", "text": text, "template": template, "remedies": remedies});
        assert_eq!(answers[1]["notes"], json!([note]), "{run:?}");
        let sucks = on == "suction on";
        let told = |at: usize| {
            (
                answers[at]["suction"].clone(),
                answers[at]["gripper"].clone(),
            )
        };
        let gripper = if sucks { "off" } else { "closed" };
        assert_eq!(told(2), (json!(sucks), json!(gripper)), "{run:?}");
        assert!(answers[4].get("notes").is_none(), "{run:?}");
        assert_eq!(told(5), (json!(false), json!("off")), "{run:?}");
    }
}

#[test]
fn sensors_are_switched_on_and_read() {
    let run = script("sensor color gp2\nsensor infrared gp4\nsensor ir gp4 --off\n");
    assert_eq!(run.status, 0, "{run:?}");
    let answers = run.objects();
    assert_eq!(
        answers[..],
        [
            json!({"port": "GP2", "r": 0, "g": 0, "b": 0, "color": null}),
            json!({"port": "GP4", "blocked": false}),
            json!({"port": "GP4", "on": false}),
        ]
    );
}
