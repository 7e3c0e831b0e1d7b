//! What is in the file, read for the place where it is to run.

use magician::words::Preflight;
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

/// What was in a file.
pub(super) struct Read {
    pub(super) source: Source,
    pub(super) format: Format,
    pub(super) content: Content,
    /// Where the tool stood, for what depends on that and says nothing of it.
    pub(super) start: Option<[f64; 3]>,
    /// What of it was taken in a certain way.
    pub(super) notes: Vec<Problem>,
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
    ) -> Result<Read, Failure> {
        let Opened {
            source,
            format,
            reading,
        } = opened;
        let (reading, start) = match reading {
            Some(reading) => (reading, None),
            None => self.gcode(&source, self.options(), place, context)?,
        };
        notes(&source, &reading.notes, context);
        Ok(Read {
            source,
            format,
            content: reading.content,
            start,
            notes: reading.notes,
        })
    }

    fn options(&self) -> ReadOptions {
        let mut options = ReadOptions::default();
        options.tolerance = self.pen.tolerance.unwrap_or(options.tolerance);
        options
    }

    /// Some G-code depends on where the tool stands when it begins: that place comes with it.
    fn gcode(
        &self,
        source: &Source,
        mut options: ReadOptions,
        place: &Where,
        context: &mut Context,
    ) -> Result<(Reading, Option<[f64; 3]>), Failure> {
        let config = context.config()?;
        let setup = self.setup(place, &config)?;
        options.gcode.surface = setup.known_surface();
        options.gcode.lift = setup.pen.lift;
        options.gcode.start = self.place.start;
        options.gcode.dialect = self.file.dialect.unwrap_or_default();
        options.gcode.s_max = self.file.s_max;
        options.gcode.laser_speed = setup.laser_speed.unwrap_or(options.gcode.laser_speed);
        if self.place.start.is_some() {
            return Ok((source.read(Format::Gcode, options)?, None));
        }
        let anywhere = source.read(Format::Gcode, options.clone());
        if (anywhere.as_ref()).is_ok_and(|read| !read.notes.iter().any(Problem::needs_start)) {
            return anywhere.map(|reading| (reading, None));
        }
        let tool = setup.tool.or(setup.usual_tool);
        let start = match (place, &anywhere) {
            (Where::Arm, _) => {
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
        // As it can be said again.
        let start = tip(&start, tool).map(|start| start.map(|at| (at * 1000.0).round() / 1000.0));
        let Some([x, y, z]) = start else {
            return anywhere.map(|reading| (reading, None));
        };
        if self.way.resume || self.way.from.is_some_and(|step| step > 1) {
            let message = "this program depends on where the tool stood when it was begun, and that is elsewhere by now";
            return Err(Failure::usage(message)
                .hint("give --start X,Y,Z as well, as the run has said it that is to go on"));
        }
        options.gcode.start = start;
        let mut from_there = source.read(Format::Gcode, options)?;
        let what = format!("it begins where the tool stands, at {x:.3},{y:.3},{z:.3}");
        let note = Problem::new(Origin::NONE, what).help(format!(
            "--start {x:.3},{y:.3},{z:.3} begins there again, wherever the tool is then"
        ));
        from_there.notes.insert(0, note);
        Ok((from_there, start))
    }
}

/// How the virtual arm stands that a plan is run on.
fn virtual_start(plan: &Plan, tool: Option<magician_program::Tool>) -> Result<Preflight, Failure> {
    let mut options = RehearseOptions::default();
    options.tool = tool;
    Ok(start_of(&stage(plan, &options)?))
}
