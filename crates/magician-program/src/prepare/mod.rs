//! Preparation: from the bytes of a file to a program for an arm. Every front end uses this route.
//!
//! [`PrepareRequest::open`] reads the file, [`OpenedFile::prepare`] places its content and builds
//! the program. The two are separate because G-code may depend on the position of the tool:
//! preparing then returns [`Preparation::NeedsStart`], and the caller reads the pose from the arm
//! and prepares again.

mod opened;

use std::sync::Arc;

use magician_host::message;
use magician_host::{JointAngles, Setting, SettingValue};
use magician_motion::Fence;

pub use opened::OpenedFile;

use crate::{
    AppliedPlacement, Diagnostic, DiagnosticCode, Ending, Format, Origin, PartSummary, Program,
    Setup, SetupDefaults, SetupOptions, Surface, Tool, Work, WouldFit,
};

/// Request to turn a file into a program for an arm, with everything the program depends on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareRequest {
    /// Format of the file.
    pub format: Format,
    /// Title of the program, unless the file names one.
    pub title: String,
    /// Content of the file.
    pub bytes: Arc<[u8]>,
    /// Options for drawing, engraving or running the file.
    pub options: SetupOptions,
    /// Slope of the surface whose height the options give, mm per mm along x and y.
    pub surface_slope: [f64; 2],
    /// Note about the preset from which the options come; shown before the notes on the file.
    pub preset_note: Option<Diagnostic>,
    /// Pause at the end of each iteration, ms.
    pub rest: u32,
    /// Defaults for omitted options.
    pub defaults: SetupDefaults,
    /// Fence of the arm.
    pub fence: Option<Fence>,
    /// Tool set on the arm, if known. Only [some options](SetupOptions::needs_tool_in_force) depend
    /// on it.
    pub tool: Option<Tool>,
    /// Start position for a program that depends on it, unless the options give one.
    pub start: StartPosition,
}

/// Start position of a program that depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum StartPosition {
    /// Return [`Preparation::NeedsStart`] if the program depends on it.
    #[default]
    Unread,
    /// Position of the tool's tip, mm.
    At([f64; 3]),
    /// Unknown. No pose can be read from the arm either.
    Unknown,
    /// The position of a virtual arm that is set up for the program.
    Staged,
}

/// Result of preparing a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Preparation {
    /// The program.
    Done(Box<PreparedProgram>),
    /// The program depends on its start: prepare again with a start position.
    NeedsStart,
}

/// Program for an arm, with everything a front end shows of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PreparedProgram {
    /// The program, set to run once.
    pub program: Program,
    /// Format of the file.
    pub format: Format,
    /// Placement, tool, surface and speeds used.
    pub setup: Setup,
    /// Treatment of pen and arm at the end.
    pub ending: Ending,
    /// Tool position at the start, mm, if the program depends on it and the options did not give
    /// it.
    pub start: Option<[f64; 3]>,
    /// Joint angles of the virtual arm at `start`, if it is [staged](StartPosition::Staged).
    pub staged_joints: Option<JointAngles>,
    /// Notes on assumptions and on omitted content.
    pub notes: Vec<Diagnostic>,
    /// Size, rotation and position. `None` if the coordinates are the arm's.
    pub placed: Option<AppliedPlacement>,
    /// Reason why the program does not fit at its place. `None` if it fits.
    pub misfit: Option<Diagnostic>,
    /// Size and rotation in which the program would fit.
    pub would_fit: Option<WouldFit>,
    /// Parts as in the file, without times: layers, unless the options choose others.
    pub parts: Vec<PartSummary>,
}

/// Stage at which a file failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PrepareStage {
    /// Reading: the file is wrong or empty.
    Read,
    /// Placing: the options cannot be met, or not by this arm.
    Place,
}

/// Error of preparing a file, with the notes so far.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrepareError {
    /// Stage at which preparation failed.
    pub stage: PrepareStage,
    /// Problem with the file or the options.
    pub problem: Box<Diagnostic>,
    /// Notes so far.
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
    /// Assumes the table of a virtual arm if no surface is known.
    #[must_use]
    pub fn on_virtual_arm(mut self) -> Self {
        self.assumed_surface = Some(Surface::VIRTUAL);
        self
    }

    /// Leaves the laser power to the later run of a converted file, and assumes the table of a
    /// virtual arm.
    #[must_use]
    pub fn for_conversion(mut self) -> Self {
        self.engrave_power = None;
        self.on_virtual_arm()
    }
}

impl PrepareRequest {
    /// Creates a request for a file that is run as it is.
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

    /// Reads the file as far as possible without a start position, so that its mistakes are
    /// reported before the arm is asked for anything.
    ///
    /// # Errors
    /// [`PrepareError`] with the mistake in the file.
    pub fn open(self) -> Result<OpenedFile, PrepareError> {
        OpenedFile::of(self)
    }

    /// Reads the file and prepares its program.
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
    /// [`PrepareError`] with the mistake in the file, or the option that cannot be met.
    pub fn prepare(&self) -> Result<Preparation, PrepareError> {
        self.clone().open()?.prepare()
    }

    /// Returns the options with the work that a frame traces filled in, and the notes that come
    /// first.
    fn effective_options(&self) -> (SetupOptions, Vec<Diagnostic>) {
        let mut options = self.options.clone();
        let framed = options.frame_for(&self.defaults, self.tool);
        let notes = framed.into_iter().chain(self.preset_note.clone());
        (options, notes.collect())
    }

    /// Returns the setup that follows from the options and this arm.
    fn setup_of(&self, options: &SetupOptions) -> Setup {
        let mut setup = options.setup(&self.defaults);
        if let Some(surface) = &mut setup.surface {
            surface.slope = self.surface_slope;
        }
        setup.fence = self.fence;
        setup
    }

    /// Returns the treatment of pen and arm at the end. After a drawing, an image or G-code the
    /// tool is above the work.
    fn ending_of(&self, options: &SetupOptions, setup: &Setup) -> Ending {
        let marks = setup.work != Work::Default || setup.framing.is_some();
        options.ending(&self.defaults, marks || self.format.is_drawing())
    }

    /// Returns what is known without reading the file.
    pub(crate) fn setup_and_ending(&self) -> (Setup, Ending) {
        let (options, _) = self.effective_options();
        let setup = self.setup_of(&options);
        let ending = self.ending_of(&options, &setup);
        (setup, ending)
    }
}

impl PreparedProgram {
    /// Returns the program if it fits at its place.
    ///
    /// # Errors
    /// [`PrepareError`] with the reason if it does not fit.
    pub fn fitting(mut self) -> Result<Self, PrepareError> {
        match self.misfit.take() {
            Some(misfit) => Err(PrepareError::new(PrepareStage::Place, misfit, self.notes)),
            None => Ok(self),
        }
    }

    /// Sets the number of iterations; endless if `None`.
    #[must_use]
    pub fn repeated(mut self, iterations: Option<u64>) -> Self {
        self.program = self.program.repeated(iterations);
        self
    }

    /// True if the program cannot begin at step `from`, or be resumed, because it depends on the
    /// tool position at its start and the tool has moved since then.
    #[must_use]
    pub fn has_lost_start(&self, from: u64, resumes: bool) -> bool {
        let depends =
            self.program.depends_on_start(from) || resumes && self.program.depends_throughout();
        self.start.is_some() && depends
    }

    /// True if the coordinates of the file are used as arm coordinates.
    #[must_use]
    pub fn is_raw(&self) -> bool {
        self.placed.is_none() && self.misfit.is_none()
    }
}

/// Note that the program begins at the tool's position.
fn start_note([x, y, z]: [f64; 3]) -> Diagnostic {
    let what = message!(
        "it begins at the tool's position, {x:.3},{y:.3},{z:.3}",
        x,
        y,
        z
    );
    let again = (Setting::Start, SettingValue::Position([x, y, z]));
    Diagnostic::new(Origin::NONE, what)
        .coded(DiagnosticCode::Assumed)
        .remedy(again, "begins there again from any position")
}
