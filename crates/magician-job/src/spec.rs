//! What is to be run, and how.

use magician_program::{Ending, Program};

use crate::SavedSettings;

/// Where a job begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// At this step, counted from 0 over all loops.
    Step(u64),
    /// Where the journal says that the last job of this program ended before its end.
    Resume,
}

/// A job that is to be done.
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
    /// What becomes of pen and arm at the end, at pauses and after a stop.
    pub ending: Ending,
    /// Where it begins.
    pub start: Start,
    /// How far before the place where its light went out a resumed burn begins, along its line, mm.
    pub overlap: f64,
    /// Name of the work, for people: the plan's title at first.
    pub name: String,
    /// Where the program comes from, for people: a file, say.
    pub origin: String,
    /// Runs commands of an earlier program that still wait in the queue, before these.
    pub keep: bool,
    /// Refuses an arm that was not homed since it was switched on, by the check before a motion.
    pub require_homed: bool,
    /// Refuses a program of which the arm cannot do all. On at first.
    pub check: bool,
    /// Whether the arm may pass over indices of its queue, besides what the program and the line say of that: above window 1.
    pub passes_over: bool,
    /// Whether steps that depend on where the arm stood when the program was made count on where it stands now. Such a program
    /// does not begin behind them.
    pub begins_here: bool,
    /// True if the program lies on a surface that was assumed: only a virtual arm has that one.
    pub assumes_surface: bool,
    /// Whether the arm outlives this process: only then the journal is written while the job runs. By itself if not given: yes
    /// of every arm that is no virtual one in this process.
    pub lasting: Option<bool>,
    /// What restores the settings that it changes; `None`: nothing.
    pub saved: Option<SavedSettings>,
}

impl JobSpec {
    /// The program from its first step, with the pen lifted at the end, and what it changes restored.
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
            passes_over: false,
            begins_here: false,
            assumes_surface: false,
            lasting: None,
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

    /// Sets [`passes_over`](Self::passes_over).
    #[must_use]
    pub fn passes_over(mut self, passes_over: bool) -> Self {
        self.passes_over = passes_over;
        self
    }

    /// Sets [`begins_here`](Self::begins_here).
    #[must_use]
    pub fn begins_here(mut self, begins_here: bool) -> Self {
        self.begins_here = begins_here;
        self
    }

    /// Sets [`assumes_surface`](Self::assumes_surface).
    #[must_use]
    pub fn assumes_surface(mut self, assumes_surface: bool) -> Self {
        self.assumes_surface = assumes_surface;
        self
    }

    /// Sets [`lasting`](Self::lasting).
    #[must_use]
    pub fn lasting(mut self, lasting: bool) -> Self {
        self.lasting = Some(lasting);
        self
    }

    /// Sets [`saved`](Self::saved): settings that others have saved are restored with those of the job.
    #[must_use]
    pub fn saved(mut self, saved: impl Into<Option<SavedSettings>>) -> Self {
        self.saved = saved.into();
        self
    }
}
