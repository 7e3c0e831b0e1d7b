//! Outlines and test grids on a virtual arm in another process, which counts as a real one.
#![cfg(unix)]

use std::process::{Output, Stdio};

use crate::magician::drawing::{Fixture, PAPER, last};
use crate::magician::{run, sample};
use serde_json::{Value, json};

const LASER: [&str; 5] = ["--tool", "laser", "--surface", "-50", "--json"];

/// Runs a command with a trace. Returns its result and the frames by which it wrote.
fn traced(fixture: &Fixture, arguments: &[&str]) -> (Output, Vec<Value>) {
    let trace = fixture.dir.path().join("trace.pcapng");
    let trace = trace.to_str().expect("UTF-8");
    let done = fixture
        .command(&[arguments, &["--trace", trace]].concat())
        .output();
    let all = run(&["decode", trace, "--json"]).objects();
    let _ = std::fs::remove_file(trace);
    let writes = all.into_iter().filter(|one| one["direction"] == "request");
    let writes = writes.filter(|one| one["write"] == true || one["queued"] == true);
    (done.expect("it runs"), writes.collect())
}

/// True if a frame may light the laser.
fn may_burn(frame: &Value) -> bool {
    let params = &frame["params"];
    match frame["command"].as_str().expect("a name") {
        "SetCPLECmd" => params["velocity_or_power"].as_f64() != Some(0.0),
        "SetEndEffectorLaser" => params["on"] != json!(0) && params["on"] != json!(false),
        name => name.contains("IOPWM") || name.contains("IODO") || name.contains("PO"),
    }
}

#[test]
fn frame_never_lights_the_laser_and_asks_nothing() {
    let fixture = Fixture::homed("100");
    let image = sample("engrave_gradient.png");
    let frames = [
        [&["frame", &image, "--width", "40"], &LASER[..]].concat(),
        [&["frame", &image, "--width", "40"], &LASER[..]].concat(),
        [
            &["engrave", "--frame=outline", &image, "--width", "40"],
            &LASER[..],
        ]
        .concat(),
        [&["frame", "line.svg", "--shape", "hull"], &LASER[..]].concat(),
    ];
    let mut paths = Vec::new();
    for arguments in &frames {
        let (done, frames) = traced(&fixture, arguments);
        assert!(done.status.success(), "{done:?}");
        let path: Vec<Value> = frames
            .iter()
            .filter(|frame| frame["command"] == "SetCPLECmd")
            .map(|frame| frame["params"].clone())
            .collect();
        assert!(path.len() >= 3, "{frames:?}");
        assert!(
            path.iter().all(|params| params["z"] == json!(PAPER)),
            "{path:?}"
        );
        let burning: Vec<_> = frames.iter().filter(|frame| may_burn(frame)).collect();
        assert!(burning.is_empty(), "{burning:?}");
        assert_eq!(last(&fixture.run(&["info"]))["laser"], json!(false));
        assert!(last(&done)["power"].is_null());
        paths.push(path);
    }
    assert_eq!(paths[0], paths[1]);
}

#[test]
fn frame_is_lit_faintly_only_after_confirmation() {
    let fixture = Fixture::homed("100");
    let frame = [
        &["frame", "line.svg", "--frame-power"],
        &["3"][..],
        &LASER[..],
    ]
    .concat();
    let (refused, frames) = traced(&fixture, &frame);
    assert_eq!(
        (refused.status.code(), frames.len()),
        (Some(2), 0),
        "{refused:?}"
    );
    let (done, frames) = traced(&fixture, &[&frame[..], &["--yes"]].concat());
    assert!(done.status.success(), "{done:?}");
    let powers: Vec<_> = frames
        .iter()
        .filter(|frame| frame["command"] == "SetCPLECmd")
        .map(|frame| frame["params"]["velocity_or_power"].as_f64())
        .collect();
    assert!(
        !powers.is_empty() && powers.iter().all(|power| *power == Some(3.0)),
        "{powers:?}"
    );
    assert_eq!(last(&done)["power"], json!({"most": 3.0, "least": 3.0}));
    assert_eq!(last(&fixture.run(&["info"]))["laser"], json!(false));
    let too_strong = [
        &["frame", "line.svg", "--frame-power", "6", "--yes"],
        &LASER[..],
    ]
    .concat();
    assert_eq!(traced(&fixture, &too_strong).0.status.code(), Some(2));
}

#[test]
fn ctrl_c_ends_a_repeated_frame_with_the_arm_at_rest() {
    let fixture = Fixture::homed("20");
    for (tool, height) in [("laser", PAPER), ("pen", PAPER + 10.0)] {
        let mut frame = fixture.command(&[
            "frame",
            "line.svg",
            "--repeat",
            "--surface",
            "-50",
            "--tool",
            tool,
            "--json",
        ]);
        frame.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = frame.spawn().expect("it starts");
        let round = |fixture: &Fixture| (fixture.number("pose", "z") - height).abs() < 0.1;
        assert!((0..10_000).any(|_| round(&fixture)), "it never goes round");
        assert!(child.try_wait().expect("a child").is_none());
        let id = child.id().to_string();
        let kill = std::process::Command::new("kill")
            .args(["-INT", &id])
            .status();
        assert!(kill.expect("kill runs").success());
        let done = child.wait_with_output().expect("it ends");
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        assert_eq!(last(&done)["stopped"], json!(true));
        let pose = last(&fixture.run(&["pose"]));
        assert_eq!(last(&fixture.run(&["pose"])), pose);
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let said = last(&done)["at"][axis].as_f64().expect("a number");
            let stands = pose[*name].as_f64().expect("a number");
            assert!((said - stands).abs() < 0.01, "{name}: {said} {stands}");
        }
        assert_eq!(last(&fixture.run(&["info"]))["laser"], json!(false));
    }
}

#[test]
fn an_arm_that_was_not_homed_is_not_framed_with_and_burns_no_grid() {
    let fixture = Fixture::new("100");
    let frame = [&["frame", "line.svg"], &LASER[..]].concat();
    let grid = [&["testgrid", "--yes"], &LASER[..]].concat();
    for arguments in [&frame, &grid] {
        let refused = fixture.command(arguments).output().expect("it runs");
        assert_eq!(refused.status.code(), Some(3), "{refused:?}");
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            text.contains("\"home\"") && text.contains("\"unhomed\""),
            "{text}"
        );
    }
    let unhomed = fixture
        .command(&[&frame[..], &["--unhomed"]].concat())
        .output();
    assert!(unhomed.expect("it runs").status.success());
}

#[test]
fn grid_burns_on_a_real_arm_only_with_confirmation() {
    let fixture = Fixture::homed("100");
    let grid = [
        &[
            "testgrid", "--power", "20:40:2", "--speed", "20:30:2", "--cell", "3",
        ],
        &LASER[..],
    ]
    .concat();
    let (refused, frames) = traced(&fixture, &grid);
    assert_eq!(
        (refused.status.code(), frames.len()),
        (Some(2), 0),
        "{refused:?}"
    );
    let (done, frames) = traced(&fixture, &[&grid[..], &["--yes"]].concat());
    assert!(done.status.success(), "{done:?}");
    let powers = frames
        .iter()
        .filter(|frame| frame["command"] == "SetCPLECmd");
    let mut powers: Vec<_> = powers
        .map(|frame| {
            frame["params"]["velocity_or_power"]
                .as_f64()
                .expect("a number")
        })
        .collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    assert_eq!(powers, [0.0, 20.0, 40.0]);
    assert_eq!(last(&done)["power"], json!({"most": 40.0, "least": 20.0}));
}

#[test]
fn grid_written_as_a_plan_runs_equally() {
    let dir = tempfile::tempdir().expect("a directory");
    let plan = dir.path().join("grid.plan.json");
    let plan = plan.to_str().expect("UTF-8");
    let grid = ["testgrid", "--power", "20:40:2", "--cell", "4", "--json"];
    let written = run(&[&grid[..], &[plan]].concat());
    assert_eq!(written.status, 0, "{written:?}");
    let of = |arguments: &[&str]| {
        let checked = run(&[arguments, &["--check", "--json"]].concat()).object();
        ["steps", "seconds", "bounds", "power"].map(|name| checked[name].clone())
    };
    assert_eq!(of(&grid[..5]), of(&["run", plan, "--tool", "laser"]));
    for wrong in [
        &["--power", "10:120:3"][..],
        &["--speed", "5:40"],
        &["--cell", "0.2"],
        &["--spacing", "9"],
    ] {
        let refused = run(&[&["testgrid", "--check"], wrong].concat());
        assert_eq!(refused.status, 2, "{refused:?}");
    }
}

/// Returns the extent in x that a check reports under this name.
fn extent(report: &Value, name: &str) -> [f64; 2] {
    [0, 1].map(|end| report[name]["x"][end].as_f64().expect("a number"))
}

#[test]
fn frame_traces_the_outline_for_the_tool_in_force() {
    let fixture = Fixture::homed("100");
    let checked = |arguments: &[&str]| {
        let more = ["--surface", "-50", "--check", "--json"];
        let done = fixture.command(&[arguments, &more].concat()).output();
        let done = done.expect("it runs");
        assert!(done.status.success(), "{done:?}");
        last(&done)
    };
    for (bias, verb, made, other) in [
        (
            "70",
            "engrave",
            "engraved: the arm has the laser",
            "tool pen",
        ),
        ("61", "draw", "drawn: the arm has the pen", "tool laser"),
        (
            "0",
            "draw",
            "drawn: the tool of the arm is unknown",
            "tool laser",
        ),
    ] {
        let bias = format!("x_bias={bias}");
        let set = ["set", "EndEffectorParams", &bias, "y_bias=0", "z_bias=0"];
        assert!(fixture.run(&set).status.success());
        let frame = checked(&["frame", "line.svg"]);
        let work = checked(&[verb, "line.svg"]);
        let [frame_x, work_x] = [extent(&frame, "travel_bounds"), extent(&work, "bounds")];
        let off = (frame_x[0] - work_x[0])
            .abs()
            .max((frame_x[1] - work_x[1]).abs());
        assert!(off < 0.1, "{frame_x:?} {work_x:?}");
        let first = frame["notes"][0].to_string();
        assert!(first.contains(made) && first.contains(other), "{first}");
    }
    let told = checked(&["frame", "line.svg", "--tool", "laser"]);
    let notes = told["notes"].to_string();
    assert!(!notes.contains("the frame goes round"), "{notes}");
}

#[test]
fn move_out_of_reach_names_an_unknown_tool_and_its_flag() {
    let fixture = Fixture::homed("100");
    let set = [
        "set",
        "EndEffectorParams",
        "x_bias=0",
        "y_bias=0",
        "z_bias=0",
    ];
    assert!(fixture.run(&set).status.success());
    let refused = fixture.command(&["move", "320", "0", "20"]).output();
    let refused = String::from_utf8(refused.expect("it runs").stderr).expect("UTF-8");
    assert!(refused.contains("out of reach"), "{refused}");
    assert!(
        refused.contains("the tool is unknown to the arm"),
        "{refused}"
    );
    assert!(refused.contains("--tool NAME"), "{refused}");
}
