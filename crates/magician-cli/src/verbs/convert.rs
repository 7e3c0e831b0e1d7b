//! `convert`: from one kind of file to another.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use magician_job::report::Note;
use magician_program::formats::playback::Playback;
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Action, Diagnostic, DiagnosticCode, Plan, Travel, WorkOption};
use magician_sim::world::PictureOptions;
use serde::Serialize;

use super::job::options::{File, Pen, PlacementOptions, PreviewFlags, RunFlags};
use super::job::{Job, notes};
use crate::context::Context;
use crate::failure::Failure;
use crate::source::Source;
use crate::verbs::sim::picture::Picture;
use crate::voice::Command;

/// Convert a file to another format
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician convert pick.playback pick.plan.json    a plan that people can read, change and compare
  magician convert pick.plan.json pick.playback    for DobotStudio
  magician convert part.gcode part.svg             the lines that it draws, in true size
  magician convert house.svg house.csv             every step with its target point

The ending of the second name selects the output format: .plan.json (or .json), .playback, .svg, .png, .csv. A drawing is placed in front of the arm first.")]
pub(crate) struct Convert {
    #[command(flatten)]
    file: File,
    /// File to write
    #[arg(value_hint = ValueHint::FilePath)]
    to: PathBuf,
    /// Convert drawings and images for the laser instead of the pen
    #[arg(long)]
    laser: bool,
    #[command(flatten)]
    place: PlacementOptions,
    #[command(flatten)]
    pen: Pen,
}

/// What a file becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Plan,
    Playback,
    Picture,
    Points,
}

#[derive(Serialize)]
struct ConversionReport {
    from: String,
    to: String,
    steps: usize,
    /// What the new file cannot say.
    lost: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<Note>,
}

impl Convert {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let kind = kind(&self.to)?;
        let work = match self.laser {
            true => WorkOption::Engrave,
            false => WorkOption::ByFile,
        };
        let (look, way) = (PreviewFlags::default(), RunFlags::default());
        let mut job = Job::new(work, self.file, look, &self.place, way);
        self.pen.say(&mut job.options);
        job.runs = false;
        let (source, plan, read) = job.plan(context)?;
        let lost = write(kind, &plan, &self.to, &source)?;
        notes(&source, &lost, context);
        let answer = ConversionReport {
            from: source.name.clone(),
            to: self.to.display().to_string(),
            steps: plan.steps.len(),
            lost: lost.iter().map(ToString::to_string).collect(),
            notes: Note::all(&Command, read.iter().chain(&lost)),
        };
        context.show(&answer, |out| {
            let (to, steps) = (&answer.to, answer.steps);
            out.line(format_args!("{to}: {steps} steps"))
        })
    }
}

/// By the end of a name.
fn kind(path: &Path) -> Result<Kind, Failure> {
    let end = path.extension().map(|end| end.to_ascii_lowercase());
    match end.as_deref().and_then(|end| end.to_str()) {
        Some("json" | "plan") => Ok(Kind::Plan),
        Some("playback" | "xml") => Ok(Kind::Playback),
        Some("svg" | "png") => Ok(Kind::Picture),
        Some("csv") => Ok(Kind::Points),
        _ => {
            let message = format!("cannot infer the output format from {}", path.display());
            Err(Failure::usage(message).hint("use .plan.json, .playback, .svg, .png or .csv"))
        }
    }
}

/// Writes a plan as such a file; what that cannot say.
fn write(
    kind: Kind,
    plan: &Plan,
    path: &Path,
    source: &Source,
) -> Result<Vec<Diagnostic>, Failure> {
    let lost = |what: &str| vec![Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut)];
    match kind {
        Kind::Plan => put(path, plan.to_json().as_bytes()).map(|()| Vec::new()),
        Kind::Playback => {
            let playback = Playback::from_plan(plan).map_err(|problem| source.failure(&problem))?;
            put(path, playback.to_xml().as_bytes())?;
            Ok(playback.notes().to_vec())
        }
        Kind::Points => {
            put(path, points(plan).as_bytes())?;
            Ok(lost("a list of points has no speeds, tool or settings"))
        }
        Kind::Picture => {
            let done = rehearse(plan, &RehearseOptions::default())?;
            if done.drawing.is_empty() {
                let (what, hint) = match plan.steps.iter().any(|step| step.action.marks()) {
                    true => (
                        "none of its lines is within reach",
                        "`magician run --check` shows how far out of reach it is, `--fit` makes \
                            it fit",
                    ),
                    false => (
                        "it draws and burns nothing",
                        "`magician run --preview` shows the path of the tool",
                    ),
                };
                return Err(Failure::invalid(format!("{}: {what}", source.name)).hint(hint));
            }
            let picture = Picture::at(path.to_owned()).map_err(Failure::usage)?;
            picture.keep(&done.drawing, &PictureOptions::default())?;
            Ok(lost(
                "a picture has only the lines that are drawn: no speeds, no travel between them",
            ))
        }
    }
}

fn put(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes)
        .map_err(|error| Failure::invalid(format!("{} cannot be written: {error}", path.display())))
}

/// Each step with the point that it leads to.
fn points(plan: &Plan) -> String {
    let mut text = "step,action,x,y,z,r,line,name\n".to_owned();
    for (nth, step) in plan.steps.iter().enumerate() {
        let point = step
            .action
            .target()
            .map(|point| point.map(|value| value.to_string()));
        let [x, y, z] = point.unwrap_or_default();
        let r = match &step.action {
            Action::Move { to: [.., r], .. } | Action::Arc { to: [.., r], .. } => r.to_string(),
            _ => String::new(),
        };
        let line = match step.origin.line {
            0 => String::new(),
            line => line.to_string(),
        };
        let name = plan.name_of(&step.origin).map(quoted).unwrap_or_default();
        let word = word(&step.action);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{word},{x},{y},{z},{r},{line},{name}", nth + 1);
    }
    text
}

fn word(action: &Action) -> &'static str {
    match action {
        Action::Move { by, .. } => match by {
            Travel::Joints => "movj",
            Travel::Line => "movl",
            Travel::Jump => "jump",
        },
        Action::Joints { .. } => "joints",
        Action::Shift { .. } => "shift",
        Action::Arc { .. } => "arc",
        Action::Path { .. } => "path",
        Action::Burn { .. } => "burn",
        Action::Suction(_) => "suction",
        Action::Gripper(_) => "gripper",
        Action::Laser(_) => "laser",
        Action::Wait(_) => "wait",
        Action::Home => "home",
        Action::Command(command) => command.row().set_name,
    }
}

/// As CSV has a text with anything in it.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
