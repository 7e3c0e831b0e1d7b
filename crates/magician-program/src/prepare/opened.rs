//! Opened file: read once, then placed for an arm.

use magician_host::message;
use magician_host::preflight::Preflight;
use magician_host::{Error, JointAngles};

use super::{
    Preparation, PrepareError, PrepareRequest, PrepareStage, PreparedProgram, StartPosition,
    start_note,
};
use crate::formats::GcodeOptions;
use crate::rehearse::{RehearseOptions, start_of_stage};
use crate::setup::hold_above;
use crate::{
    Action, Content, Diagnostic, Format, Missing, Origin, Parsed, PartSummary, Plan, Prepared,
    Program, ReadOptions, Setup, SetupOptions, read, tip,
};

/// File that has been read but not placed.
///
/// Data of the arm can be added to the [request](Self::request) before [`prepare`](Self::prepare).
/// The file is read again only if that changes how it is read, which only happens for G-code.
#[derive(Clone, Debug)]
pub struct OpenedFile {
    /// Request for its program.
    pub request: PrepareRequest,
    reading: Option<(ReadOptions, Reading)>,
}

/// Result of reading a file without a start position.
#[derive(Clone, Debug)]
enum Reading {
    /// The program does not depend on a start position.
    Whole(Parsed),
    /// The program depends on its start position. `Ok` if it can be read without one all the same.
    DependsOnStart(Result<Parsed, Diagnostic>),
}

/// File read with its start position.
struct FileRead {
    parsed: Parsed,
    start: Option<Start>,
}

/// Start position of a program that depends on it.
struct Start {
    /// Position of the tool's tip, mm.
    at: [f64; 3],
    /// True if the options set the position.
    is_given: bool,
    /// Joint angles of a staged arm at that position.
    staged_joints: Option<JointAngles>,
    /// The same program read without a start position, if possible. From the first step on which
    /// both agree, the start position has no effect.
    anywhere: Option<Plan>,
}

impl OpenedFile {
    pub(super) fn of(request: PrepareRequest) -> Result<Self, PrepareError> {
        let mut opened = Self {
            request,
            reading: None,
        };
        let (options, notes) = opened.request.effective_options();
        let setup = opened.request.setup_of(&options);
        match opened.first_reading(&options, &setup) {
            Ok(reading) => opened.reading = Some(reading),
            Err(problem) => return Err(PrepareError::new(PrepareStage::Read, problem, notes)),
        }
        Ok(opened)
    }

    /// Prepares the program.
    ///
    /// # Errors
    /// [`PrepareError`] with the option that cannot be met.
    pub fn prepare(&mut self) -> Result<Preparation, PrepareError> {
        let (options, mut notes) = self.request.effective_options();
        let setup = self.request.setup_of(&options);
        let file = match self.read(&options, &setup) {
            Ok(Some(file)) => file,
            Ok(None) => return Ok(Preparation::NeedsStart),
            Err(problem) => return Err(PrepareError::new(PrepareStage::Read, problem, notes)),
        };
        match self.placed(&options, setup, file, &mut notes) {
            Ok(program) => Ok(Preparation::Done(Box::new(PreparedProgram {
                notes,
                ..program
            }))),
            Err((stage, problem)) => Err(PrepareError::new(stage, problem, notes)),
        }
    }

    /// Lists the parts of the file with their times, and the notes of reading it. A program that
    /// depends on its start is read as for a virtual arm.
    ///
    /// # Errors
    /// [`PrepareError`] with the mistake in the file, or a chosen part that does not exist.
    pub fn list_parts(&mut self) -> Result<(Vec<PartSummary>, Vec<Diagnostic>), PrepareError> {
        // A list needs no real arm: any start gives the same parts.
        if self.request.start == StartPosition::Unread {
            self.request.start = StartPosition::Staged;
        }
        let (options, mut notes) = self.request.effective_options();
        let setup = self.request.setup_of(&options);
        let listed = self.read(&options, &setup).and_then(|file| {
            let Some(FileRead { parsed, .. }) = file else {
                return Ok(Vec::new());
            };
            notes.extend(parsed.notes);
            setup.list_parts(self.request.format, &parsed.content)
        });
        match listed {
            Ok(parts) => Ok((parts, notes)),
            Err(problem) => Err(PrepareError::new(PrepareStage::Read, problem, notes)),
        }
    }

    /// Reads the file unless it was read already. `None` if the caller must give a start position.
    fn read(
        &mut self,
        options: &SetupOptions,
        setup: &Setup,
    ) -> Result<Option<FileRead>, Diagnostic> {
        let (how, reading) = self.first_reading(options, setup)?;
        let anywhere = match reading {
            Reading::Whole(parsed) => {
                return Ok(Some(FileRead {
                    parsed,
                    start: None,
                }));
            }
            Reading::DependsOnStart(anywhere) => anywhere,
        };
        let rounded = |at: [f64; 3]| at.map(|at| (at * 1000.0).round() / 1000.0);
        let (at, staged_joints) = match (options.start, self.request.start) {
            (Some(at), _) => (Some(at), None),
            (None, StartPosition::Unread) => {
                // Keep the reading for the next call, which will have the start.
                self.reading = Some((how, Reading::DependsOnStart(anywhere)));
                return Ok(None);
            }
            // Rounded so that a user can type it.
            (None, StartPosition::At(at)) => (Some(rounded(at)), None),
            (None, StartPosition::Unknown) => (None, None),
            (None, StartPosition::Staged) => {
                let start = staged(anywhere.as_ref().ok(), setup);
                let start = start.map_err(|error| Diagnostic::of_file(error.to_string()))?;
                let at = tip(&start, setup.tool.or(setup.default_tool));
                (at.map(rounded), start.arm().map(|arm| arm.joints))
            }
        };
        let Some(at) = at else {
            return anywhere.map(|parsed| {
                Some(FileRead {
                    parsed,
                    start: None,
                })
            });
        };
        let anywhere = match anywhere.map(|parsed| parsed.content) {
            Ok(Content::Plan(plan)) => Some(plan),
            _ => None,
        };
        let [x, y, z] = at;
        let mut how = how;
        // The offset is added after reading. Subtract it here, so that motion at the tool's
        // position stays there. If every motion depends on the start, the offset moves the whole
        // program.
        how.gcode.start = Some(match &anywhere {
            Some(_) => [x - setup.placement.by[0], y - setup.placement.by[1], z],
            None => at,
        });
        Ok(Some(FileRead {
            parsed: read(self.request.format, &self.request.bytes, &how)?,
            start: Some(Start {
                at,
                is_given: options.start.is_some(),
                staged_joints,
                anywhere,
            }),
        }))
    }

    /// Reads the file without a start position, unless that is done already.
    fn first_reading(
        &mut self,
        options: &SetupOptions,
        setup: &Setup,
    ) -> Result<(ReadOptions, Reading), Diagnostic> {
        let PrepareRequest {
            format,
            bytes,
            title,
            ..
        } = &self.request;
        let mut how = options.reading(setup);
        title.clone_into(&mut how.title);
        if *format != Format::Gcode {
            // Other formats do not depend on surface and arm.
            how.gcode = GcodeOptions::default();
        }
        if let Some((before, reading)) = self.reading.take()
            && before == how
        {
            return Ok((how, reading));
        }
        let parsed = read(*format, bytes, &how);
        let lacks_start = |problem: &Diagnostic| problem.missing == Some(Missing::Start);
        let depends = *format == Format::Gcode
            // A placed program begins above its first point, wherever the tool is.
            && !how.gcode.placed
            && match &parsed {
                Ok(parsed) => parsed.notes.iter().any(lacks_start),
                Err(problem) => lacks_start(problem),
            };
        let reading = if depends {
            Reading::DependsOnStart(parsed)
        } else {
            Reading::Whole(parsed?)
        };
        Ok((how, reading))
    }

    /// Places the content for the arm and builds the program. Adds its notes to `notes`.
    fn placed(
        &self,
        options: &SetupOptions,
        setup: Setup,
        file: FileRead,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<PreparedProgram, (PrepareStage, Diagnostic)> {
        let format = self.request.format;
        let FileRead { parsed, start } = file;
        let unsaid = start.as_ref().filter(|start| !start.is_given);
        let (at, staged_joints) = (
            unsaid.map(|start| start.at),
            unsaid.and_then(|start| start.staged_joints),
        );
        notes.extend(at.map(start_note));
        notes.extend(parsed.notes);
        let is_taught = matches!(parsed.content, Content::Plan(_));
        let refused = |problem| (PrepareStage::Place, problem);
        let content = { setup.with_adequate_curves(format, parsed.content) }.map_err(refused)?;
        let mut parts = setup.parts_in(&content, 1.0).map_err(refused)?;
        let fills = setup.fills(&content);
        let Prepared {
            mut plan,
            notes: placing,
            placed,
            misfit,
            would_fit,
        } = setup.plan(format, content).map_err(refused)?;
        notes.extend(placing);
        // Fill lines exist only after placing, so count them in the plan.
        if fills {
            PartSummary::count(&mut parts, &plan);
        }
        let scale = placed.map_or(1.0, |placed| placed.scale);
        { parts.iter_mut() }.for_each(|part| part.drawn_mm *= scale);
        if let Some(grid) = options.grid {
            // Surface that a pen must not go below, at each place of the grid.
            let bound = setup.lower_bound(format, &plan).filter(|_| is_taught);
            plan = plan.placed_on(&grid.pallet()).map_err(refused)?;
            if let Some(surface) = bound {
                hold_above(&mut plan, surface).map_err(refused)?;
            }
        }
        // An empty program would succeed silently, which hides a wrong file or option.
        if plan.steps.is_empty() {
            let problem = Diagnostic::of_file(message!("nothing to do in this file"));
            return Err((PrepareStage::Read, problem));
        }
        if self.request.rest > 0 {
            plan.push(Action::Wait(self.request.rest), Origin::NONE);
        }
        let leading = start.map_or(0, |start| start.leading_steps(format, &setup, &plan));
        let settings = options.settings(&mut plan, is_taught);
        let ending = self.request.ending_of(options, &setup);
        let pen_stays_down = ending.stay && ending.draws(&plan);
        Ok(PreparedProgram {
            program: Program::new(plan, Some(1))
                .pen_stays_down(pen_stays_down)
                .with_settings(settings)
                .with_leading(leading),
            format,
            setup,
            ending,
            start: at,
            staged_joints,
            notes: Vec::new(),
            placed,
            misfit,
            would_fit,
            parts,
        })
    }
}

impl Start {
    /// Number of steps that depend on the start position: up to the step from which the plan agrees
    /// with the plan read without it.
    fn leading_steps(self, format: Format, setup: &Setup, plan: &Plan) -> usize {
        let anywhere = self.anywhere.map(Content::Plan);
        let anywhere = anywhere.and_then(|content| setup.plan(format, content).ok());
        anywhere.map_or(plan.steps.len(), |anywhere| {
            leading_steps(plan, &anywhere.plan)
        })
    }
}

/// Number of steps at the beginning of a plan that differ from another plan with the same end.
fn leading_steps(plan: &Plan, other: &Plan) -> usize {
    let pairs = { plan.steps.iter().rev() }.zip(other.steps.iter().rev());
    let alike = pairs.take_while(|(step, other)| step == other).count();
    plan.steps.len() - alike
}

/// State of a virtual arm that is set up for a program.
fn staged(anywhere: Option<&Parsed>, setup: &Setup) -> Result<Preflight, Error> {
    let options = RehearseOptions {
        tool: setup.tool.or(setup.default_tool),
        ..RehearseOptions::default()
    };
    let mut plan = match anywhere.map(|parsed| &parsed.content) {
        Some(Content::Plan(plan)) => plan.clone(),
        _ => Plan::default(),
    };
    plan.surface = plan.surface.or(setup.surface);
    start_of_stage(&plan, &options)
}
