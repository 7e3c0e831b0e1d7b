//! Verbs that need no arm, and failures of the command.

use crate::magician::{command, run};
use serde_json::{Value, json};

fn close(value: &Value, to: f64) -> bool {
    value
        .as_f64()
        .is_some_and(|value| (value - to).abs() < 1e-3)
}

#[test]
fn forward_and_inverse_undo_each_other() {
    let pose = run(&[
        "forward", "0", "45", "45", "0", "--tool", "suction", "--json",
    ])
    .object();
    assert!(
        close(&pose["x"], 259.104) && close(&pose["z"], -8.485),
        "{pose}"
    );
    let [x, y, z, r] = ["x", "y", "z", "r"].map(|name| pose[name].to_string());
    let joints = run(&["inverse", &x, &y, &z, &r, "--tool", "59.7,0,0", "--json"]).object();
    let wanted = [("j1", 0.0), ("j2", 45.0), ("j3", 45.0), ("j4", 0.0)];
    assert!(
        wanted
            .iter()
            .all(|(name, angle)| close(&joints[name], *angle)),
        "{joints}"
    );
}

#[test]
fn negative_numbers_need_no_double_dash() {
    let joints = run(&[
        "inverse", "200", "-50", "-1e1", "-.5", "--tool", "-1,2,-3", "--json",
    ]);
    assert_eq!(joints.status, 0, "{joints:?}");
    assert_eq!(
        run(&["forward", "-10", "-1", "-5.5", "-0", "--json"]).status,
        0
    );
}

#[test]
fn out_of_reach_names_value_and_limit() {
    let far = run(&["inverse", "400", "0", "0", "0", "--json"]);
    assert_eq!(far.status, 3);
    assert_eq!(far.out, "");
    let error = far.error();
    assert_eq!(error["kind"], "unreachable");
    assert!(
        close(&error["value"], 400.0) && close(&error["limit"], 282.0),
        "{error}"
    );
    assert_eq!(error["unit"], "mm");

    let limit = run(&["inverse", "-200", "0", "0", "0", "--json"]);
    assert_eq!(limit.status, 3);
    let error = limit.error();
    assert!(
        close(&error["value"], 180.0) && close(&error["limit"], 135.0),
        "{error}"
    );
    assert_eq!(error["unit"], "deg");
    assert!(
        error["message"]
            .as_str()
            .is_some_and(|m| m.contains("joint 1")),
        "{error}"
    );
}

#[test]
fn what_is_no_number_is_invalid_input() {
    let run = run(&["inverse", "nan", "0", "0", "0", "--json"]);
    assert_eq!(
        (run.status, run.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
}

#[test]
fn mistakes_of_usage_exit_2_and_are_json_when_asked() {
    for arguments in [
        &["frobnicate", "--json"][..],
        &["--json", "inverse", "1"],
        &["--json", "commands", "nonsense"],
        &["--json", "commands", "--chapter", "nonsense"],
        &["--json", "inverse", "1", "2", "3", "x"],
        &["--json"],
        &["--json", "--timeout", "0", "commands"],
    ] {
        let run = run(arguments);
        assert_eq!(run.status, 2, "{arguments:?}");
        assert_eq!(run.out, "", "{arguments:?}");
        assert_eq!(run.error()["kind"], "usage", "{arguments:?}");
    }
    let bare = run(&[]);
    assert_eq!(bare.status, 2);
    assert!(bare.err.contains("Find and inspect:") && bare.err.contains("Settings:"));
}

#[test]
fn the_list_has_every_command_and_filters() {
    let all = run(&["commands", "--json"]).object();
    assert_eq!(all["commands"].as_array().map(Vec::len), Some(90));
    assert_eq!(run(&["commands"]).out.lines().count(), 91);
    let io = run(&["commands", "--chapter", "IO", "--json"]).object();
    assert_eq!(io["commands"].as_array().map(Vec::len), Some(9));
    let jump = run(&["commands", "--word", "jump", "--json"]).object();
    let names: Vec<_> = jump["commands"]
        .as_array()
        .expect("array")
        .iter()
        .map(|c| &c["name"])
        .collect();
    assert_eq!(names, [&json!("PTPJumpParams"), &json!("PTPJump2Params")]);
}

#[test]
fn every_command_is_explained_under_each_of_its_names() {
    let all = run(&["commands", "--json"]).object();
    for command in all["commands"].as_array().expect("array") {
        let name = command["name"].as_str().expect("name");
        let text = run(&["commands", name]);
        assert_eq!(text.status, 0, "{name}");
        assert!(text.out.contains("Examples"), "{name}");
        let by_id = run(&["help", &command["id"].to_string()]);
        // The vendor gives this name to id 21; it means 20, which hosts use (errata E19).
        assert!(
            by_id.out == text.out || name == "ClearAllAlarmsState",
            "{name}"
        );
    }
    let expected = run(&["commands", "80"]).out;
    for name in [
        "PTPJointParams",
        "ptp-joint-params",
        "SetPTPJointParams",
        "0x50",
    ] {
        assert_eq!(run(&["commands", name]).out, expected, "{name}");
    }
}

#[test]
fn a_slip_is_answered_with_the_nearest_name() {
    let run = run(&["commands", "PTPJointParms"]);
    assert_eq!(run.status, 2);
    assert!(run.err.contains("PTPJointParams"), "{}", run.err);
}

#[test]
fn completions_and_pages_for_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(&["completions", shell]);
        assert_eq!(script.status, 0);
        assert!(script.out.contains("inverse"), "{shell}");
    }
    assert!(run(&["man"]).out.contains(".TH magician"));
    let dir = tempfile::tempdir().expect("directory");
    let pages = dir.path().join("share/man1");
    assert_eq!(run(&["man", pages.to_str().expect("UTF-8")]).status, 0);
    let page = pages.join("magician-decode.1");
    assert!(page.exists());
    assert_eq!(run(&["man", page.to_str().expect("UTF-8")]).status, 3);
}

#[test]
fn the_version_says_what_it_speaks() {
    let version = run(&["--version", "--json"]).object();
    assert_eq!(version["name"], "magician");
    assert_eq!(version["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(version["protocol"], "V1.1.3");
    assert!(run(&["--version"]).out.starts_with("magician "));
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let mut child = command()
        .arg("commands")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the command ends");
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
}

#[test]
fn help_finds_topics_by_related_words_and_suggests_only_similar_names() {
    assert_eq!(run(&["help", "hatch"]).out, run(&["help", "fill"]).out);
    assert_eq!(run(&["help", "teacher"]).out, run(&["help", "class"]).out);
    for (word, hint) in [
        ("gcoed", "did you mean gcode?"),
        ("engrav", "did you mean engrave?"),
    ] {
        let help = run(&["help", word]);
        assert_eq!(help.status, 2);
        assert!(help.err.contains(hint), "{word}: {}", help.err);
    }
    let unrelated = run(&["help", "foo"]);
    assert!(!unrelated.err.contains("did you mean"), "{}", unrelated.err);
}

#[test]
fn help_has_topics() {
    let all = run(&["help"]);
    assert_eq!(all.status, 0);
    for (topic, says) in [
        ("units", "counter-clockwise"),
        ("pen", "magician calibrate surface"),
        ("laser", "goggles"),
        ("text", "--wrap MM"),
        ("fill", "--fill-spacing MM"),
        ("pens", "--parts color"),
        ("gcode", "--place"),
        ("class", "magician station class"),
        ("resume", "--from STEP"),
        ("exit-status", "uncertain"),
    ] {
        assert!(all.out.contains(&format!("  {topic} ")), "{topic}");
        let help = run(&["help", topic]);
        assert_eq!(help.status, 0, "{topic}");
        assert!(help.out.contains(says), "{topic}");
        assert!(
            help.out.lines().all(|line| line.chars().count() <= 100),
            "{topic}"
        );
        let json = run(&["help", topic, "--json"]).object();
        assert!(
            json["text"]
                .as_str()
                .is_some_and(|text| text.contains(says)),
            "{topic}"
        );
    }
    // The verb of the same name is explained along with the topic.
    assert!(run(&["help", "laser"]).out.contains("--keep-on"));
}
