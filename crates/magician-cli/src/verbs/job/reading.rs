//! Reads a file and prepares its program for the place where it is to run.

use magician::commands::EndEffectorParams;
use magician_program::{
    Format, OpenedFile, Preparation, PrepareError, PrepareRequest, PrepareStage, StartPosition,
    Tool, tip,
};

use super::{Job, PreparedJob, RunPlace, defaults, notes};
use crate::context::{Context, StopPolicy};
use crate::failure::{Failure, Kind};
use crate::permission::homed;
use crate::source::Source;

/// File that has been parsed.
pub(super) struct ParsedFile {
    pub(super) source: Source,
    pub(super) file: OpenedFile,
}

impl Job {
    /// Reads and parses the file. Errors in it are reported before an arm is looked for.
    pub(super) fn parse_file(
        &self,
        place: &RunPlace,
        context: &mut Context,
    ) -> Result<ParsedFile, Failure> {
        let source = match &self.text {
            Some(text) if self.file.format == Some(Format::TestGrid) => Source::of_test_grid(text),
            Some(text) => Source::of_text(text),
            None => Source::open(&self.file.file)?,
        };
        let format = source.format(self.file.format)?;
        let mut request = PrepareRequest::new(format, &[]);
        request.bytes = source.bytes();
        request.title.clone_from(&source.title);
        request.options = self.options.clone();
        request.preset_note.clone_from(&self.preset_note);
        request.rest = self.pause;
        let config = context.config()?;
        let defaults = defaults(&config)?;
        request.defaults = match place {
            _ if !self.runs => defaults.for_conversion(),
            RunPlace::NoArm | RunPlace::VirtualArm(_) => defaults.on_virtual_arm(),
            // A station's arm counts as virtual until the station reports that it is real.
            RunPlace::Arm if context.global.station.is_some() => defaults.on_virtual_arm(),
            RunPlace::Arm => defaults,
        };
        request.fence = context.fence();
        request.start = match place {
            RunPlace::NoArm | RunPlace::VirtualArm(_) => StartPosition::Staged,
            RunPlace::Arm => StartPosition::Unread,
        };
        match request.open() {
            Ok(file) => Ok(ParsedFile { source, file }),
            Err(error) => Err(self.refused(&source, error, context)),
        }
    }

    /// Prepares the program of the file for its place, and prints how the file was interpreted.
    pub(super) fn prepared(
        &self,
        parsed: ParsedFile,
        place: &RunPlace,
        context: &mut Context,
    ) -> Result<PreparedJob, Failure> {
        let ParsedFile { source, mut file } = parsed;
        let is_stationed = matches!(place, RunPlace::Arm) && context.global.station.is_some();
        if is_stationed && !context.is_virtual()? {
            file.request.defaults.assumed_surface = None;
        }
        if matches!(place, RunPlace::Arm) && file.request.options.needs_tool_in_force() {
            let tool = context.arm(StopPolicy::Look, async |arm, _| {
                Ok(arm.get::<EndEffectorParams>().await?)
            })?;
            file.request.tool = Some(Tool::from(&tool));
        }
        let mut preparation = file.prepare();
        if let Ok(Preparation::NeedsStart) = preparation {
            let stands = context.arm(StopPolicy::Look, async |arm, _| {
                Ok(arm.preflight_for(&[]).await?)
            })?;
            let tool = file.request.options.tool.or(file.request.defaults.tool);
            let at = tip(&stands, tool);
            file.request.start = at.map_or(StartPosition::Unknown, StartPosition::At);
            preparation = file.prepare();
        }
        let prepared = match preparation {
            Ok(Preparation::Done(prepared)) => *prepared,
            Ok(Preparation::NeedsStart) => {
                return Err(Failure::invalid("the position of the arm is unknown"));
            }
            Err(error) => {
                let is_run = matches!(place, RunPlace::Arm) && !self.look.is_wanted();
                if error.problem.lacks_surface() && is_run {
                    // The surface is measured with the arm, whose position is valid only if it is
                    // homed.
                    let unhomed = self.way.unhomed;
                    context.arm(StopPolicy::Look, async |arm, _| {
                        homed(arm, unhomed).await.map(drop)
                    })?;
                }
                return Err(self.refused(&source, error, context));
            }
        };
        let prepared = if self.look.is_wanted() {
            Ok(prepared)
        } else {
            prepared.fitting()
        };
        let prepared = prepared.map_err(|error| self.refused(&source, error, context))?;
        notes(&source, &prepared.notes, context);
        let loops = if self.repeats {
            None
        } else {
            Some(self.way.loops.unwrap_or(1)).filter(|loops| *loops > 0)
        };
        Ok(PreparedJob {
            prepared: prepared.repeated(loops),
            source,
            verbose: context.global.verbose > 0,
        })
    }

    /// Reports why there is no program, with the notes so far.
    pub(super) fn refused(
        &self,
        source: &Source,
        error: PrepareError,
        context: &Context,
    ) -> Failure {
        notes(source, &error.notes, context);
        let mut failure = source.failure(&error.problem).with_notes(&error.notes);
        // A drawing that does not fit is a result of the check; an unknown surface is an error.
        let is_found = error.stage == PrepareStage::Place && !error.problem.lacks_surface();
        if self.look.checks() && is_found {
            failure.kind = Kind::CheckFailed;
        }
        failure
    }
}
