//! What is in the file, read for the place where it is to run.

use magician::words::Preflight;
use magician_program::formats::NEEDS_START;
use magician_program::rehearse::{RehearseOptions, stage, start_of};
use magician_program::{Content, Format, Origin, Plan, Problem, ReadOptions, Reading, tip};

use super::{Job, Where, notes};
use crate::context::Context;
use crate::failure::Failure;
use crate::source::Source;

/// A file that is there, and understood as far as that does not depend on where it is to run.
pub(super) struct Opened {
    source: Source,
    format: Format,
    reading: Option<Reading>,
}

impl Job {
    /// Opens the file: what is wrong with it is told before an arm is looked for.
    pub(super) fn opened(&self) -> Result<Opened, Failure> {
        let source = Source::open(&self.file.file)?;
        let format = source.format(self.file.format)?;
        let reading = match format {
            Format::Gcode => None,
            _ => Some(source.read(format, self.options())?),
        };
        Ok(Opened {
            source,
            format,
            reading,
        })
    }

    /// Reads it for a place, and tells what of it was taken in a certain way.
    pub(super) fn read(
        &self,
        opened: Opened,
        place: &Where,
        context: &mut Context,
    ) -> Result<(Source, Format, Content), Failure> {
        let Opened {
            source,
            format,
            reading,
        } = opened;
        let reading = match reading {
            Some(reading) => reading,
            None => self.gcode(&source, self.options(), place, context)?,
        };
        notes(&source, &reading.notes, context);
        Ok((source, format, reading.content))
    }

    fn options(&self) -> ReadOptions {
        let mut options = ReadOptions::default();
        options.tolerance = self.pen.tolerance.unwrap_or(options.tolerance);
        options
    }

    /// Some G-code depends on where the tool stands when it begins.
    fn gcode(
        &self,
        source: &Source,
        mut options: ReadOptions,
        place: &Where,
        context: &mut Context,
    ) -> Result<Reading, Failure> {
        let config = context.config()?;
        let setup = self.setup(place, &config)?;
        options.gcode.surface = setup.known_surface();
        options.gcode.lift = setup.pen.lift;
        options.gcode.start = self.place.start;
        if self.place.start.is_some() {
            return source.read(Format::Gcode, options);
        }
        let anywhere = source.read(Format::Gcode, options.clone());
        if (anywhere.as_ref()).is_ok_and(|read| !read.notes.iter().any(needs_start)) {
            return anywhere;
        }
        let tool = setup.tool.or(setup.usual_tool);
        let start = match (place, &anywhere) {
            (Where::Arm(_), _) => {
                context.with_arm(async |arm, _| Ok(arm.preflight_for(&[]).await?))?
            }
            (
                _,
                Ok(Reading {
                    content: Content::Plan(plan),
                    ..
                }),
            ) => virtual_start(plan, tool)?,
            _ => virtual_start(&Plan::default(), tool)?,
        };
        options.gcode.start = tip(&start, tool);
        let Some([x, y, z]) = options.gcode.start else {
            return anywhere;
        };
        let mut from_there = source.read(Format::Gcode, options)?;
        let what = format!("it begins where the tool stands, at {x:.3},{y:.3},{z:.3}");
        let note = Problem::new(Origin::NONE, what).help(format!(
            "--start {x:.3},{y:.3},{z:.3} begins there again, wherever the tool is then"
        ));
        from_there.notes.insert(0, note);
        Ok(from_there)
    }
}

/// Whether it is about a start that is not known.
fn needs_start(problem: &Problem) -> bool {
    let help = problem.help.as_deref();
    help.is_some_and(|help| help.ends_with(NEEDS_START))
}

/// How the virtual arm stands that a plan is run on.
fn virtual_start(plan: &Plan, tool: Option<magician_program::Tool>) -> Result<Preflight, Failure> {
    let mut options = RehearseOptions::default();
    options.tool = tool;
    Ok(start_of(&stage(plan, &options)?))
}
