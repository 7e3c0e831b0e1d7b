//! Specification of a job: program, start, ending and checks.

use magician_program::{Ending, Program};

use crate::SavedSettings;

/// Step at which a job begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// This step, counted from 0 over all loops.
    Step(u64),
    /// The place where the last job of this program ended, from the journal.
    Resume,
}

/// Specification of a job.
///
/// ```
/// use magician_job::{JobSpec, Start};
/// use magician_program::{Action, Origin, Plan, Program};
///
/// let mut plan = Plan::new("a rest");
/// plan.push(Action::Wait(500), Origin::NONE);
/// let spec = JobSpec::new(Program::new(plan, Some(2))).start(Start::Step(1)).require_homed(true);
/// assert_eq!(spec.name, "a rest");
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct JobSpec {
    /// The program.
    pub program: Program,
    /// Position of pen and arm at the end, at pauses and after a stop.
    pub ending: Ending,
    /// Step to begin at.
    pub start: Start,
    /// Overlap of a resumed burn, mm: it begins this far before the place where the laser went out.
    pub overlap: f64,
    /// Name of the work, for people. Defaults to the plan's title.
    pub name: String,
    /// Origin of the program, for people: a file, for example.
    pub origin: String,
    /// Lets commands of an earlier program that still wait in the queue run first.
    pub keep: bool,
    /// Refuses an arm that was not homed since it was switched on, by the check before a motion.
    pub require_homed: bool,
    /// Refuses a program that the arm cannot run completely. On by default.
    pub check: bool,
    /// True if the arm's index may skip numbers for a reason not visible in the program and the
    /// line: a window above 1.
    pub index_may_skip: bool,
    /// True if steps depend on the pose at which the program was made, and count on the current
    /// one. Such a program cannot begin after those steps.
    pub depends_on_pose: bool,
    /// True if the surface of the program is an assumption: only valid on a virtual arm.
    pub assumes_surface: bool,
    /// True if the arm outlives this process: only then is the journal written while the job runs.
    /// `None` decides by the arm: true unless it is virtual and in this process.
    pub outlives_process: Option<bool>,
    /// Storage for the settings that the job changes and restores; `None` restores nothing.
    pub saved: Option<SavedSettings>,
}

impl JobSpec {
    /// Specification with the defaults: from the first step, pen lifted at the end, settings
    /// restored.
    #[must_use]
    pub fn new(program: Program) -> Self {
        Self {
            name: program.plan().title.clone(),
            program,
            ending: Ending::default(),
            start: Start::Step(0),
            overlap: 0.0,
            origin: String::new(),
            keep: false,
            require_homed: false,
            check: true,
            index_may_skip: false,
            depends_on_pose: false,
            assumes_surface: false,
            outlives_process: None,
            saved: Some(SavedSettings::default()),
        }
    }

    /// Sets [`ending`](Self::ending).
    #[must_use]
    pub fn ending(mut self, ending: Ending) -> Self {
        self.ending = ending;
        self
    }

    /// Sets [`start`](Self::start).
    #[must_use]
    pub fn start(mut self, start: Start) -> Self {
        self.start = start;
        self
    }

    /// Sets [`overlap`](Self::overlap).
    #[must_use]
    pub fn overlap(mut self, mm: f64) -> Self {
        self.overlap = mm;
        self
    }

    /// Sets [`origin`](Self::origin).
    #[must_use]
    pub fn origin(mut self, origin: impl Into<String>) -> Self {
        self.origin = origin.into();
        self
    }

    /// Sets [`keep`](Self::keep).
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.keep = keep;
        self
    }

    /// Sets [`require_homed`](Self::require_homed).
    #[must_use]
    pub fn require_homed(mut self, require: bool) -> Self {
        self.require_homed = require;
        self
    }

    /// Sets [`check`](Self::check).
    #[must_use]
    pub fn check(mut self, check: bool) -> Self {
        self.check = check;
        self
    }

    /// Sets [`index_may_skip`](Self::index_may_skip).
    #[must_use]
    pub fn index_may_skip(mut self, index_may_skip: bool) -> Self {
        self.index_may_skip = index_may_skip;
        self
    }

    /// Sets [`depends_on_pose`](Self::depends_on_pose).
    #[must_use]
    pub fn depends_on_pose(mut self, depends_on_pose: bool) -> Self {
        self.depends_on_pose = depends_on_pose;
        self
    }

    /// Sets [`assumes_surface`](Self::assumes_surface).
    #[must_use]
    pub fn assumes_surface(mut self, assumes_surface: bool) -> Self {
        self.assumes_surface = assumes_surface;
        self
    }

    /// Sets [`outlives_process`](Self::outlives_process).
    #[must_use]
    pub fn outlives_process(mut self, outlives_process: bool) -> Self {
        self.outlives_process = Some(outlives_process);
        self
    }

    /// Sets [`saved`](Self::saved). Settings saved there by others are restored with those of the
    /// job.
    #[must_use]
    pub fn saved(mut self, saved: impl Into<Option<SavedSettings>>) -> Self {
        self.saved = saved.into();
        self
    }
}
