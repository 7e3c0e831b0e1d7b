//! A full disk costs the file, and never the work.
#![cfg(target_os = "linux")]

use std::os::unix::fs::symlink;

use std::process::Command;

use crate::magician::{Run, command, run};
use serde_json::json;

/// A drawing of some strokes.
const DRAWING: &str =
    "G21 G90\nG0 X200 Y0 Z20\nG1 Z0 F3000\nG1 X230\nG1 Y30\nG1 X200\nG1 Y0\nG0 Z20\n";

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().expect("a directory"));
        std::fs::write(place.at("square.gcode"), DRAWING).expect("written");
        place
    }

    fn at(&self, name: &str) -> String {
        let path = self.0.path().join(name);
        path.to_str().expect("UTF-8").to_owned()
    }

    /// A file on a disk that is full.
    fn full(&self, name: &str) -> String {
        symlink("/dev/full", self.at(name)).expect("a link");
        self.at(name)
    }

    fn draws(&self, picture: &str, more: &[&str]) -> (Run, String) {
        let (file, picture) = (self.at("square.gcode"), self.at(picture));
        let arguments = ["--port", "sim", "run", &file, "--picture", &picture];
        let done = run(&[&arguments[..], more].concat());
        (done, std::fs::read_to_string(picture).unwrap_or_default())
    }
}

#[test]
fn a_recording_on_a_full_disk_leaves_the_drawing_whole() {
    let place = Place::new();
    for name in ["a.csv", "b.jsonl", "c.mcap"] {
        let file = place.full(name);
        let (done, drawn) = place.draws(&format!("{name}.svg"), &["--record", &file]);
        assert_eq!(done.status, 4, "{done:?}");
        assert!(done.out.contains("done in"), "{done:?}");
        assert!(done.err.contains("the work goes on"), "{done:?}");
        assert!(
            done.err.contains("error: the recording is incomplete: "),
            "{done:?}"
        );
        for corner in ["M200 0L", "L230 0L", "L230 -30L", "L200 -30L200 0\""] {
            assert!(drawn.contains(corner), "{name}: {drawn}");
        }
    }
}

#[test]
fn with_json_the_result_comes_and_then_the_error() {
    let place = Place::new();
    let file = place.full("a.csv");
    let (done, _) = place.draws("a.svg", &["--record", &file, "--json"]);
    assert_eq!(done.status, 4, "{done:?}");
    assert_eq!(
        done.objects().last().expect("a result")["first_step"],
        json!(1)
    );
    assert_eq!(done.error()["kind"], "port");
}

#[test]
fn a_trace_on_a_full_disk_leaves_the_drawing_whole() {
    let place = Place::new();
    let (_, drawn) = place.draws("whole.svg", &[]);
    let file = place.full("line.pcapng");
    let (done, same) = place.draws("a.svg", &["--trace", &file]);
    assert_eq!(done.status, 4, "{done:?}");
    assert!(done.out.contains("done in"), "{done:?}");
    assert!(
        done.err.contains("error: the trace is incomplete: "),
        "{done:?}"
    );
    assert_eq!(same, drawn);
}

/// Runs the command where no file may have more than so many bytes, as on a disk with that much room.
fn run_on_small_disk(arguments: &[&str], bytes: u32) -> Run {
    let command = command();
    let mut limited = Command::new("sh");
    // Writes beyond the limit fail like on a full disk: the signal for it is ignored.
    let script = format!(
        "trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"",
        bytes / 512
    );
    limited.args(["-c", &script]);
    limited.arg(command.get_program()).args(arguments);
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => limited.env(name, value),
            None => limited.env_remove(name),
        };
    }
    Run::of(&mut limited, b"")
}

/// What each verb writes as a whole, with the words before the file's name and those behind it.
const OUTPUTS: [(&[&str], &str, &[&str]); 13] = [
    (&["convert", "IN"], "a.plan.json", &[]),
    (&["convert", "POINTS"], "a.playback", &[]),
    (&["convert", "IN"], "a.svg", &[]),
    (&["convert", "IN"], "a.png", &[]),
    (&["convert", "IN"], "a.csv", &[]),
    (&["run", "IN", "--port", "sim", "--picture"], "a.svg", &[]),
    (&["run", "IN", "--port", "sim", "--picture"], "a.png", &[]),
    (&["run", "IN", "--port", "sim", "--preview"], "a.svg", &[]),
    (&["run", "IN", "--port", "sim", "--preview"], "a.png", &[]),
    (&["testgrid"], "a.plan.json", &[]),
    (&["testgrid"], "a.svg", &[]),
    (&["demo", "--out"], "a.svg", &["--port", "sim"]),
    (
        &["write", "Anna", "--port", "sim", "--preview"],
        "a.svg",
        &[],
    ),
];

#[test]
fn full_disk_leaves_the_file_that_was_there_and_no_stump() {
    let place = Place::new();
    // A spiral, so that every output is larger than the disk.
    let spiral: String = (0..120)
        .map(|nth| {
            let (angle, radius) = (f64::from(nth) * 0.3, 5.0 + f64::from(nth) * 0.1);
            let (sin, cos) = angle.sin_cos();
            format!("G1 X{:.2} Y{:.2}\n", 220.0 + radius * cos, radius * sin)
        })
        .collect();
    let drawing = format!("G21 G90\nG0 X225 Y0 Z20\nG1 Z0 F3000\n{spiral}G0 Z20\n");
    let input = place.at("spiral.gcode");
    std::fs::write(&input, drawing).expect("written");
    let points = place.at("points.csv");
    let rows: String = (0..40).map(|y| format!("220,{y},20\n")).collect();
    std::fs::write(&points, format!("x,y,z\n{rows}")).expect("written");
    for (verb, name, more) in OUTPUTS {
        let folder = tempfile::tempdir().expect("a directory");
        let path = folder.path().join(name);
        let file = path.to_str().expect("UTF-8");
        let words = verb.iter().map(|word| match *word {
            "IN" => &*input,
            "POINTS" => &*points,
            word => word,
        });
        let words: Vec<&str> = words.chain([file]).chain(more.iter().copied()).collect();
        let done = run(&words);
        assert_eq!(done.status, 0, "{words:?}: {done:?}");
        let whole = std::fs::read(&path).expect("it is written");
        assert!(whole.len() > 1024, "{words:?}: {}", whole.len());
        for before in [Some("the old file"), None] {
            match before {
                Some(old) => std::fs::write(&path, old).expect("written"),
                None => std::fs::remove_file(&path).expect("removed"),
            }
            let done = run_on_small_disk(&words, 512);
            assert_eq!(done.status, 3, "{words:?}: {done:?}");
            assert!(done.err.contains(file), "{words:?}: {done:?}");
            let there = std::fs::read_to_string(&path).ok();
            assert_eq!(there.as_deref(), before, "{words:?}");
            let left = std::fs::read_dir(folder.path()).expect("read").count();
            assert_eq!(left, before.iter().count(), "{words:?}: a stump is left");
        }
    }
}
