//! From the bytes of a file to a program, as options and settings say.

use magician_host::words::Preflight;
use magician_host::{Error, Set};

use super::SetupOptions;
use crate::rehearse::{RehearseOptions, stands};
use crate::{
    AppliedPlacement, Content, Diagnostic, Ending, Format, Missing, Origin, Parsed, Plan, Prepared,
    Program, ReadOptions, Setup, Surface, Work, WouldFit, tip,
};

/// What came of reading a file.
#[derive(Clone, Debug)]
pub enum Reading {
    /// It was read.
    Done(FileRead),
    /// It depends on where the tool is when it begins, and that was not said.
    UnknownStart(UnknownStart),
}

/// A file that was read.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileRead {
    /// What it is.
    pub format: Format,
    /// What is in it.
    pub content: Content,
    /// What of it was taken in a certain way.
    pub notes: Vec<Diagnostic>,
    /// Where it begins, if it depends on that.
    pub begun: Option<Begun>,
}

/// Where a program begins that depends on it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Begun {
    /// The tip of the tool, mm.
    pub at: [f64; 3],
    /// Whether it was said, and not read from an arm.
    pub said: bool,
    /// The same program read without a place, if it can be: where both go on alike, the place counts no more.
    anywhere: Option<Plan>,
}

/// A program that depends on where the tool is when it begins.
#[derive(Clone, Debug)]
pub struct UnknownStart {
    anywhere: Option<Plan>,
    options: ReadOptions,
}

impl SetupOptions {
    /// Reads a file of this name, to be done so.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(
        &self,
        format: Format,
        bytes: &[u8],
        title: &str,
        setup: &Setup,
    ) -> Result<Reading, Diagnostic> {
        let mut options = self.reading(setup);
        title.clone_into(&mut options.title);
        if format != Format::Gcode || options.gcode.placed {
            return Ok(Reading::Done(read(format, bytes, &options)?));
        }
        let anywhere = read(format, bytes, &options);
        let lacks_start = |problem: &Diagnostic| problem.missing == Some(Missing::Start);
        match anywhere {
            Ok(anywhere) if !anywhere.notes.iter().any(lacks_start) => Ok(Reading::Done(anywhere)),
            anywhere => {
                let anywhere = match anywhere.map(|read| read.content) {
                    Ok(Content::Plan(plan)) => Some(plan),
                    _ => None,
                };
                let unknown = UnknownStart { anywhere, options };
                Ok(match self.start {
                    Some(at) => Reading::Done(unknown.at(bytes, setup, at, true)?),
                    None => Reading::UnknownStart(unknown),
                })
            }
        }
    }

    /// True if it is drawn or engraved: the pen or the laser leaves the work at its end.
    #[must_use]
    pub fn is_drawing(&self, setup: &Setup, format: Format) -> bool {
        setup.work != Work::Default || setup.framing.is_some() || format.is_drawing()
    }

    /// Lays what was read before the arm.
    ///
    /// # Errors
    /// What cannot be done so.
    pub fn lay(&self, setup: &Setup, read: FileRead) -> Result<LaidFile, Diagnostic> {
        let FileRead {
            format,
            content,
            begun,
            ..
        } = read;
        let taught = matches!(content, Content::Plan(_));
        let anywhere = begun.as_ref().and_then(|begun| begun.anywhere.clone());
        let anywhere = anywhere.map(|plan| setup.plan(format, Content::Plan(plan)));
        let Prepared {
            plan,
            notes,
            placed,
            misfit,
            would_fit,
            ..
        } = setup.plan(format, content)?;
        let bound = setup.bound_of(format, &plan);
        Ok(LaidFile {
            plan,
            notes,
            placed,
            misfit,
            would_fit,
            taught,
            depends: begun.is_some(),
            anywhere: anywhere.and_then(Result::ok).map(|made| made.plan),
            bound: bound.filter(|_| taught),
        })
    }
}

impl UnknownStart {
    /// How a virtual arm of its own stands before it.
    ///
    /// # Errors
    /// As [`stage`](crate::rehearse::stage).
    pub fn on_stage(&self, setup: &Setup) -> Result<Preflight, Error> {
        let options = RehearseOptions {
            tool: setup.tool.or(setup.default_tool),
            ..RehearseOptions::default()
        };
        let mut plan = self.anywhere.clone().unwrap_or_default();
        plan.surface = plan.surface.or(setup.surface);
        stands(&plan, &options)
    }

    /// Reads it to begin where an arm stands.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from(
        self,
        bytes: &[u8],
        setup: &Setup,
        begins: &Preflight,
    ) -> Result<FileRead, Diagnostic> {
        let tool = setup.tool.or(setup.default_tool);
        self.begun_at(bytes, setup, tip(begins, tool))
    }

    /// Reads it to begin where the tip of the tool is, as far as that is known.
    pub(super) fn begun_at(
        self,
        bytes: &[u8],
        setup: &Setup,
        tip: Option<[f64; 3]>,
    ) -> Result<FileRead, Diagnostic> {
        // As it can be said again.
        let at = tip.map(|at| at.map(|at| (at * 1000.0).round() / 1000.0));
        match at {
            Some(at) => self.at(bytes, setup, at, false),
            None => read(Format::Gcode, bytes, &self.options),
        }
    }

    fn at(
        mut self,
        bytes: &[u8],
        setup: &Setup,
        at: [f64; 3],
        said: bool,
    ) -> Result<FileRead, Diagnostic> {
        let [x, y, z] = at;
        // In the coordinates of a program with places of its own, before it is moved: what it does where the arm stands is done
        // there. What only counts from there is moved along.
        self.options.gcode.start = Some(match &self.anywhere {
            Some(_) => [x - setup.placement.by[0], y - setup.placement.by[1], z],
            None => at,
        });
        let from_there = read(Format::Gcode, bytes, &self.options)?;
        Ok(FileRead {
            begun: Some(Begun {
                at,
                said,
                anywhere: self.anywhere,
            }),
            ..from_there
        })
    }
}

fn read(format: Format, bytes: &[u8], options: &ReadOptions) -> Result<FileRead, Diagnostic> {
    let Parsed { content, notes } = crate::read(format, bytes, options)?;
    Ok(FileRead {
        format,
        content,
        notes,
        begun: None,
    })
}

/// A file that lies before the arm.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LaidFile {
    /// What it does, once.
    pub plan: Plan,
    /// What was taken in a certain way.
    pub notes: Vec<Diagnostic>,
    /// How it lies, if it was placed.
    pub placed: Option<AppliedPlacement>,
    /// Why it does not fit there.
    pub misfit: Option<Diagnostic>,
    /// In which size it would.
    pub would_fit: Option<WouldFit>,
    taught: bool,
    depends: bool,
    anywhere: Option<Plan>,
    /// The surface that a pen never goes below, wherever it is repeated.
    bound: Option<Surface>,
}

impl LaidFile {
    /// The program: at each place of the grid, with a rest (ms) at the end of each loop, so often; without end if `None`.
    ///
    /// # Errors
    /// More places than can be.
    pub fn program(
        self,
        options: &SetupOptions,
        ending: &Ending,
        rest: u32,
        loops: Option<u64>,
    ) -> Result<Program, Diagnostic> {
        let mut plan = match options.grid {
            Some(grid) => {
                let mut all = self.plan.placed_on(&grid.pallet())?;
                if let Some(surface) = self.bound {
                    all.hold_above(surface)?;
                }
                all
            }
            None => self.plan,
        };
        if rest > 0 {
            plan.push(crate::Action::Wait(rest), Origin::NONE);
        }
        let leading = match (&self.anywhere, self.depends) {
            (_, false) => 0,
            (Some(anywhere), true) => plan.leading_from(anywhere),
            (None, true) => plan.steps.len(),
        };
        let settings: Vec<Set> = options.settings(&mut plan, self.taught);
        let stays = ending.stay && ending.draws(&plan);
        let program = Program::new(plan, loops).pen_stays_down(stays);
        Ok(program.with_settings(settings).with_leading(leading))
    }
}
