//! From the bytes of a file to a program before an arm: the one way that every door goes.

mod opened;

use std::sync::Arc;

use magician_host::message;
use magician_host::{Given, JointAngles, Setting};
use magician_motion::Fence;

pub use opened::OpenedFile;

use crate::{
    AppliedPlacement, Diagnostic, DiagnosticCode, Ending, Format, Origin, PartSummary, Program,
    Setup, SetupDefaults, SetupOptions, Surface, Tool, Work, WouldFit,
};

/// A file that is to become a program before an arm, and all that the program depends on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareRequest {
    /// Format of the file.
    pub format: Format,
    /// Title of the program, unless the file names one.
    pub title: String,
    /// Content of the file.
    pub bytes: Arc<[u8]>,
    /// Options of drawing, engraving or running it.
    pub options: SetupOptions,
    /// Slope of the surface whose height the options give, mm for each mm along x and y.
    pub surface_slope: [f64; 2],
    /// Note of the preset that the options come from; told before what the file has to say.
    pub preset_note: Option<Diagnostic>,
    /// Rest at the end of each iteration, ms.
    pub rest: u32,
    /// Values for what the options leave open.
    pub defaults: SetupDefaults,
    /// Fence of the arm.
    pub fence: Option<Fence>,
    /// Tool in force on the arm, if it was asked for, which only [some options](SetupOptions::needs_tool_in_force) depend on.
    pub tool: Option<Tool>,
    /// Start of a program that depends on it, unless the options give one.
    pub start: StartPosition,
}

/// Start of a program that depends on where the tool is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum StartPosition {
    /// The caller wants to be asked, if the program depends on it.
    #[default]
    Ask,
    /// Position of the tool's tip, mm.
    At([f64; 3]),
    /// Unknown: the arm does not know it either.
    Unknown,
    /// Position of a virtual arm that is made ready for the program.
    Staged,
}

/// Outcome of preparing a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Preparation {
    /// A program.
    Done(Box<PreparedProgram>),
    /// The program depends on where it begins: it has to be prepared again with that.
    NeedsStart,
}

/// A program before an arm, and what every door shows of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PreparedProgram {
    /// The program, to be run once.
    pub program: Program,
    /// Format of its file.
    pub format: Format,
    /// Placement, tool, surface and speeds in force for it.
    pub setup: Setup,
    /// Treatment of pen and arm at its end.
    pub ending: Ending,
    /// Position of the tool at its beginning, mm, if it depends on that and the options did not say it.
    pub start: Option<[f64; 3]>,
    /// Joint angles of the virtual arm whose position that is, if it is [staged](StartPosition::Staged).
    pub stands: Option<JointAngles>,
    /// Notes on ambiguous input and on what was left out.
    pub notes: Vec<Diagnostic>,
    /// Size, turn and position. `None` if its coordinates are the arm's.
    pub placed: Option<AppliedPlacement>,
    /// Reason why it does not fit there, if it does not.
    pub misfit: Option<Diagnostic>,
    /// Size in which it would fit.
    pub would_fit: Option<WouldFit>,
    /// Parts as they are in the file, without their times: layers, unless the options say otherwise.
    pub parts: Vec<PartSummary>,
}

/// Stage at which a file failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PrepareStage {
    /// Reading: something is wrong with the file itself, or nothing is in it.
    Read,
    /// Placing: it cannot be done as the options say, or not before this arm.
    Place,
}

/// Error of a file that became no program, with the notes before it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareError {
    /// Stage at which it failed.
    pub stage: PrepareStage,
    /// Problem with the file, or with what the options ask for.
    pub problem: Box<Diagnostic>,
    /// Notes up to there.
    pub notes: Vec<Diagnostic>,
}

impl PrepareError {
    pub(crate) fn new(stage: PrepareStage, problem: Diagnostic, notes: Vec<Diagnostic>) -> Self {
        Self {
            stage,
            problem: Box::new(problem),
            notes,
        }
    }
}

impl From<PrepareError> for Diagnostic {
    fn from(error: PrepareError) -> Self {
        *error.problem
    }
}

impl std::fmt::Display for PrepareError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.problem.fmt(f)
    }
}

impl std::error::Error for PrepareError {}

impl SetupDefaults {
    /// Assumes the table of a virtual arm where no surface is known.
    #[must_use]
    pub fn on_virtual_arm(mut self) -> Self {
        self.assumed_surface = Some(Surface::VIRTUAL);
        self
    }

    /// Leaves the power to the run of a converted file, and assumes the table of a virtual arm.
    #[must_use]
    pub fn for_conversion(mut self) -> Self {
        self.engrave_power = None;
        self.on_virtual_arm()
    }
}

impl PrepareRequest {
    /// A request for a file that is run as it is.
    #[must_use]
    pub fn new(format: Format, bytes: &[u8]) -> Self {
        Self {
            format,
            title: String::new(),
            bytes: bytes.into(),
            options: SetupOptions::by_file(),
            surface_slope: [0.0; 2],
            preset_note: None,
            rest: 0,
            defaults: SetupDefaults::default(),
            fence: None,
            tool: None,
            start: StartPosition::default(),
        }
    }

    /// Reads the file as far as that does not depend on where the program begins, so that what is wrong with it is told before an
    /// arm is asked for anything.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn open(self) -> Result<OpenedFile, PrepareError> {
        OpenedFile::of(self)
    }

    /// Reads the file, and prepares its program.
    ///
    /// ```
    /// use magician_program::{Format, PrepareRequest, Preparation};
    ///
    /// let mut request = PrepareRequest::new(Format::Gcode, b"G90\nG1 X220 Y0 Z20 F600\n");
    /// assert!(matches!(request.prepare()?, Preparation::Done(_)));
    /// request.bytes = (*b"G91\nG1 X5 F600\n").into();
    /// assert_eq!(request.prepare()?, Preparation::NeedsStart);
    /// # Ok::<(), magician_program::PrepareError>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with the file, or cannot be done as the options say.
    pub fn prepare(&self) -> Result<Preparation, PrepareError> {
        self.clone().open()?.prepare()
    }

    /// Returns the options with the decision what a frame goes round, and the notes that come first.
    fn decided(&self) -> (SetupOptions, Vec<Diagnostic>) {
        let mut options = self.options.clone();
        let framed = options.frame_for(&self.defaults, self.tool);
        let notes = framed.into_iter().chain(self.preset_note.clone());
        (options, notes.collect())
    }

    /// Returns the setup that the options come to before this arm.
    fn setup_of(&self, options: &SetupOptions) -> Setup {
        let mut setup = options.setup(&self.defaults);
        if let Some(surface) = &mut setup.surface {
            surface.slope = self.surface_slope;
        }
        setup.fence = self.fence;
        setup
    }

    /// Returns the treatment of pen and arm at the end: a drawing, an image or G-code leaves its tool above the work.
    fn ending_of(&self, options: &SetupOptions, setup: &Setup) -> Ending {
        let marks = setup.work != Work::Default || setup.framing.is_some();
        options.ending(&self.defaults, marks || self.format.is_drawing())
    }

    /// Returns what is known of a program without reading its file.
    pub(crate) fn setup_and_ending(&self) -> (Setup, Ending) {
        let (options, _) = self.decided();
        let setup = self.setup_of(&options);
        let ending = self.ending_of(&options, &setup);
        (setup, ending)
    }
}

impl PreparedProgram {
    /// Returns the program if it fits where it lies.
    ///
    /// # Errors
    /// Why it does not.
    pub fn fitting(mut self) -> Result<Self, PrepareError> {
        match self.misfit.take() {
            Some(misfit) => Err(PrepareError::new(PrepareStage::Place, misfit, self.notes)),
            None => Ok(self),
        }
    }

    /// Sets how often it is run; without end if `None`.
    #[must_use]
    pub fn repeated(mut self, iterations: Option<u64>) -> Self {
        self.program = self.program.repeated(iterations);
        self
    }

    /// True if it cannot begin at step `from`, or be resumed, because it depends on where the tool was when it began: the tool has
    /// moved since.
    #[must_use]
    pub fn has_lost_start(&self, from: u64, resumes: bool) -> bool {
        let depends =
            self.program.depends_on_start(from) || resumes && self.program.depends_throughout();
        self.start.is_some() && depends
    }

    /// True if its coordinates are taken as the arm's.
    #[must_use]
    pub fn is_raw(&self) -> bool {
        self.placed.is_none() && self.misfit.is_none()
    }
}

/// Says that a program begins where the tool is.
fn begins_at([x, y, z]: [f64; 3]) -> Diagnostic {
    let what = message!(
        "it begins at the tool's position, {x:.3},{y:.3},{z:.3}",
        x,
        y,
        z
    );
    let again = (Setting::Start, Given::Position([x, y, z]));
    Diagnostic::new(Origin::NONE, what)
        .coded(DiagnosticCode::Assumed)
        .remedy(again, "begins there again from any position")
}
