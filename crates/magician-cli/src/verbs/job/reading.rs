//! What is in the file, read for the place where it is to run.

use magician::JointAngles;
use magician::words::Preflight;
use magician_program::rehearse::{RehearseOptions, stage, start_of};
use magician_program::{
    Content, Diagnostic, DiagnosticCode, Format, Missing, Origin, Parsed, Plan, ReadOptions, Setup,
    Tool, tip,
};

use super::{Job, Where, notes};
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::source::Source;

/// A file that is there, and understood as far as that does not depend on where it is to run.
pub(super) struct Opened {
    source: Source,
    format: Format,
    reading: Option<Parsed>,
}

/// What was in a file.
pub(super) struct Read {
    pub(super) source: Source,
    pub(super) format: Format,
    pub(super) content: Content,
    /// What of it was taken in a certain way.
    pub(super) notes: Vec<Diagnostic>,
    /// For what depends on where the tool stood when it began.
    pub(super) begun: Option<Begun>,
}

/// A program that depends on where the tool stands when it begins, read for such a place.
pub(super) struct Begun {
    /// The place.
    pub(super) at: [f64; 3],
    /// Whether it was given.
    pub(super) said: bool,
    /// How a virtual arm stands there, if it is one's.
    pub(super) standing: Option<JointAngles>,
    /// The same program read without a place, if it can be: where both go on alike, the place counts no more.
    pub(super) anywhere: Option<Plan>,
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
        let (reading, begun) = match reading {
            Some(reading) => (reading, None),
            None => self.gcode(&source, self.options(), place, context)?,
        };
        notes(&source, &reading.notes, context);
        Ok(Read {
            source,
            format,
            content: reading.content,
            begun,
            notes: reading.notes,
        })
    }

    fn options(&self) -> ReadOptions {
        let mut options = ReadOptions::default();
        options.tolerance = self.pen.tolerance.unwrap_or(options.tolerance);
        options.white = self.file.white;
        options.clip_page = self.place.clip_page;
        options.resample = self.file.resample;
        options
    }

    /// Some G-code depends on where the tool stands when it begins: that place comes with it.
    fn gcode(
        &self,
        source: &Source,
        mut options: ReadOptions,
        place: &Where,
        context: &mut Context,
    ) -> Result<(Parsed, Option<Begun>), Failure> {
        let config = context.config()?;
        let setup = self.setup(place, &config)?;
        setup.prepare(&mut options.gcode, setup.known_surface());
        options.gcode.dialect = self.file.dialect.unwrap_or_default();
        options.gcode.s_max = self.file.s_max;
        options.gcode.laser_speed = setup.laser_speed.unwrap_or(options.gcode.laser_speed);
        if options.gcode.placed {
            return Ok((source.read(Format::Gcode, options)?, None));
        }
        let anywhere = source.read(Format::Gcode, options.clone());
        let lacks_start = |problem: &Diagnostic| problem.missing == Some(Missing::Start);
        if (anywhere.as_ref()).is_ok_and(|read| !read.notes.iter().any(lacks_start)) {
            return anywhere.map(|reading| (reading, None));
        }
        let tool = setup.tool.or(setup.default_tool);
        let anywhere = match anywhere {
            Ok(Parsed {
                content: Content::Plan(plan),
                ..
            }) => Some(plan),
            _ => None,
        };
        if let Some(at) = self.place.start {
            options.gcode.start = Some(before(at, anywhere.is_some(), &setup));
            let begun = Begun {
                at,
                said: true,
                standing: None,
                anywhere,
            };
            return Ok((source.read(Format::Gcode, options)?, Some(begun)));
        }
        let (begins, virtually) = match place {
            Where::Arm => {
                let begins = context.arm(StopPolicy::Look, async |arm, _| {
                    Ok(arm.preflight_for(&[]).await?)
                })?;
                (begins, false)
            }
            _ => (virtual_start(anywhere.as_ref(), &setup, tool)?, true),
        };
        let standing = begins.arm().filter(|_| virtually).map(|arm| arm.joints);
        // As it can be said again.
        let at = tip(&begins, tool).map(|at| at.map(|at| (at * 1000.0).round() / 1000.0));
        let Some(at @ [x, y, z]) = at else {
            return Ok((source.read(Format::Gcode, options)?, None));
        };
        options.gcode.start = Some(before(at, anywhere.is_some(), &setup));
        let mut from_there = source.read(Format::Gcode, options)?;
        let what = format!("it begins at the tool's position, {x:.3},{y:.3},{z:.3}");
        let note = Diagnostic::new(Origin::NONE, what)
            .coded(DiagnosticCode::Assumed)
            .help(format!(
                "--start {x:.3},{y:.3},{z:.3} begins there again from any position"
            ));
        from_there.notes.insert(0, note);
        let begun = Begun {
            at,
            said: false,
            standing,
            anywhere,
        };
        Ok((from_there, Some(begun)))
    }
}

/// Where the arm stands in the coordinates of a program with places of its own, before it is moved: what it does where the arm
/// stands is done there. What only counts from there is moved along.
fn before(at: [f64; 3], has_places: bool, setup: &Setup) -> [f64; 3] {
    let [x, y, z] = at;
    match has_places {
        true => [x - setup.placement.by[0], y - setup.placement.by[1], z],
        false => at,
    }
}

/// How the virtual arm stands that a plan is run on.
fn virtual_start(
    anywhere: Option<&Plan>,
    setup: &Setup,
    tool: Option<Tool>,
) -> Result<Preflight, Failure> {
    let mut options = RehearseOptions::default();
    options.tool = tool;
    let mut plan = anywhere.cloned().unwrap_or_default();
    plan.surface = plan.surface.or(setup.surface);
    Ok(start_of(&stage(&plan, &options)?))
}
