//! A full disk costs the file and never stops the work.
#![cfg(target_os = "linux")]

use std::os::unix::fs::symlink;

use crate::files::behind;
use crate::magician::drawing;
use crate::magician::served::Served;
use crate::magician::{Run, run};
use serde_json::json;

/// Drawing of some strokes.
const DRAWING: &str =
    "G21 G90\nG0 X200 Y0 Z20\nG1 Z0 F3000\nG1 X230\nG1 Y30\nG1 X200\nG1 Y0\nG0 Z20\n";

struct Fixture(tempfile::TempDir);

impl Fixture {
    fn new() -> Self {
        let fixture = Self(tempfile::tempdir().expect("a directory"));
        std::fs::write(fixture.at("square.gcode"), DRAWING).expect("written");
        fixture
    }

    fn at(&self, name: &str) -> String {
        let path = self.0.path().join(name);
        path.to_str().expect("UTF-8").to_owned()
    }

    /// Creates a path that is always full.
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
fn full_disk_ends_the_recording_and_not_the_drawing() {
    let fixture = Fixture::new();
    for name in ["a.csv", "b.jsonl", "c.mcap"] {
        let file = fixture.full(name);
        let (done, drawn) = fixture.draws(&format!("{name}.svg"), &["--record", &file]);
        assert_eq!(done.status, 4, "{done:?}");
        assert!(done.out.contains("done in"), "{done:?}");
        assert!(done.err.contains("the run continues"), "{done:?}");
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
fn json_result_precedes_the_error() {
    let fixture = Fixture::new();
    let file = fixture.full("a.csv");
    let (done, _) = fixture.draws("a.svg", &["--record", &file, "--json"]);
    assert_eq!(done.status, 4, "{done:?}");
    assert_eq!(
        done.objects().last().expect("a result")["first_step"],
        json!(1)
    );
    assert_eq!(done.error()["kind"], "port");
}

#[test]
fn full_disk_ends_the_trace_and_not_the_drawing() {
    let fixture = Fixture::new();
    let (_, drawn) = fixture.draws("whole.svg", &[]);
    let file = fixture.full("line.pcapng");
    let (done, same) = fixture.draws("a.svg", &["--trace", &file]);
    assert_eq!(done.status, 4, "{done:?}");
    assert!(done.out.contains("done in"), "{done:?}");
    assert!(
        done.err.contains("error: the trace is incomplete: "),
        "{done:?}"
    );
    assert_eq!(same, drawn);
}

/// Shell's file size limit, which a trace soon reaches.
const LIMIT: &str = "ulimit -c 0; ulimit -f 4";

#[test]
fn file_size_limit_ends_the_trace_and_not_the_work() {
    let fixture = Fixture::new();
    let svg = fixture.at("square.svg");
    let drawing = "<svg xmlns='http://www.w3.org/2000/svg' width='20mm' height='20mm' \
        viewBox='0 0 20 20'><path d='M2 5H18V18H2' fill='none' stroke='black'/></svg>";
    std::fs::write(&svg, drawing).expect("written");
    let gcode = fixture.at("square.gcode");
    for (words, option, what) in [
        (&["run", &gcode][..], "--trace", "trace"),
        (&["run", &gcode, "--rate", "50"], "--record", "recording"),
        (&["draw", &svg], "--trace", "trace"),
        (&["engrave", &svg, "--yes"], "--trace", "trace"),
    ] {
        let file = fixture.at("cut.csv");
        let words = [words, &["--port", "sim", option, &file]].concat();
        let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
        let done = behind(LIMIT, &words).output().expect("it runs");
        let [out, err] = [&done.stdout, &done.stderr].map(|text| String::from_utf8_lossy(text));
        assert_eq!(done.status.code(), Some(4), "{words:?}: {out} {err}");
        assert!(out.contains("done in"), "{words:?}: {out} {err}");
        let incomplete = format!("error: the {what} is incomplete: ");
        assert!(err.contains(&incomplete), "{words:?}: {err}");
        let _ = std::fs::remove_file(file);
    }
}

#[test]
fn file_size_limit_does_not_end_a_served_arm() {
    let fixture = Fixture::new();
    for (option, expected) in [("--trace", 0), ("--record", 4)] {
        let file = fixture.at("cut");
        let words = ["--tcp", "127.0.0.1:0", option, &file];
        let served = Served::of(behind(LIMIT, &[]), "sim", &words, 2);
        let endpoint = served.endpoint("tcp");
        for _ in 0..20 {
            let asked = run(&["--port", &endpoint, "info"]);
            assert_eq!(asked.status, 0, "{option}: {asked:?}");
        }
        let (status, _) = served.end("-TERM");
        assert_eq!(status.code(), Some(expected), "{option}");
        let _ = std::fs::remove_file(file);
    }
}

/// A file takes the place of the journals' folder; not even root can write there.
#[test]
fn drawing_without_saved_progress_warns_once_and_offers_no_resume() {
    use std::process::{Command, Stdio};
    for json in [false, true] {
        let fixture = drawing::Fixture::homed("5");
        let runs = fixture.dir.path().join("state/magician/runs");
        let _ = std::fs::remove_dir_all(&runs);
        std::fs::write(&runs, "").expect("written");
        let more: &[&str] = if json { &["--json"] } else { &[] };
        let mut drawing = fixture.draw(more);
        drawing.stdout(Stdio::piped()).stderr(Stdio::piped());
        let drawing = drawing.spawn().expect("it starts");
        fixture.until_drawn(2.0);
        let id = drawing.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().is_ok());
        let output = drawing.wait_with_output().expect("it ends");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let [out, err] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        let (fixture, said) = if json {
            (&out, r#""text":"the progress cannot be kept: "#)
        } else {
            (&err, "the progress cannot be kept: ")
        };
        assert_eq!(fixture.matches(said).count(), 1, "{out} {err}");
        assert!(fixture.contains(": after a stop this job starts again from the beginning"));
        assert!(!err.contains("--resume"), "{err}");
        if !json {
            assert!(err.contains("--from "), "{err}");
        }
    }
}
