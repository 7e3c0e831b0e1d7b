//! `magician conform` on the virtual arm in the process, whose clock it steps, and on an arm behind
//! a line.

use crate::magician::run;

#[test]
fn the_virtual_arm_passes_and_every_case_is_an_object() {
    let run = run(&["--port", "sim", "conform", "--json"]);
    assert_eq!((run.status, run.err.as_str()), (0, ""), "{}", run.out);
    let mut objects = run.objects();
    let summary = objects.pop().expect("a summary")["summary"].clone();
    assert_eq!(summary["failed"], 0);
    let counted: u64 = ["passed", "skipped", "pending"]
        .iter()
        .filter_map(|key| summary[key].as_u64())
        .sum();
    assert_eq!(counted, objects.len() as u64);
    assert!(objects.len() > 200, "{summary}");
    let pose = objects
        .iter()
        .find(|object| object["case"] == "pose.forward-cw01");
    let pose = pose.expect("a case");
    assert_eq!(pose["outcome"], "passed");
    assert_eq!(pose["confidence"], "M");
    assert_eq!(pose["tags"], serde_json::json!(["moves"]));
}

#[test]
fn text_output_has_one_line_per_chapter() {
    let run = run(&[
        "--port",
        "sim",
        "conform",
        "--only",
        "wait",
        "--only",
        "queue.full*",
    ]);
    assert_eq!(run.status, 0, "{run:?}");
    let lines: Vec<_> = run.out.lines().collect();
    assert_eq!(
        lines[..2],
        ["wait         7 passed", "queue        2 passed"]
    );
    assert!(lines[2].starts_with("all          9 passed in "), "{run:?}");
}

#[test]
fn cases_can_be_read_without_an_arm() {
    let list = run(&["conform", "--list", "--only", "ptp.movl-100-mm"]);
    assert_eq!(list.status, 0);
    assert_eq!(
        list.out.lines().last(),
        Some("| ptp.movl-100-mm | 100 mm straight take 2.000 s at 50 % | VL | model 7 | moves |")
    );
    let whole = run(&["conform", "--list", "-v", "--only", "ptp.movl-100-mm"]);
    assert!(whole.out.contains("    done after 2 s\n"), "{whole:?}");
    let object = run(&["conform", "--list", "--json", "--only", "ptp.movl-100-mm"]).object();
    assert_eq!(object["steps"][0], "set QueuedCmdStartExec");
}

#[test]
fn contradictory_flags_are_refused() {
    let unknown = run(&["--port", "sim", "conform", "--only", "pto", "--json"]);
    assert_eq!(
        (unknown.status, unknown.error()["kind"].as_str()),
        (3, Some("invalid-input"))
    );
    let speed = run(&["--port", "sim:5", "conform", "--json"]);
    assert_eq!(
        (speed.status, speed.error()["kind"].as_str()),
        (2, Some("usage"))
    );
}

#[cfg(unix)]
mod on_a_line {
    use crate::magician::run;
    use crate::magician::served::Served;

    #[test]
    fn arm_moves_only_with_confirmation() {
        let arm = Served::start(&["--tcp", "127.0.0.1:0"], 1);
        let port = arm.endpoint("tcp");
        let refused = run(&["--port", &port, "conform", "--only", "ptp", "--json"]);
        assert_eq!(refused.status, 2, "{refused:?}");
        let error = refused.error();
        assert_eq!(error["kind"], "usage");
        let message = error["message"].as_str().expect("a message");
        assert!(
            message.contains("would move") && message.contains("nothing was sent"),
            "{message}"
        );
    }

    #[test]
    fn different_arm_fails_by_name_and_keeps_its_parameters() {
        let profile = run(&["sim", "--profile", "-"]).out;
        let other = profile.replace("depth = 32 ", "depth = 16 ");
        assert_ne!(profile, other);
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), other).expect("it is written");
        let path = file.path().to_str().expect("UTF-8");
        let arm = Served::start(&["--tcp", "127.0.0.1:0", "--profile", path], 1);
        let port = arm.endpoint("tcp");
        let set = [
            "--port",
            &port,
            "set",
            "PTPCommonParams",
            "velocity_ratio=33",
            "acceleration_ratio=44",
        ];
        assert_eq!(run(&set).status, 0);

        let cases = [
            "--only",
            "queue.depth",
            "--only",
            "wait.zero",
            "--only",
            "wifi.ssid",
        ];
        let conform = run(&[&["--port", &port, "conform", "--json"][..], &cases].concat());
        assert_eq!(conform.status, 10, "{conform:?}");
        assert_eq!(conform.error()["kind"], "check-failed");
        let objects = conform.objects();
        let of = |name: &str| {
            objects
                .iter()
                .find(|object| object["case"] == name)
                .expect("a case")
        };
        assert_eq!(of("wait.zero")["outcome"], "passed");
        assert_eq!(of("wifi.ssid")["outcome"], "skipped");
        let failed = of("queue.depth");
        assert_eq!(failed["outcome"], "failed");
        assert_eq!(failed["failure"]["sent"], "AA AA 06 6E 03 00 00 00 00 8F");
        assert_eq!(failed["failure"]["step"], "31x queue WAITCmd timeout=0");
        assert!(
            failed["failure"]["received"]
                .as_str()
                .is_some_and(|bytes| bytes.starts_with("AA AA 0A 6E 07 00"))
        );

        let get = run(&["--port", &port, "get", "PTPCommonParams", "--json"]).object();
        assert_eq!(
            get,
            serde_json::json!({"velocity_ratio": 33.0, "acceleration_ratio": 44.0})
        );
        let left = run(&["--port", &port, "queue", "--json"]).object();
        assert_eq!(left["left_space"], 16);
    }
}
