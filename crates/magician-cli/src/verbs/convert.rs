//! `convert`: converts a file of one format into another.

use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use magician_job::files::write_whole;
use magician_job::report::ConversionReport;
use magician_picture::{Conversion, ConversionError};
use magician_program::WorkOption;

use super::job::options::{File, OptionFlags, PreviewFlags, RunFlags, RunsAll};
use super::job::{Job, notes};
use crate::context::Context;
use crate::failure::Failure;
use crate::source::Source;
use crate::voice::Command;

/// Convert a file to another format
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician convert pick.playback pick.plan.json    a readable plan to edit and compare
  magician convert pick.plan.json pick.playback    for DobotStudio
  magician convert part.gcode part.svg             the drawn lines, true to size
  magician convert house.svg house.csv             every step with its target point
  magician convert photo.jpg photo.svg --image hatch --width 120

The extension of the second name selects the output format: .plan.json (or .json), .playback, .svg, \
.png, .csv. A drawing is first placed in front of the arm.")]
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
    options: OptionFlags<RunsAll>,
}

impl Convert {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let work = if self.laser {
            WorkOption::Engrave
        } else {
            WorkOption::ByFile
        };
        let (look, way) = (PreviewFlags::default(), RunFlags::default());
        let mut job = Job::new(work, self.file, look, &self.options, way)?;
        job.runs = false;
        converted(&mut job, &self.to, context)
    }
}

/// Writes what a job would do as another format, and reports it.
pub(super) fn converted(job: &mut Job, to: &Path, context: &mut Context) -> Result<(), Failure> {
    let answer = written(job, to, context)?;
    context.show(&answer, |out| {
        let (to, steps) = (&answer.to, answer.steps);
        out.line(format_args!("{to}: {steps} steps"))
    })
}

/// Writes what a job would do as another format.
pub(super) fn written(
    job: &mut Job,
    to: &Path,
    context: &mut Context,
) -> Result<ConversionReport, Failure> {
    let conversion = conversion(to)?;
    let (source, plan, read) = job.plan(context)?;
    let made = conversion.file(&plan);
    let (bytes, lost) = made.map_err(|error| refused(error, &source))?;
    write_file(to, &bytes)?;
    notes(&source, &lost, context);
    let names = [source.name.clone(), to.display().to_string()];
    Ok(ConversionReport::new(
        &Command,
        names,
        plan.steps.len(),
        &read,
        &lost,
    ))
}

/// Returns the output format for the extension of a path.
fn conversion(path: &Path) -> Result<Conversion, Failure> {
    let end = path.extension().and_then(|end| end.to_str());
    let known = end.and_then(|end| Conversion::of(&format!("file.{end}")));
    known.ok_or_else(|| {
        let message = format!("cannot infer the output format from {}", path.display());
        Failure::usage(message).hint("use .plan.json, .playback, .svg, .png or .csv")
    })
}

/// Converts the reason why a job has no such format into a failure.
fn refused(error: ConversionError, source: &Source) -> Failure {
    let empty = |what: &str| Failure::invalid(format!("{}: {what}", source.name));
    match error {
        ConversionError::Refused(problem) => source.failure(&problem),
        ConversionError::Rehearsal(error) => Failure::from(&error),
        ConversionError::OutOfReach => empty("none of its lines is within reach").hint(
            "`magician run --check` shows how far out of reach it is, `--fit` shrinks it to fit",
        ),
        ConversionError::DrawsNothing => empty("it draws and burns nothing")
            .hint("`magician run --preview` shows the path of the tool"),
        other => Failure::invalid(format!("{}: {other:?}", source.name)),
    }
}

fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_whole(path, bytes).map_err(|error| Failure::unwritable(path, &error))
}
