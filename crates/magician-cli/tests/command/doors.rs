//! The same file with the same options gives the same program in every front end: command, station,
//! and a page's station, whose files a second module prepares. `magician-py/tests/test_doors.py`
//! compares Python with the command.

use std::path::Path;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::preflight::Preflight;
use magician::{Ctrl, FrameBuf};
use magician_program::rehearse::{RehearseOptions, tool_of};
use magician_program::wire::{answer, answer_from};
use magician_program::{
    Format, Preparation, PrepareRequest, PreparedProgram, SetupDefaults, StartPosition,
};
use magician_protocol::{Direction, describe};
use magician_station::{
    FilePreparation, FilePreparer, FormatReader, LocalPreparer, ProgramReading, Reader, ReadingArm,
    Source,
};
use serde_json::{Value, json};

use crate::magician::run;

/// Verb with flags, and the equivalent options.
type Options<'a> = (&'a [&'a str], Value);

/// Result of a front end: commands of the steps and notes, or the refusal.
type Made = Result<(Vec<Value>, Vec<Value>), String>;

/// Second module of a page, to which requests and answers go as bytes.
struct Worker;

impl FilePreparer for Worker {
    fn prepare(&self, request: PrepareRequest) -> FilePreparation {
        let answer = answer_from(&request, &answer(&request.to_bytes()));
        FilePreparation::Ready(answer.expect("an answer of this build"))
    }
}

fn commands(program: &PreparedProgram) -> Vec<Value> {
    let steps = program.program.plan().steps.iter();
    let commands = steps.filter_map(|step| step.action.command());
    let commands = commands.map(|command| {
        let frame = FrameBuf::set(&command, Ctrl::QUEUED).expect("it fits");
        let meaning = describe(&frame.frame(), Direction::Request).expect("it is known");
        // Through text, so that numbers have the digits that the command prints.
        let params = serde_json::to_string(&meaning).expect("values");
        let params: Value = serde_json::from_str(&params).expect("JSON");
        json!({"command": meaning.name, "params": params})
    });
    commands.collect()
}

fn note(code: &Value, text: &Value, line: &Value) -> Value {
    json!([code, text, line])
}

/// Returns the command's result, without notes of the check, which other front ends add later.
fn by_command(file: &str, options: &[&str]) -> Made {
    let (verb, flags) = options.split_first().expect("a verb");
    let ran = run(&[&[*verb, file, "--dry-run", "--json"], flags].concat());
    let mut objects = ran.objects();
    let Some(report) = objects.pop() else {
        return Err(ran.error()["message"]
            .as_str()
            .unwrap_or_default()
            .to_owned());
    };
    let notes = report["notes"].as_array().cloned().unwrap_or_default();
    let notes = { notes.iter() }
        .filter(|note| !["doubtful", "long"].contains(&note["code"].as_str().unwrap_or_default()))
        .map(|of| note(&of["code"], &of["text"], &of["line"]));
    let notes = notes.collect();
    let steps = objects.into_iter().filter(|order| !order["step"].is_null());
    let steps = steps.map(|order| json!({"command": order["command"], "params": order["params"]}));
    Ok((steps.collect(), notes))
}

fn by_station(format: Format, bytes: &[u8], setup: &Value, files: Arc<dyn FilePreparer>) -> Made {
    let mut source = json!({"data": STANDARD.encode(bytes), "format": format.name()});
    if !setup.is_null() {
        source["setup"] = setup.clone();
    }
    let source: Source = serde_json::from_value(source).expect("a source");
    let mut arm = ReadingArm::default();
    arm.is_virtual = true;
    let reader = FormatReader::with_preparer(SetupDefaults::default(), files);
    let read = |arm: &ReadingArm| reader.read(&source, arm);
    let mut reading = read(&arm);
    if let Ok(ProgramReading::NeedsStart) = reading {
        arm.start_state = Some(staged(format, bytes));
        reading = read(&arm);
    }
    match reading {
        Ok(ProgramReading::Done(program, _)) => {
            let notes = program.notes.iter().map(|note| {
                let line = Some(note.origin.line).filter(|line| *line > 0);
                json!([note.code.name(), note.message.as_str(), line])
            });
            Ok((commands(&program), notes.collect()))
        }
        Err(error) => Err(error.message),
        Ok(_) => panic!("{format}"),
    }
}

/// Returns the state of the command's virtual arm before a file that runs as it is.
fn staged(format: Format, bytes: &[u8]) -> Preflight {
    let mut request = PrepareRequest::new(format, bytes);
    request.defaults = request.defaults.on_virtual_arm();
    request.start = StartPosition::Staged;
    match request.prepare() {
        Ok(Preparation::Done(program)) => {
            let tool = tool_of(program.program.plan(), &RehearseOptions::default());
            Preflight::at(program.stands.expect("it depends on it"), tool.bias())
        }
        other => panic!("{other:?}"),
    }
}

/// Asserts equal steps, and notes at the same lines that begin with the same words.
fn assert_same(case: &str, command: &Made, other: &Made) {
    match (command, other) {
        (Ok((steps, notes)), Ok((expected, told))) => {
            assert_eq!(steps.len(), expected.len(), "{case}: number of steps");
            for (nth, (step, expected)) in steps.iter().zip(expected).enumerate() {
                assert_eq!(step, expected, "{case}: step {}", nth + 1);
            }
            assert_eq!(notes.len(), told.len(), "{case}: {notes:?} {told:?}");
            for (note, told) in notes.iter().zip(told) {
                assert_eq!(
                    (&note[0], &note[2]),
                    (&told[0], &told[2]),
                    "{case}: {note} {told}"
                );
                let [text, message] = [&note[1], &told[1]].map(|text| text.as_str().unwrap());
                assert!(text.contains(message), "{case}: {text} without {message}");
            }
        }
        (Err(command), Err(other)) => {
            assert!(
                command.contains(other.as_str()),
                "{case}: {command} without {other}"
            );
        }
        (command, other) => panic!("{case}: {command:?} {other:?}"),
    }
}

#[test]
fn sample_is_the_same_program_at_command_station_and_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../magician-program/samples");
    let options: [Options<'_>; 5] = [
        (&["run"], Value::Null),
        (
            &["draw", "--fit", "--page", "a4"],
            json!({"work": "draw", "fit": true, "page": "a4"}),
        ),
        (&["draw", "--place"], json!({"work": "draw", "place": true})),
        (
            &["draw", "--scale", "0.3", "--grid", "2x1:30x20"],
            json!({"work": "draw", "scale": 0.3, "grid": "2x1:30x20"}),
        ),
        (
            &["engrave", "--power", "60", "--speed", "30"],
            json!({"work": "engrave", "power": 60, "speed": 30}),
        ),
    ];
    let (mut programs, mut refusals) = (0, 0);
    let mut files: Vec<_> = folder
        .read_dir()
        .unwrap()
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    for path in files {
        let bytes = std::fs::read(&path).unwrap();
        let Some(format) = Format::of(&path.to_string_lossy(), b"") else {
            continue;
        };
        let name = path.file_name().unwrap().to_string_lossy();
        for (flags, setup) in &options {
            let case = format!("{name} {}", flags.join(" "));
            let command = by_command(&path.to_string_lossy(), flags);
            let doors: [Arc<dyn FilePreparer>; 2] = [Arc::new(LocalPreparer), Arc::new(Worker)];
            for door in doors {
                assert_same(&case, &command, &by_station(format, &bytes, setup, door));
            }
            match command {
                Ok(_) => programs += 1,
                Err(_) => refusals += 1,
            }
        }
    }
    assert!(programs >= 40 && refusals >= 1, "{programs} {refusals}");
}
