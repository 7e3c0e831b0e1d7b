//! Progress of a job, and the checkpoint that outlives the process.
//!
//! [`ProgressTracker`] counts the commands taken from the program, maps the arm's index to finished
//! steps, and writes a [`Checkpoint`] to the journal. The write comes before the commands go out,
//! [`STEPS_RECORDED_AHEAD`] steps at a time, so a checkpoint never claims less than the arm may
//! have received.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::Pose;
use magician_program::resume::{Checkpoint, ResumePoint, StepCounter, StepRange};
use magician_program::{BurnPlace, RemainingProgram};
use tokio::time::Instant;

use crate::error::ResumePlace;
use crate::event::JobEvent;
use crate::handle::Shared;
use crate::journal::{Journal, JournalKey};
use crate::spec::JobSpec;

/// Shortest interval between two writes that only record progress.
const WRITE_INTERVAL: Duration = Duration::from_millis(100);
/// Steps recorded as handed over ahead of time, so that the journal is not written for every
/// command.
const STEPS_RECORDED_AHEAD: u64 = 64;

/// State needed to resume a job that ends early.
pub(super) struct ProgressTracker {
    pub(super) journal: Box<dyn Journal>,
    pub(super) checkpoint: Checkpoint,
    /// True if the arm outlives this process: only then is the journal written while the job runs.
    outlives_process: bool,
    written: Option<Instant>,
    /// True while the checkpoint still has to be written at the end.
    pub(super) open: bool,
    pub(super) counter: StepCounter,
    /// Commands taken from the program since the job started or resumed, inserted ones included.
    pub(super) pulled: u64,
    /// Number of inserted commands in `pulled`, which change the speed of the job.
    inserted: u64,
    /// True if the arm's index may skip numbers or count foreign commands at any time.
    index_may_skip: bool,
    /// The rest of the program that runs.
    pub(super) remaining: Option<RemainingProgram>,
    /// Height by which the pen is lifted if the job is stopped now, mm.
    pub(super) lift: Option<f64>,
    /// Place to resume at, once known.
    pub(super) resume_place: Option<ResumePlace>,
    /// Time of the last progress event.
    pub(super) last_report: Option<Instant>,
    /// True once the arm has certainly finished the commands before the first step. Not derived
    /// from the index at a stop, because a command that was cut short may count as finished there.
    pub(super) at_first: bool,
    /// Error of the last write to the journal, if it failed: the progress is not stored then.
    pub(super) storage_error: Option<Arc<str>>,
    /// True once a failed write was reported: later failures are not reported again.
    storage_error_reported: bool,
    shared: Arc<Shared>,
}

impl ProgressTracker {
    pub(super) fn new(
        journal: Box<dyn Journal>,
        spec: &JobSpec,
        outlives_process: bool,
        shared: Arc<Shared>,
    ) -> Self {
        Self {
            journal,
            checkpoint: Checkpoint::new(&spec.program.plan().title, spec.program.steps(), false),
            outlives_process,
            written: None,
            open: false,
            counter: StepCounter::default(),
            pulled: 0,
            inserted: 0,
            index_may_skip: false,
            remaining: None,
            lift: None,
            resume_place: None,
            last_report: None,
            at_first: false,
            storage_error: None,
            storage_error_reported: false,
            shared,
        }
    }

    /// Opens the journal for this program and arm.
    pub(super) fn open_journal(&mut self, key: &JournalKey, index_may_skip: bool) {
        self.journal.open(key);
        (self.checkpoint.mixed, self.index_may_skip) = (index_may_skip, index_may_skip);
    }

    /// Starts or resumes the job after the steps of `rest`, at position `within` of the next step
    /// if given. `clock` is the arm's clock, ms; `rest_index` its index if it is at rest.
    pub(super) fn begin(
        &mut self,
        rest: &RemainingProgram,
        within: Option<[f64; 3]>,
        clock: u32,
        rest_index: Option<u64>,
        index_may_skip: bool,
    ) {
        let from = rest.from();
        let checkpoint = &mut self.checkpoint;
        (checkpoint.finished, checkpoint.handed) = (from, from);
        (checkpoint.within, checkpoint.twice) = (within.map(|place| (from, place)), 0.0);
        (checkpoint.clock, checkpoint.rest) = (clock, rest_index);
        checkpoint.ended = None;
        self.counter = rest.counter(index_may_skip).from_rest(rest_index);
        (self.pulled, self.inserted, self.open) = (0, 0, true);
        self.at_first = false;
        self.checkpoint.mixed = index_may_skip;
        self.checkpoint.index = self
            .counter
            .last()
            .map(|(index, steps)| (index, from + steps));
        self.remaining = Some(rest.clone());
    }

    /// First step of the segment, counted over all iterations.
    pub(super) fn from(&self) -> u64 {
        self.remaining.as_ref().map_or(0, RemainingProgram::from)
    }

    /// Upper bound of the steps handed over to the arm.
    pub(super) fn handed(&self) -> u64 {
        let steps = self.from() + self.steps_of(self.pulled);
        steps.min(self.checkpoint.steps.unwrap_or(u64::MAX))
    }

    /// Steps taken from the program since the job started or resumed. `lead` is the number of
    /// commands before the first step.
    pub(super) fn steps_pulled(&self, lead: u64) -> u64 {
        self.steps_of(self.pulled.saturating_sub(self.inserted + lead))
    }

    /// Number of the step to which the last of `commands` belongs.
    fn steps_of(&self, commands: u64) -> u64 {
        let rest = self.remaining.as_ref();
        rest.map_or(commands, |rest| rest.steps_of(commands))
    }

    /// Counts an inserted command that is about to go out. Until the arm has finished the command,
    /// the arm's index may refer to it instead of to a step. A command before the first step only
    /// shifts the index.
    pub(super) fn note_inserted(&mut self, lead: u64) {
        let ahead = self.pulled - self.inserted <= lead;
        self.pulled += 1;
        self.inserted += 1;
        self.counter.insert(self.pulled);
        if ahead {
            let from = self.from();
            let index = self.counter.last();
            self.checkpoint.index = index.map(|(index, steps)| (index, from + steps));
            self.write_if_arm_outlives_process();
        } else if !self.checkpoint.mixed {
            self.checkpoint.mixed = true;
            self.write_if_arm_outlives_process();
        }
    }

    /// Counts the next command of the program, which is about to go out.
    pub(super) fn note_pulled(&mut self, lead: u64) {
        // The first write happens with the first command even if no new step begins: the checkpoint
        // must replace that of the earlier run.
        let first = self.pulled == 0;
        self.pulled += 1;
        let steps = self.from() + self.steps_pulled(lead);
        if steps > self.checkpoint.handed {
            let most = self.checkpoint.steps.unwrap_or(u64::MAX);
            // Written before the command goes out: after a crash this is an upper bound.
            self.checkpoint.handed = steps.saturating_add(STEPS_RECORDED_AHEAD).min(most);
            self.write_if_arm_outlives_process();
        } else if first {
            self.write_if_arm_outlives_process();
        }
    }

    /// Records the progress and writes it, at most every [`WRITE_INTERVAL`].
    pub(super) fn note_progress(
        &mut self,
        finished: u64,
        index: Option<(u64, u64)>,
        clock: u32,
        current: u64,
    ) {
        if self.checkpoint.mixed && !self.index_may_skip {
            self.checkpoint.mixed = !self.counter.has_passed_inserted(current);
        }
        self.at_first |= self.counter.is_at_first(current);
        let checkpoint = &mut self.checkpoint;
        checkpoint.clock = clock;
        if checkpoint.finished == finished && checkpoint.index == index {
            return;
        }
        (checkpoint.finished, checkpoint.index) = (finished, index);
        if self
            .written
            .is_none_or(|written| written.elapsed() >= WRITE_INTERVAL)
        {
            self.write_if_arm_outlives_process();
        }
    }

    /// Records that the job ended early or is paused, and where it resumes.
    pub(super) fn record_end(
        &mut self,
        resume_point: ResumePoint,
        within: Option<(u64, [f64; 3])>,
    ) {
        self.checkpoint.handed = self.handed();
        self.checkpoint.within = within;
        self.checkpoint = std::mem::take(&mut self.checkpoint).ended(resume_point);
        self.resume_place = Some(ResumePlace::Known {
            resume_point,
            within: within.is_some(),
            burnt_twice: self.checkpoint.twice,
        });
        self.close();
    }

    /// Like [`record_end`](Self::record_end), for an arm that was stopped at `pose`. A burn resumes
    /// one braking distance before `pose`, because the place where the laser went out is unknown.
    pub(super) fn record_end_at(
        &mut self,
        resume_point: ResumePoint,
        within: Option<(u64, [f64; 3])>,
        (burns, pose): (bool, &Pose),
    ) {
        let rest = self.remaining.as_ref().filter(|_| burns);
        match rest.and_then(|rest| rest.before_braking(resume_point, within, pose)) {
            Some(place) => self.record_burn_end(place),
            None => self.record_end(resume_point, within),
        }
    }

    /// Records an early end of a burn that resumes at `place`.
    pub(super) fn record_burn_end(&mut self, place: BurnPlace) {
        let resume_point = match place.within {
            Some(_) => ResumePoint::Again(place.steps),
            None => ResumePoint::After(place.steps),
        };
        self.checkpoint.twice = place.twice;
        self.record_end(resume_point, place.within.map(|at| (place.steps, at)));
    }

    /// Records an early end whose progress is unknown.
    pub(super) fn record_unknown_end(&mut self) {
        self.checkpoint.handed = self.handed();
        self.resume_place = Some(ResumePlace::NotRead);
        self.close();
    }

    /// Records an early end after a reset: the arm no longer knows what it did.
    pub(super) fn record_reset(&mut self) {
        self.checkpoint.handed = self.handed();
        let span = StepRange {
            least: self.checkpoint.finished,
            most: self.checkpoint.handed,
        };
        self.checkpoint = std::mem::take(&mut self.checkpoint).ended(ResumePoint::Doubt(span));
        self.resume_place = Some(ResumePlace::Forgotten(span));
        self.close();
    }

    /// Removes the journal of a finished job.
    pub(super) fn remove(&mut self) {
        self.open = false;
        self.resume_place = None;
        self.journal.remove();
    }

    fn close(&mut self) {
        self.open = false;
        self.write();
    }

    fn write_if_arm_outlives_process(&mut self) {
        if self.outlives_process {
            self.write();
        }
    }

    fn write(&mut self) {
        self.written = Some(Instant::now());
        let failed = self.journal.write(&self.checkpoint).err();
        self.storage_error = failed.map(|error| error.to_string().into());
        if let Some(cause) = &self.storage_error
            && !std::mem::replace(&mut self.storage_error_reported, true)
        {
            self.shared.emit(JobEvent::NotStored(Arc::clone(cause)));
        }
    }
}
