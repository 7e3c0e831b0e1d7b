//! Output of previews, and of a run's end.

use std::path::Path;

use magician::commands::Pose;
use magician::preflight::Preflight;
use magician::{Ctrl, FrameBuf};
use magician_job::FinalState;
use magician_job::files::write_whole;
use magician_job::report::{CheckReport, Estimate, Note, findings, format_duration};
use magician_picture::{PictureError, Preview, PreviewOptions, fitting};
use magician_program::artwork::Sheet;
use magician_program::{RemainingProgram, Report};
use magician_protocol::{Direction, describe};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::drive::Done;
use super::options::PreviewFlags;
use super::report::{ForPeople, failure};
use super::{PreparedJob, notes};
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::voice::Command;

/// Resolution of PNG files: about 200 dots per inch.
const PIXELS_PER_MM: f64 = 8.0;

/// Program to preview.
pub(super) struct Shown<'a> {
    pub(super) made: &'a PreparedJob,
    /// Index of the first step, from 0.
    pub(super) from: u64,
    pub(super) look: &'a PreviewFlags,
}

/// Command of a dry run as JSON.
#[derive(Serialize)]
struct Order<'a> {
    /// Number of the step, from 1; `None` for commands before the first step.
    step: Option<u64>,
    command: &'static str,
    params: &'a magician_protocol::Description<'a>,
}

impl Shown<'_> {
    /// Checks the program for an arm in the state `start`, and prints the previews that flags ask
    /// for.
    pub(super) fn show(&self, start: Preflight, context: &mut Context) -> Result<(), Failure> {
        let PreparedJob {
            source, prepared, ..
        } = self.made;
        let rest = prepared.program.remaining(self.from, start);
        let rest = rest.map_err(|problem| source.failure(&problem))?;
        let report = rest.check();
        if let Some(path) = &self.look.preview {
            self.draw(path, &rest, &report)?;
        }
        if self.look.dry_run && (context.global.json || context.global.verbose > 0) {
            let json = context.global.json;
            self.commands(&rest, json, &mut context.out)?;
        }
        notes(source, &findings(&report, prepared.placed), context);
        let parks = prepared.ending.check(&rest);
        let is_good = report.is_good() && prepared.misfit.is_none();
        let mut answer = CheckReport::of(prepared, &rest, &report, &Command);
        answer.ok = Some(is_good && parks.is_ok());
        if !self.look.check {
            answer = answer.without_check();
        }
        let preview = self.look.preview.as_ref();
        answer.preview = preview.map(|path| path.display().to_string());
        context.show(&answer, |out| self.lines(&answer, is_good, out))?;
        if is_good {
            parks.map_err(|error| {
                let mut failure = Failure::from(error);
                if self.look.checks() {
                    failure.kind = Kind::CheckFailed;
                }
                failure
            })
        } else {
            Err(failure(self.made, &rest, &report, self.look.checks()))
        }
    }

    fn lines(&self, answer: &CheckReport, is_good: bool, out: &mut Output) -> Result<(), Failure> {
        // A refused program has no duration.
        if is_good {
            out.line(format_args!(
                "{}: {}",
                self.made.source.name,
                answer.estimate.line()
            ))?;
            if let Some(place) = answer.estimate.place() {
                out.line(place)?;
            }
            if let Some(power) = answer.estimate.power_line() {
                out.line(power)?;
            }
        }
        if let Some(fence) = &self.made.prepared.setup.fence {
            out.line(format_args!("fence: {fence}"))?;
        }
        if answer.ok == Some(true) {
            out.line("the arm can do all of it")?;
        }
        match &answer.preview {
            Some(path) => out.line(format_args!("preview: {path}")),
            None => Ok(()),
        }
    }

    fn draw(&self, path: &Path, rest: &RemainingProgram, report: &Report) -> Result<(), Failure> {
        let end = path.extension().map(|end| end.to_ascii_lowercase());
        let mut options = PreviewOptions::default();
        options.sheet = self
            .made
            .prepared
            .setup
            .sheet
            .and_then(|sheet| corners(&sheet));
        let page = self.made.prepared.placed.and_then(|placed| placed.page);
        options.page = page.map(Vec::from);
        options.fence = self.made.prepared.setup.fence;
        let preview = Preview::new(rest.first(), report, rest.told(), &options);
        let bytes = match end.as_deref().and_then(|end| end.to_str()) {
            Some("svg") => preview.to_svg().as_bytes().to_vec(),
            Some("png") => {
                let too_large = |error: &_| matches!(error, PictureError::Size(_));
                let made = fitting(PIXELS_PER_MM, too_large, |scale| preview.to_png(scale));
                made.map_err(|error| Failure::unwritable(path, &error))?
            }
            _ => return Err(Failure::usage("a preview must be a .svg or .png file")),
        };
        write_whole(path, &bytes).map_err(|error| Failure::unwritable(path, &error))
    }

    /// Prints all commands to be sent, up to the end of the first loop.
    fn commands(
        &self,
        rest: &RemainingProgram,
        json: bool,
        out: &mut Output,
    ) -> Result<(), Failure> {
        for (nth, command) in (0_u64..).zip(rest.first_commands()) {
            let step = nth.checked_sub(rest.lead());
            let step = step.map(|nth| rest.from() + nth + 1);
            let frame = FrameBuf::set(&command, Ctrl::QUEUED).map_err(magician::Error::from)?;
            let meaning = describe(&frame.frame(), Direction::Request);
            let meaning = meaning.map_err(magician::Error::from)?;
            if json {
                out.json(&Order {
                    step,
                    command: meaning.name,
                    params: &meaning,
                })?;
                continue;
            }
            let values = meaning.values().map_err(magician::Error::from)?;
            let fields: Vec<String> = values
                .map(|(field, value)| format!("{}={value}", field.name))
                .collect();
            let step = step.map(|step| step.to_string()).unwrap_or_default();
            out.line(format_args!(
                "{step:>6}  {} {}",
                meaning.name,
                fields.join(" ")
            ))?;
        }
        Ok(())
    }
}

pub(super) fn corners(sheet: &Sheet) -> Option<Vec<[f64; 2]>> {
    let [width, height] = sheet.size?;
    let (sin, cos) = sheet.rotation.to_radians().sin_cos();
    let [x, y] = sheet.corner;
    let corner = |right: f64, up: f64| [x + right * cos - up * sin, y + right * sin + up * cos];
    Some(vec![
        corner(0.0, 0.0),
        corner(width, 0.0),
        corner(width, height),
        corner(0.0, height),
    ])
}

/// Reports a completed run and the files that it has written.
pub(super) fn done(
    done: &Done,
    made: &PreparedJob,
    files: &[(&str, Option<String>)],
    context: &mut Context,
) -> Result<(), Failure> {
    let done = &*done.job;
    let program = &made.prepared.program;
    let steps = program.steps().unwrap_or(0).saturating_sub(done.from);
    let rounded = |value: f64| (value * 1000.0).round() / 1000.0;
    let mut object = Map::new();
    let mut put = |name: &str, value: Value| {
        object.insert(name.to_owned(), value);
    };
    put("title", json!(program.plan().title));
    put("steps", json!(steps));
    put("first_step", json!(done.from + 1));
    put("loops", json!(program.iterations()));
    put("seconds", json!(done.seconds));
    put("drawn_mm", json!(rounded(done.report.drawn)));
    put("travel_mm", json!(rounded(done.report.travelled)));
    let estimate = Estimate::new(&done.report, Some(steps));
    if let Some(power) = estimate.power {
        put("power", json!(power));
    }
    if let Some(placed) = made.prepared.placed {
        put("placed", json!(placed));
    }
    if !made.prepared.notes.is_empty() {
        put("notes", json!(Note::all(&Command, &made.prepared.notes)));
    }
    put("first_index", json!(done.ran.first.map(|index| index.0)));
    put("last_index", json!(done.ran.last.map(|index| index.0)));
    if let Some(FinalState {
        pose,
        pen_is_up: up,
        parked,
        ..
    }) = &done.end
    {
        let at = [pose.x, pose.y, pose.z].map(|value| rounded(value.into()));
        let pen = up.map(|up| if up { "up" } else { "down" });
        put("end", json!({"at": at, "pen": pen, "parked": parked}));
    }
    for (name, path) in files {
        if let Some(path) = path {
            put(name, json!(path));
        }
    }
    context.show(&object, |out| {
        let time = format_duration(std::time::Duration::from_secs_f64(done.seconds));
        let indices = match (done.ran.first, done.ran.last) {
            (Some(first), Some(last)) => format!("; queue indices {} to {}", first.0, last.0),
            _ => String::new(),
        };
        out.line(format_args!("done in {time}: {}{indices}", estimate.work()))?;
        if let Some(power) = estimate.power_line() {
            out.line(power)?;
        }
        if let Some(FinalState {
            pose,
            pen_is_up: up,
            parked,
            ..
        }) = &done.end
        {
            let what = match (parked, up) {
                (true, _) => "parked",
                (false, Some(false)) => "the pen stays down",
                (false, _) => "the pen is up",
            };
            let Pose { x, y, z, .. } = pose;
            out.line(format_args!("{what}: x {x:.1} y {y:.1} z {z:.1}"))?;
        }
        for (name, path) in files {
            if let Some(path) = path {
                out.line(format_args!("{name}: {path}"))?;
            }
        }
        Ok(())
    })
}
