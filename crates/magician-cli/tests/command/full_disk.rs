//! A full disk costs the file, and never the work.
#![cfg(target_os = "linux")]

use std::os::unix::fs::symlink;

use crate::magician::{Run, run};
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
