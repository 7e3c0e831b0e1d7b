//! `--trace` and `--faults`: traffic of this program, recorded or disturbed.

use crate::magician;
use crate::magician::{run, run_with};
use serde_json::Value;

/// Returns the commands in a trace in order, each with its direction.
fn commands(trace: &str) -> Vec<(String, String)> {
    let records = run(&["decode", trace, "--json"]).objects();
    let text = |record: &Value, key: &str| record[key].as_str().unwrap_or_default().to_owned();
    let named = |record: &Value| (text(record, "command"), text(record, "direction"));
    records.iter().map(named).collect()
}

struct Fixture(tempfile::TempDir);

impl Fixture {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("directory"))
    }

    fn file(&self, name: &str) -> String {
        let path = self.0.path().join(name);
        path.to_str().expect("UTF-8").to_owned()
    }
}

#[test]
fn trace_contains_requests_and_replies_of_a_verb() {
    let fixture = Fixture::new();
    let file = fixture.file("pose.pcapng");
    let done = run(&["pose", "--port", "sim", "--trace", &file]);
    assert_eq!(done.status, 0, "{done:?}");
    let passed = commands(&file);
    let last = passed.len() - 2;
    let side = |side: &str| ("GetPose".to_owned(), side.to_owned());
    assert_eq!(passed[last..], [side("request"), side("reply")]);
    // The trace can be replayed.
    let replayed = run(&["replay", &file]);
    assert_eq!(replayed.status, 0, "{replayed:?}");
}

/// `docs/reference/FRAMES.md`: six frames for a move that follows another one in a shell.
#[test]
fn move_in_a_shell_reads_the_pose_once() {
    let fixture = Fixture::new();
    let file = fixture.file("moves.pcapng");
    let done = run_with(
        &["--port", "sim", "--trace", &file, "shell"],
        b"home\nmove 220 0 20\nmove 220 10 20\n",
    );
    assert_eq!(done.status, 0, "{done:?}");
    let passed = commands(&file);
    let sent: Vec<_> = { passed.iter() }
        .filter(|(_, side)| side == "request")
        .map(|(name, _)| name.as_str())
        .collect();
    let is_pose = |name: &&str| *name == "GetPose";
    let mut moves = sent.rsplit(is_pose).skip(1);
    let last = moves.next().expect("the last move");
    assert_eq!(
        last,
        [
            "GetQueuedCmdLeftSpace",
            "GetQueuedCmdCurrentIndex",
            "SetPTPCmd",
            "GetQueuedCmdCurrentIndex",
            "GetAlarmsState"
        ]
    );
}

#[test]
fn failed_verb_leaves_its_trace() {
    let fixture = Fixture::new();
    let file = fixture.file("lost.pcapng");
    let lost = run(&[
        "pose",
        "--port",
        "sim",
        "--timeout",
        "0.2",
        "--trace",
        &file,
        "--faults",
        "drop=1,only=replies",
    ]);
    assert_eq!(lost.status, 5, "{lost:?}");
    let passed = commands(&file);
    assert!(!passed.is_empty());
    assert!(
        passed.iter().all(|(_, side)| side == "request"),
        "{passed:?}"
    );
}

#[test]
fn all_connections_of_a_program_share_one_trace() {
    let fixture = Fixture::new();
    let file = fixture.file("doctor.pcapng");
    let done = run(&[
        "doctor", "--port", "sim", "--count", "5", "--trace", &file, "--json",
    ]);
    assert_eq!(done.status, 0, "{done:?}");
    let passed = commands(&file);
    // The bare line asks for the left space, the connection for the alarms.
    for command in ["GetQueuedCmdLeftSpace", "GetAlarmsState", "GetDeviceSN"] {
        assert!(
            passed.iter().any(|(name, _)| name == command),
            "{command}: {passed:?}"
        );
    }
}

#[test]
fn a_shell_has_one_trace_for_all_its_lines() {
    let fixture = Fixture::new();
    let file = fixture.file("shell.pcapng");
    let script = b"pose\nalarms\npose\n";
    let done = magician::run_with(&["shell", "--port", "sim", "--trace", &file], script);
    assert_eq!(done.status, 0, "{done:?}");
    let passed = commands(&file);
    let poses = passed.iter().filter(|(name, _)| name == "GetPose").count();
    assert_eq!(poses, 4, "{passed:?}");
}

#[test]
fn a_trace_that_cannot_be_written_ends_the_verb_before_a_byte_is_sent() {
    let failed = run(&["pose", "--port", "sim", "--json", "--trace", "/nowhere/t"]);
    assert_eq!(failed.status, 3, "{failed:?}");
    assert_eq!(failed.error()["kind"], "invalid-input");
}

#[test]
fn step_over_a_lossy_line_is_executed_once_or_reported_as_uncertain() {
    let script = b"alarms --clear\nmove 220 40 30\nmove --relative 0 0 10\npose --json\n";
    let mut made = 0;
    for seed in 1..8 {
        let faults = format!("drop-chunk=0.05,flip=5e-4,seed={seed}");
        let done = magician::run_with(&["shell", "--port", "sim", "--faults", &faults], script);
        match done.status {
            0 => {
                let pose = done.out.lines().find(|line| line.starts_with('{'));
                let pose: Value = serde_json::from_str(pose.expect("a pose")).expect("JSON");
                let z = pose["z"].as_f64().map(f64::round);
                assert_eq!(z, Some(40.0), "{done:?}");
                made += 1;
            }
            5 | 9 => {}
            _ => panic!("{done:?}"),
        }
    }
    assert!(made > 0);
}

#[test]
fn invalid_faults_are_refused() {
    let wrong = run(&["pose", "--port", "sim", "--json", "--faults", "flop=1"]);
    assert_eq!(wrong.status, 2, "{wrong:?}");
    let served = run(&[
        "sim",
        "--tcp",
        "127.0.0.1:0",
        "--faults",
        "drop=0.1",
        "--json",
    ]);
    assert_eq!(served.status, 2, "{served:?}");
    let served = run(&["sim", "--tcp", "127.0.0.1:0", "--faults", "drop=0.1"]);
    assert!(served.err.contains("magician proxy --faults"), "{served:?}");
}
