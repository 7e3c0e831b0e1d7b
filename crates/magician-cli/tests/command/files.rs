//! Output files of all verbs: either the old file remains or the new one is complete, and no file
//! overwrites another one of the same command.
#![cfg(target_os = "linux")]

use std::fs;
use std::io;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, symlink};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, ExitStatus, Output, Stdio};

use crate::magician::served::Served;
use crate::magician::{command, run};

/// Content of a file before it is replaced.
const OLD: &str = "the old file";
/// Capacity of a small disk, bytes: less than any output here.
const ROOM: u32 = 512;

/// Way in which a verb writes a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// In one piece at the end.
    Whole,
    /// Continuously. The part written before an error is kept.
    Grows,
}

use Kind::{Grows, Whole};

/// Each output of each verb that ends by itself. In the command line IN, BURN, POINTS, SESSION and
/// CLASS stand for input files and OUT for the output.
const OUTPUTS: [(&str, &str, Kind); 27] = [
    ("convert IN OUT", "a.plan.json", Whole),
    ("convert POINTS OUT", "a.playback", Whole),
    ("convert IN OUT", "a.svg", Whole),
    ("convert IN OUT", "a.png", Whole),
    ("convert IN OUT", "a.csv", Whole),
    ("run IN --port sim --picture OUT", "a.svg", Whole),
    ("run IN --port sim --picture OUT", "a.png", Whole),
    ("run IN --port sim --preview OUT", "a.svg", Whole),
    ("run IN --port sim --preview OUT", "a.png", Whole),
    (
        "engrave BURN --port sim --yes --preview OUT",
        "a.svg",
        Whole,
    ),
    ("frame IN --port sim --preview OUT", "a.svg", Whole),
    ("testgrid OUT", "a.plan.json", Whole),
    ("testgrid OUT", "a.svg", Whole),
    ("demo --port sim --out OUT", "a.svg", Whole),
    ("write Anna --port sim --preview OUT", "a.svg", Whole),
    ("write Anna --port sim --picture OUT", "a.svg", Whole),
    ("replay SESSION --clock max --save OUT", "a.pcapng", Whole),
    ("station class new CLASS --html OUT", "a.html", Whole),
    ("run IN --port sim --record OUT", "a.csv", Grows),
    ("run IN --port sim --record OUT", "a.jsonl", Grows),
    ("run IN --port sim --record OUT", "a.mcap", Grows),
    ("run IN --port sim --record OUT", "a.plan.json", Grows),
    ("run IN --port sim --record OUT", "a.playback", Grows),
    ("run IN --port sim --trace OUT", "a.pcapng", Grows),
    ("record OUT --port sim --for 0.1 --yes", "a.mcap", Grows),
    ("move 220 0 20 --port sim --trace OUT", "a.pcapng", Grows),
    ("doctor --port sim --trace OUT", "a.pcapng", Grows),
];

/// Input files, and a folder for the output.
struct Fixture {
    inputs: tempfile::TempDir,
    outputs: tempfile::TempDir,
}

impl Fixture {
    fn new() -> Self {
        let [inputs, outputs] = [(); 2].map(|()| tempfile::tempdir().expect("a directory"));
        let fixture = Self { inputs, outputs };
        // A spiral makes every output larger than the disk.
        let spiral: String = (0..120)
            .map(|nth| {
                let (angle, radius) = (f64::from(nth) * 0.3, 5.0 + f64::from(nth) * 0.1);
                let (sin, cos) = angle.sin_cos();
                format!("G1 X{:.2} Y{:.2}\n", 220.0 + radius * cos, radius * sin)
            })
            .collect();
        let drawing = format!("G21 G90\nG0 X225 Y0 Z20\nG1 Z0 F3000\n{spiral}G0 Z20\n");
        let rows: String = (0..40).map(|y| format!("220,{y},20\n")).collect();
        let pupils: String = (0..20)
            .map(|pupil| format!("[[pupil]]\nname = \"P{pupil}\"\ncode = \"{pupil:04}\"\n"))
            .collect();
        fixture.input("IN.gcode", &drawing);
        let burnt = format!("G21 G90\nM3 S500\nG0 X225 Y0\nF3000\n{spiral}M5\n");
        fixture.input("BURN.gcode", &burnt);
        fixture.input("POINTS.csv", &format!("x,y,z\n{rows}"));
        fixture.input("CLASS.toml", &pupils);
        let session = fixture.inputs.path().join("SESSION.pcapng");
        let session = session.to_str().expect("UTF-8");
        let traced = run(&[
            "move", "220", "0", "20", "--port", "sim", "--trace", session,
        ]);
        assert_eq!(traced.status, 0, "{traced:?}");
        // Another user must be able to use both folders.
        for folder in [&fixture.inputs, &fixture.outputs] {
            let all = fs::Permissions::from_mode(0o777);
            fs::set_permissions(folder.path(), all).expect("set");
        }
        fixture
    }

    fn input(&self, name: &str, text: &str) {
        fs::write(self.inputs.path().join(name), text).expect("written");
    }

    /// Returns the words of a command line.
    fn words(&self, line: &str, name: &str) -> Vec<String> {
        let at = |folder: &tempfile::TempDir, name: &str| {
            let path = folder.path().join(name);
            path.to_str().expect("UTF-8").to_owned()
        };
        let words = line.split(' ').map(|word| match word {
            "IN" => at(&self.inputs, "IN.gcode"),
            "BURN" => at(&self.inputs, "BURN.gcode"),
            "POINTS" => at(&self.inputs, "POINTS.csv"),
            "CLASS" => at(&self.inputs, "CLASS.toml"),
            "SESSION" => at(&self.inputs, "SESSION.pcapng"),
            "OUT" => at(&self.outputs, name),
            word => word.to_owned(),
        });
        words.collect()
    }

    /// Returns names and contents of the output folder, sorted.
    fn files(&self) -> Vec<(String, Vec<u8>)> {
        let entries = fs::read_dir(self.outputs.path()).expect("read");
        let mut files: Vec<_> = entries
            .map(|entry| {
                let entry = entry.expect("an entry");
                let name = entry.file_name().to_str().expect("UTF-8").to_owned();
                (name, fs::read(entry.path()).expect("read"))
            })
            .collect();
        files.sort();
        files
    }

    /// Empties the output folder and writes the old file, if there is one.
    fn before(&self, name: &str, old: Option<&str>) {
        for (name, _) in self.files() {
            fs::remove_file(self.outputs.path().join(name)).expect("removed");
        }
        if let Some(old) = old {
            fs::write(self.outputs.path().join(name), old).expect("written");
        }
    }
}

/// Returns the command behind a line of shell.
pub(crate) fn behind(shell: &str, words: &[String]) -> Command {
    let command = command();
    let mut behind = Command::new("sh");
    behind.args(["-c", &format!("{shell}; exec \"$0\" \"$@\"")]);
    behind.arg(command.get_program()).args(words);
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => behind.env(name, value),
            None => behind.env_remove(name),
        };
    }
    behind.stdin(Stdio::null());
    behind
}

/// Runs a command with a limit on the size of files, like a disk with that capacity.
fn on_small_disk(words: &[String], bytes: u32) -> Output {
    let limit = format!("ulimit -c 0; ulimit -f {}", bytes / 512);
    behind(&limit, words).output().expect("it runs")
}

/// Runs a command and kills it once a file beside the named one has this length, unless it ends
/// before.
fn killed_behind(words: &[String], folder: &Path, name: &str, bytes: u64) -> ExitStatus {
    let mut command = command();
    command.args(words).stdin(Stdio::null());
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let has_grown = |entry: io::Result<fs::DirEntry>| {
        entry.is_ok_and(|entry| {
            entry.file_name() != name && entry.metadata().is_ok_and(|about| about.len() >= bytes)
        })
    };
    loop {
        if let Some(status) = child.try_wait().expect("it is ours") {
            return status;
        }
        if fs::read_dir(folder).expect("read").any(has_grown) {
            child.kill().expect("killed");
            return child.wait().expect("it ends");
        }
        std::thread::yield_now();
    }
}

#[test]
fn full_disk_leaves_the_old_file_and_no_partial_file() {
    let fixture = Fixture::new();
    for (line, name, kind) in OUTPUTS {
        let words = fixture.words(line, name);
        let as_words: Vec<&str> = words.iter().map(String::as_str).collect();
        fixture.before(name, Some(OLD));
        let done = run(&as_words);
        assert_eq!(done.status, 0, "{line}: {done:?}");
        let [(_, whole)] = &fixture.files()[..] else {
            panic!("{line}: {:?}", fixture.files());
        };
        assert!(whole.len() > 2 * ROOM as usize, "{line}: {}", whole.len());
        for old in [Some(OLD), None] {
            fixture.before(name, old);
            let done = on_small_disk(&words, ROOM);
            let err = String::from_utf8_lossy(&done.stderr);
            let files = fixture.files();
            let there = files.iter().find(|(file, _)| file == name);
            let there = there.map(|(_, bytes)| bytes.as_slice());
            if old.is_some() || kind == Whole {
                assert_eq!(there, old.map(str::as_bytes), "{line} {name}: {err}");
            }
            let parts = files.iter().filter(|(file, _)| file != name).count();
            match kind {
                Whole => {
                    assert_eq!(done.status.code(), Some(3), "{line} {name}: {err}");
                    assert!(err.contains(name), "{line} {name}: {err}");
                    assert_eq!(parts, 0, "{line} {name}: a stump is left");
                }
                // The part written before the error is kept, and reported if the old file keeps the
                // name.
                Grows => {
                    assert!(!done.status.success(), "{line} {name}: {err}");
                    assert!(
                        parts <= usize::from(old.is_some()),
                        "{line} {name}: {files:?}"
                    );
                    let part = format!("{name}.partial");
                    assert_eq!(err.contains(&part), parts == 1, "{line} {name}: {err}");
                    let out = String::from_utf8_lossy(&done.stdout);
                    assert!(!out.contains("record: "), "{line} {name}: {out}");
                }
            }
        }
    }
}

#[test]
fn killed_while_it_writes_a_verb_leaves_the_old_file() {
    let fixture = Fixture::new();
    for (line, name, _) in OUTPUTS {
        let words = fixture.words(line, name);
        // Three instants during writing.
        for bytes in [0, 512, 1536] {
            fixture.before(name, Some(OLD));
            let status = killed_behind(&words, fixture.outputs.path(), name, bytes);
            let files = fixture.files();
            let there = files.iter().find(|(file, _)| file == name);
            let (_, there) = there.expect("one of them");
            // If it ended before the kill, the new file must be complete.
            if there != OLD.as_bytes() {
                assert_eq!(files.len(), 1, "{line} {name} {bytes}: {status}");
                let least = 2 * ROOM as usize;
                assert!(there.len() > least, "{line} {name} {bytes}: {status}");
            } else {
                assert_eq!(status.code(), None, "{line} {name} {bytes}");
            }
        }
    }
}

#[test]
fn partial_file_of_a_killed_process_is_removed_but_not_of_a_running_one() {
    let fixture = Fixture::new();
    let words = fixture.words("convert IN OUT", "a.svg");
    fixture.before("a.svg", None);
    let at = |name: &str| fixture.outputs.path().join(name);
    let (left, young, locked, other) = (
        "a.svg.4000000-0.new",
        "a.svg.4000000-1.new",
        "a.svg.4000000-2.new",
        "a.svg.draft-2.new",
    );
    let mut held = Vec::new();
    for name in [left, young, locked, other] {
        let file = fs::File::create(at(name)).expect("made");
        if name != young {
            file.set_modified(std::time::UNIX_EPOCH).expect("set");
        }
        if name == locked {
            file.lock().expect("locked");
            held.push(file);
        }
    }
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = run(&words);
    assert_eq!(done.status, 0, "{done:?}");
    let names: Vec<String> = fixture.files().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["a.svg", young, locked, other]);
}

/// Runs a command as a user without privileges, to whom file permissions apply.
fn as_nobody(words: &[String], home: &Path) -> Output {
    let mut command = command();
    command.args(words).stdin(Stdio::null());
    command
        .env("XDG_STATE_HOME", home)
        .env("XDG_DATA_HOME", home);
    let is_root = fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0);
    if is_root {
        command.uid(65534).gid(65534);
    }
    command.output().expect("it runs")
}

#[test]
fn file_or_folder_without_permission_stays_unchanged() {
    let fixture = Fixture::new();
    let home = tempfile::tempdir().expect("a directory");
    fs::set_permissions(home.path(), fs::Permissions::from_mode(0o777)).expect("set");
    for (line, name, _) in OUTPUTS
        .into_iter()
        .filter(|(line, ..)| !line.contains("CLASS"))
    {
        let words = fixture.words(line, name);
        for (folder, file) in [(0o555, 0o666), (0o777, 0o444)] {
            fixture.before(name, Some(OLD));
            let mode = |path: &Path, mode| {
                fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("set");
            };
            mode(&fixture.outputs.path().join(name), file);
            mode(fixture.outputs.path(), folder);
            let done = as_nobody(&words, home.path());
            mode(fixture.outputs.path(), 0o777);
            assert!(!done.status.success(), "{line} {name}: {done:?}");
            let old = (name.to_owned(), OLD.as_bytes().to_vec());
            assert_eq!(fixture.files(), [old], "{line} {name}");
        }
    }
}

#[test]
fn served_arm_replaces_a_file_at_its_end_and_a_kill_keeps_both() {
    let fixture = Fixture::new();
    for option in ["--trace", "--record"] {
        let name = "a.kept";
        let path = fixture.outputs.path().join(name);
        let words = [
            "--tcp",
            "127.0.0.1:0",
            option,
            path.to_str().expect("UTF-8"),
        ];
        fixture.before(name, Some(OLD));
        let mut served = Served::start(&words, 1);
        assert_eq!(run(&["--port", &served.endpoint("tcp"), "pose"]).status, 0);
        assert_eq!(fs::read(&path).expect("read"), OLD.as_bytes(), "{option}");
        served.child.kill().expect("killed");
        served.child.wait().expect("it ends");
        let files = fixture.files();
        assert_eq!(files[0].1, OLD.as_bytes(), "{option}: {files:?}");
        assert_eq!(
            (files.len(), &*files[1].0),
            (2, "a.kept.partial"),
            "{option}"
        );
        let part = files[1].1.clone();
        let served = Served::start(&words, 1);
        served.end("-TERM");
        let files = fixture.files();
        assert!(files[0].1.len() > OLD.len(), "{option}: {files:?}");
        assert_eq!(
            files[1..],
            [("a.kept.partial".to_owned(), part)],
            "{option}"
        );
    }
}

#[test]
fn output_that_is_an_input_or_another_output_is_refused_and_nothing_is_touched() {
    let fixture = Fixture::new();
    let drawing = "<svg xmlns='http://www.w3.org/2000/svg' width='40mm' height='40mm'>\
        <path d='M0 0H90V90' fill='none' stroke='black'/></svg>";
    fixture.input("h.svg", drawing);
    fixture.input("x.svg", "[table]\n");
    let at = |name: &str| {
        let path = fixture.inputs.path().join(name);
        path.to_str().expect("UTF-8").to_owned()
    };
    let planned = run(&["convert", &at("IN.gcode"), &at("o.plan.json")]);
    assert_eq!(planned.status, 0, "{planned:?}");
    symlink("h.svg", at("link.svg")).expect("linked");
    fs::hard_link(at("h.svg"), at("hard.svg")).expect("linked");
    let [svg, link, hard, plan, scenario] =
        ["h.svg", "link.svg", "hard.svg", "o.plan.json", "x.svg"].map(at);
    let (new, again) = (at("new.svg"), at("./new.svg"));
    let contents = || {
        let all = [&svg, &plan, &scenario, &at("SESSION.pcapng")];
        all.map(|path| fs::read(path).expect("read"))
    };
    let before = contents();
    let names = || fs::read_dir(fixture.inputs.path()).expect("read").count();
    let count = names();
    for words in [
        &["draw", &svg, "--preview", &svg][..],
        &["draw", &svg, "--preview", &link],
        &["draw", &link, "--picture", &hard],
        &["convert", &svg, &svg],
        &["convert", &svg, &hard],
        &["run", &plan, "--record", &plan],
        &["run", &plan, "--trace", &plan],
        &["draw", &svg, "--preview", &new, "--picture", &again],
        &[
            "sim",
            "--tcp",
            "127.0.0.1:0",
            "--scenario",
            &scenario,
            "--picture",
            &scenario,
        ],
        &[
            "sim",
            "--tcp",
            "127.0.0.1:0",
            "--trace",
            &new,
            "--record",
            &again,
        ],
        &[
            "replay",
            &at("SESSION.pcapng"),
            "--save",
            &at("SESSION.pcapng"),
        ],
    ] {
        let done = run(&[&["--port", "sim"], words].concat());
        assert_eq!(
            (done.status, done.out.as_str()),
            (2, ""),
            "{words:?}: {done:?}"
        );
        assert!(done.err.contains("a different name"), "{words:?}: {done:?}");
        assert!(contents() == before && names() == count, "{words:?}");
    }
}
