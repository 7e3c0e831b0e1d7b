//! Verbs that need an arm, run on a virtual arm in the process. Its clock jumps, so nothing here
//! takes time or depends on time.

use crate::magician::{Run, command, run, run_with};
use serde_json::{Value, json};

/// Runs a verb on a new virtual arm.
fn on_sim(arguments: &[&str]) -> Run {
    let mut all = vec!["--port", "sim"];
    all.extend(arguments);
    run(&all)
}

/// Runs lines in a shell on one new virtual arm, with JSON output.
fn script(lines: &str) -> Run {
    run_with(&["--port", "sim", "--json", "shell"], lines.as_bytes())
}

#[test]
fn pose_has_the_eight_numbers_of_an_arm_that_was_switched_on() {
    let pose = on_sim(&["pose", "--json"]);
    let wanted =
        r#"{"x":259.10413,"y":0.0,"z":-8.485281,"r":0.0,"j1":0.0,"j2":45.0,"j3":45.0,"j4":0.0}"#;
    assert_eq!(
        (pose.status, pose.out.trim(), pose.err.as_str()),
        (0, wanted, "")
    );
}

#[test]
fn jog_that_nothing_holds_is_refused_with_the_verb_to_use() {
    let jog = "JOGCmd is_joint=1 cmd=1";
    let lines = [
        format!("set {jog}"),
        format!("enqueue {jog}"),
        format!("enqueue {jog} --start"),
    ];
    for line in lines {
        let words: Vec<_> = line.split(' ').collect();
        for refused in [on_sim(&words), script(&format!("{line}\n"))] {
            assert_eq!((refused.status, refused.out.as_str()), (3, ""), "{line}");
            let remedies = ["`magician jog`", r#""action":"jog""#];
            let told = remedies.iter().any(|told| refused.err.contains(told));
            assert!(told, "{refused:?}");
            assert!(refused.err.contains("nothing was sent"), "{refused:?}");
        }
    }
    // Ending a jog is a stop, which is always allowed.
    let stop = on_sim(&["set", "JOGCmd", "is_joint=0", "cmd=0"]);
    assert_eq!((stop.status, stop.err.as_str()), (0, ""));
}

#[test]
fn moves_arrive_and_keep_the_rotation_that_is_left_out() {
    let run = script(
        "home\n\
         move 220 40 30 15\n\
         move 200 -40 30 --linear\n\
         move 220 0 0 --jump\n\
         move --relative 0 0 -10.5\n\
         move --joints 10 50 40\n\
         move --joints --relative -10 -5 5 0 --speed-ratio 80\n",
    );
    assert_eq!(run.status, 0, "{run:?}");
    let poses = run.objects();
    let at = |line: usize, names: [&str; 4]| {
        names.map(|name| poses[line][name].as_f64().unwrap_or(f64::NAN))
    };
    let place = |line| at(line, ["x", "y", "z", "r"]);
    let joints = |line| at(line, ["j1", "j2", "j3", "j4"]);
    assert_eq!(place(1), [220.0, 40.0, 30.0, 15.0]);
    assert_eq!(place(2), [200.0, -40.0, 30.0, 15.0]);
    assert_eq!(place(3), [220.0, 0.0, 0.0, 15.0]);
    assert_eq!(place(4), [220.0, 0.0, -10.5, 15.0]);
    assert_eq!(joints(5)[..3], [10.0, 50.0, 40.0]);
    assert_eq!(joints(6)[..3], [0.0, 45.0, 45.0]);
}

#[test]
fn a_speed_ratio_is_for_one_move_and_a_tool_stays() {
    let run = script(
        "move 250 0 0 --speed-ratio 20 --tool suction\n\
         get PTPCommonParams\n\
         get EndEffectorParams\n",
    );
    assert_eq!(run.status, 0, "{run:?}");
    let answers = run.objects();
    assert_eq!(
        answers[1],
        json!({"velocity_ratio": 50.0, "acceleration_ratio": 50.0})
    );
    assert_eq!(
        answers[2],
        json!({"x_bias": 59.7, "y_bias": 0.0, "z_bias": 0.0})
    );
}

#[test]
fn without_waiting_the_answer_is_the_index() {
    let run = script("move 220 0 0 --no-wait\nmove 220 10 0 --no-wait --speed-ratio 50\n");
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(run.objects(), [json!({"index": 2}), json!({"index": 5})]);
}

#[test]
fn what_is_out_of_reach_is_refused_before_anything_is_sent() {
    let run = run_with(
        &["--port", "sim", "--json", "shell", "--keep-going"],
        b"move 400 0 0\nqueue status\npose\n",
    );
    assert_eq!(run.status, 3);
    let error = run.error();
    assert_eq!(error["kind"], "unreachable");
    // With a suction cup the wrist is behind the target; this is the wrist's distance.
    let value = error["value"].as_f64().expect("a number");
    assert!((value - 340.3).abs() < 1e-3, "{error}");
    assert_eq!(error["limit"], 282.0);
    let answers = run.objects();
    assert_eq!(answers[0], json!({"current_index": 0, "left_space": 32}));
    assert_eq!(answers[1]["j2"], 45.0);
}

#[test]
fn a_script_stops_at_the_line_that_fails() {
    let run = script("pose\nget Nonsense\npose\n");
    assert_eq!((run.status, run.objects().len()), (2, 1));
    assert_eq!(run.error()["kind"], "usage");
}

#[test]
fn comments_blanks_quotes_and_exit() {
    let run = script(
        "# nothing\n\n set DeviceName device_name='my arm' # why not\nget DeviceName\nexit\npose\n",
    );
    assert_eq!(run.status, 0, "{run:?}");
    assert_eq!(run.objects(), [json!({}), json!({"device_name": "my arm"})]);
}

#[test]
fn get_set_and_enqueue_speak_every_name() {
    let run = script(
        "set ptp-joint-params velocity=1,2,3,4 acceleration=5,6,7,8.5\n\
         get 80\n\
         enqueue WAITCmd timeout=10\n\
         enqueue SetWAITCmd timeout=10 --start\n\
         get IODO address=4\n",
    );
    assert_eq!(run.status, 0, "{run:?}");
    let answers = run.objects();
    assert_eq!(answers[0], json!({}));
    assert_eq!(
        answers[1],
        json!({"velocity": [1.0, 2.0, 3.0, 4.0], "acceleration": [5.0, 6.0, 7.0, 8.5]})
    );
    assert_eq!(answers[2], json!({"index": 2}));
    assert_eq!(answers[3], json!({"index": 3}));
    assert_eq!(answers[4], json!({"address": 4, "level": 0}));
}

#[test]
fn mistakes_with_commands_are_usage_and_send_nothing() {
    for arguments in [
        &["get", "ResetPose"][..],
        &["set", "Pose"],
        &["get", "Nonsense"],
        &["set", "PTPCommonParams", "velocity_ratio=80"],
        &["set", "PTPCommonParams", "velocity_ratio"],
        &["set", "PTPCommonParams", "speed=80"],
        &["set", "WAITCmd", "timeout=soon"],
        &["enqueue", "DeviceName", "device_name=x"],
        &["get"],
        &["move", "1", "2"],
        &["move", "--joints", "--relative", "--linear", "1", "2", "3"],
        &["io", "set", "21", "1"],
        &["sim"],
    ] {
        let mut all = vec!["--json"];
        all.extend(arguments);
        // No port is given: a verb that did not refuse would fail to find an arm instead.
        let run = run(&all);
        assert_eq!(
            (run.status, run.error()["kind"].as_str()),
            (2, Some("usage")),
            "{arguments:?}"
        );
    }
}

#[test]
fn every_dangerous_set_needs_yes_and_no_other() {
    let commands = run(&["commands", "--json"]).object();
    for row in commands["commands"].as_array().expect("array") {
        if row["set"].is_null() {
            continue;
        }
        let name = row["name"].as_str().expect("name");
        let text = run(&["commands", name]).out;
        let example = text
            .lines()
            .find_map(|line| line.trim().strip_prefix("magician set "));
        let words: Vec<_> = example.expect("an example").split(' ').collect();
        let bare: Vec<_> = words
            .iter()
            .filter(|word| **word != "--yes")
            .copied()
            .collect();
        let refused = on_sim(&[&["set"][..], &bare].concat());
        let dangerous = row["dangerous"] == true;
        assert_eq!(
            refused.status,
            if dangerous { 2 } else { 0 },
            "{name}: {refused:?}"
        );
        assert_eq!(words.len() != bare.len(), dangerous, "{name}");
        if dangerous && name != "ResetPose" {
            let done = on_sim(&[&["set"][..], &words].concat());
            assert_eq!(done.status, 0, "{name}: {done:?}");
        }
    }
}

#[test]
fn every_readable_command_answers_with_its_fields() {
    let commands = run(&["commands", "--json"]).object();
    let rows = commands["commands"].as_array().expect("array");
    for row in rows.iter().filter(|row| !row["get"].is_null()) {
        let name = row["name"].as_str().expect("name");
        let text = run(&["commands", name]).out;
        let example = text
            .lines()
            .find_map(|line| line.trim().strip_prefix("magician get "));
        let words: Vec<_> = example.expect("an example").split(' ').collect();
        let run = on_sim(&[&["get", "--json"][..], &words].concat());
        assert_eq!(run.status, 0, "{name}: {run:?}");
        assert!(run.object().is_object(), "{name}");
    }
}

#[test]
fn storing_a_program_wants_yes_and_says_why() {
    let store = [
        "set",
        "QueuedCmdStartDownload",
        "total_loop=1",
        "line_per_loop=1",
    ];
    let refused = on_sim(&store);
    assert_eq!(refused.status, 2, "{refused:?}");
    let why = "QueuedCmdStartDownload writes the commands that follow to the arm's flash, where \
               the key at the base can run them later; nothing was sent";
    assert!(refused.err.contains(why), "{refused:?}");
    let meant = on_sim(&[&store[..], &["--yes"]].concat());
    assert_eq!(meant.status, 0, "{meant:?}");
}

#[test]
fn share_of_power_out_of_range_is_refused_with_value_and_range() {
    let pulses = ["IOPWM", "address=4", "frequency=100", "duty_cycle=-5"];
    let burn = [
        "CPLECmd",
        "cp_mode=1",
        "x=220",
        "y=0",
        "z=20",
        "velocity_or_power=-1",
    ];
    for (verb, words, said) in [
        (
            "set",
            &pulses[..],
            "duty_cycle -5 % is out of range: 0 to 100 %",
        ),
        (
            "enqueue",
            &pulses[..],
            "duty_cycle -5 % is out of range: 0 to 100 %",
        ),
        (
            "enqueue",
            &burn[..],
            "velocity_or_power -1 % is out of range: 0 to 100 %",
        ),
    ] {
        let words = [&[verb][..], words].concat();
        let line = format!("{}\n", words.join(" "));
        let in_a_shell = run_with(&["--port", "sim", "shell"], line.as_bytes());
        for run in [on_sim(&words), in_a_shell] {
            assert_eq!(run.status, 3, "{run:?}");
            assert!(run.err.contains(said), "{run:?}");
        }
    }
}

#[test]
fn tools_pins_alarms_and_the_queue() {
    let run = script(
        "suction on\n\
         get EndEffectorSuctionCup\n\
         gripper close\n\
         gripper off\n\
         laser off\n\
         io mux 6 digital-output\n\
         io set 6 on\n\
         io get 6\n\
         alarms --clear\n\
         queue start\n\
         stop\n\
         info\n",
    );
    assert_eq!(run.status, 0, "{run:?}");
    let answers = run.objects();
    assert_eq!(answers[0], json!({"state": "on"}));
    assert_eq!(answers[1], json!({"is_ctrl_enabled": 1, "is_sucked": 1}));
    assert_eq!(
        answers[7],
        json!({"address": 6, "multiplex": 1, "level": 1})
    );
    assert_eq!(answers[8], json!({"alarms": []}));
    assert_eq!(answers[11]["firmware"], "3.6.14");
}

#[test]
fn an_alarm_is_told_with_cause_and_cure() {
    // The raw verbs send any values; the arm itself refuses this one.
    let run = script(
        "alarms --clear\n\
         enqueue PTPCmd ptp_mode=1 x=400 y=0 z=0 r=0 --start\n\
         alarms\n\
         move 220 0 0\n",
    );
    assert_eq!(run.status, 8, "{run:?}");
    let alarm = &run.objects()[2]["alarms"][0];
    assert_eq!(alarm["code"], 0x11);
    assert!(alarm["cause"].is_string() && alarm["remedy"].is_string());
    assert_eq!(run.error()["kind"], "alarm");
}

#[test]
fn no_arm_is_a_port_error_never_the_simulator() {
    let run = run(&["--port", "/dev/no-such-arm", "--json", "pose"]);
    assert_eq!(
        (run.status, run.error()["kind"].as_str()),
        (4, Some("port"))
    );
    let odd = run_with(&["--port", "nonsense", "--json", "pose"], b"");
    assert_eq!(
        (odd.status, odd.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
}

#[cfg(not(feature = "ble"))]
#[test]
fn bluetooth_is_a_matter_of_the_build() {
    let ble = run_with(&["--port", "ble:Dobot", "--json", "pose"], b"");
    assert_eq!(
        (ble.status, ble.error()["kind"].as_str()),
        (6, Some("unsupported"))
    );
}

#[test]
fn the_port_may_come_from_the_environment_and_the_option_wins() {
    let output = command()
        .env("MAGICIAN_PORT", "sim")
        .args(["pose", "--json"])
        .output();
    assert_eq!(output.expect("runs").status.code(), Some(0));
    let output = command()
        .env("MAGICIAN_PORT", "nonsense")
        .args(["-p", "sim", "pose"])
        .output();
    assert_eq!(output.expect("runs").status.code(), Some(0));
    let output = command()
        .env("MAGICIAN_PORT", "nonsense")
        .args(["decode", "AAAA020A00F6"])
        .output();
    assert_eq!(output.expect("runs").status.code(), Some(0));
}

#[test]
fn the_demonstration_places_six_cubes_and_draws_them() {
    let dir = tempfile::tempdir().expect("directory");
    let picture = dir.path().join("demo.svg");
    let path = picture.to_str().expect("UTF-8");
    let run = run(&["demo", "--speed", "max", "--picture", path, "--json"]);
    assert_eq!(run.status, 0, "{run:?}");
    let summary = run.object();
    assert_eq!(summary["cubes"], 6);
    let number = |name: &str| summary[name].as_u64().expect("number");
    assert_eq!(
        number("last_index") - number("first_index") + 1,
        number("commands")
    );
    let drawing = std::fs::read_to_string(&picture).expect("a picture");
    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
    assert!(drawing.contains("From the side"));
    // Even at full speed the picture shows the real path, not chords between few points.
    let seconds = summary["arm_seconds"].as_f64().expect("seconds");
    let poses = number("poses") as f64;
    assert!(seconds > 20.0 && poses > 20.0 * seconds, "{summary}");
}

#[test]
fn a_real_arm_does_not_move_without_yes() {
    let dir = tempfile::tempdir().expect("directory");
    let picture = dir.path().join("demo.svg");
    let path = picture.to_str().expect("UTF-8");
    let run = run(&[
        "--port",
        "/dev/no-such-arm",
        "demo",
        "--json",
        "--out",
        path,
    ]);
    assert_eq!(
        (run.status, run.error()["kind"].as_str()),
        (2, Some("usage"))
    );
    assert!(!picture.exists());
    let nobody = run_with(
        &[
            "--port",
            "/dev/no-such-arm",
            "demo",
            "--yes",
            "--json",
            "--out",
            path,
        ],
        b"",
    );
    assert_eq!(
        (nobody.status, nobody.error()["kind"].as_str()),
        (4, Some("port"))
    );
    assert!(!picture.exists(), "nothing was drawn");
    let nowhere = run_with(&["demo", "--out", "/no/such/place/demo.svg", "--json"], b"");
    assert_eq!(
        (nowhere.status, nowhere.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
}

#[test]
fn a_flag_that_does_not_exist_is_no_number() {
    let run = run_with(
        &[
            "--port", "sim", "--json", "move", "220", "40", "30", "--slow",
        ],
        b"",
    );
    assert_eq!(
        (run.status, run.error()["kind"].as_str()),
        (2, Some("usage"))
    );
    let message = run.error()["message"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    assert!(message.contains("--slow"), "{message}");
    for (text, y) in [
        ("-40", -40.0),
        ("-.5", -0.5),
        ("-4e1", -40.0),
        ("-2.5e-1", -0.25),
    ] {
        let run = run_with(&["--port", "sim", "--json", "move", "220", text, "30"], b"");
        assert_eq!(run.status, 0, "{text}");
        assert_eq!(
            run.object()["y"].as_f64().map(|y| y.round_ties_even()),
            Some(f64::round_ties_even(y)),
            "{text}"
        );
    }
}

#[test]
fn a_shell_has_one_connection_and_no_shell_in_it() {
    for line in [
        "--port sim pose",
        "pose --window 4",
        "pose --trace a.pcapng",
        "pose --tool pen",
        "shell",
        "demo",
        "sim --udp 127.0.0.1",
    ] {
        let run = script(line);
        assert_eq!(
            (run.status, run.error()["kind"].as_str()),
            (2, Some("usage")),
            "{line}"
        );
    }
    let value: Vec<Value> = script("pose").objects();
    assert_eq!(value.len(), 1);
}
