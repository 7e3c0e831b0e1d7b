//! How far a job is, and what of that is kept outside of the process.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::Pose;
use magician_program::resume::{Checkpoint, ResumePoint, StepCounter, StepRange};
use magician_program::{BurnPlace, RemainingProgram};
use tokio::time::Instant;

use crate::error::Left;
use crate::event::JobEvent;
use crate::handle::Shared;
use crate::journal::{Journal, JournalKey};
use crate::spec::JobSpec;

/// Between two writes that only say how far it is.
const PAUSE: Duration = Duration::from_millis(100);
/// So many steps are written down before they are given to the arm.
const AHEAD: u64 = 64;

/// What must be known of a job when it is given up in its middle.
pub(super) struct Track {
    pub(super) journal: Box<dyn Journal>,
    pub(super) checkpoint: Checkpoint,
    /// While the job runs its journal is written only for an arm that outlives this process.
    lasting: bool,
    written: Option<Instant>,
    /// Whether what is known has still to be kept.
    pub(super) open: bool,
    pub(super) counter: StepCounter,
    /// Commands taken from the program since it began, or went on.
    pub(super) pulled: u64,
    /// Those of them that are not the program's.
    inserted: u64,
    /// Whether indices may be passed over, or stand for commands that are not the program's, all along.
    passes_over: bool,
    /// What is run.
    pub(super) rest: Option<RemainingProgram>,
    /// How far the pen goes up when the job is stopped now, mm.
    pub(super) lift: Option<f64>,
    /// Where it goes on, once that is known.
    pub(super) left: Option<Left>,
    /// When progress was told last.
    pub(super) told: Option<Instant>,
    /// True if the arm had finished what comes before the first step before anything stopped it. Its index at the stop does not
    /// tell: a command that was cut short may count as finished.
    pub(super) at_first: bool,
    /// Cause why the journal holds nothing of the job, if its last write failed.
    pub(super) unkept: Option<Arc<str>>,
    /// True once that was told: the next failures are not news.
    told_unkept: bool,
    shared: Arc<Shared>,
}

impl Track {
    pub(super) fn new(
        journal: Box<dyn Journal>,
        spec: &JobSpec,
        lasting: bool,
        shared: Arc<Shared>,
    ) -> Self {
        Self {
            journal,
            checkpoint: Checkpoint::new(&spec.program.plan().title, spec.program.steps(), false),
            lasting,
            written: None,
            open: false,
            counter: StepCounter::default(),
            pulled: 0,
            inserted: 0,
            passes_over: false,
            rest: None,
            lift: None,
            left: None,
            told: None,
            at_first: false,
            unkept: None,
            told_unkept: false,
            shared,
        }
    }

    /// The journal is of this arm.
    pub(super) fn is_of(&mut self, key: &JournalKey, passes_over: bool) {
        self.journal.open(key);
        (self.checkpoint.mixed, self.passes_over) = (passes_over, passes_over);
    }

    /// The job begins, or goes on, behind so many steps, at that place within the next if there is one, when the arm's clock
    /// shows this, ms, and its index this, if it is at rest.
    pub(super) fn begins(
        &mut self,
        rest: &RemainingProgram,
        within: Option<[f64; 3]>,
        clock: u32,
        rests_at: Option<u64>,
        passes_over: bool,
    ) {
        let from = rest.from();
        let checkpoint = &mut self.checkpoint;
        (checkpoint.finished, checkpoint.handed) = (from, from);
        (checkpoint.within, checkpoint.twice) = (within.map(|place| (from, place)), 0.0);
        (checkpoint.clock, checkpoint.rest) = (clock, rests_at);
        checkpoint.ended = None;
        self.counter = rest.counter(passes_over).from_rest(rests_at);
        (self.pulled, self.inserted, self.open) = (0, 0, true);
        self.at_first = false;
        self.checkpoint.mixed = passes_over;
        self.checkpoint.index = self
            .counter
            .last()
            .map(|(index, steps)| (index, from + steps));
        self.rest = Some(rest.clone());
    }

    /// The first step, over all iterations.
    pub(super) fn from(&self) -> u64 {
        self.rest.as_ref().map_or(0, RemainingProgram::from)
    }

    /// Steps that have been given to the arm, at most.
    pub(super) fn handed(&self) -> u64 {
        let steps = self.from() + self.steps_of(self.pulled);
        steps.min(self.checkpoint.steps.unwrap_or(u64::MAX))
    }

    /// Steps since it began, or went on, that have been taken from the program.
    pub(super) fn steps_pulled(&self, lead: u64) -> u64 {
        self.steps_of(self.pulled.saturating_sub(self.inserted + lead))
    }

    /// The steps since then of which this is the last of so many commands.
    fn steps_of(&self, commands: u64) -> u64 {
        let rest = self.rest.as_ref();
        rest.map_or(commands, |rest| rest.steps_of(commands))
    }

    /// A command is about to go out that is not the program's. Behind the first step an index may
    /// stand for it until the arm has finished it; ahead of that it only shifts the index.
    pub(super) fn inserts(&mut self, lead: u64) {
        let ahead = self.pulled - self.inserted <= lead;
        self.pulled += 1;
        self.inserted += 1;
        self.counter.insert(self.pulled);
        if ahead {
            let from = self.from();
            let index = self.counter.last();
            self.checkpoint.index = index.map(|(index, steps)| (index, from + steps));
            self.write_if_lasting();
        } else if !self.checkpoint.mixed {
            self.checkpoint.mixed = true;
            self.write_if_lasting();
        }
    }

    /// The next command is about to go out.
    pub(super) fn pulls(&mut self, lead: u64) {
        // What an earlier run has left ends before the first command of this one goes out.
        let first = self.pulled == 0;
        self.pulled += 1;
        let steps = self.from() + self.steps_pulled(lead);
        if steps > self.checkpoint.handed {
            let most = self.checkpoint.steps.unwrap_or(u64::MAX);
            self.checkpoint.handed = steps.saturating_add(AHEAD).min(most);
            self.write_if_lasting();
        } else if first {
            self.write_if_lasting();
        }
    }

    /// How far it is.
    pub(super) fn reached(
        &mut self,
        finished: u64,
        index: Option<(u64, u64)>,
        clock: u32,
        current: u64,
    ) {
        if self.checkpoint.mixed && !self.passes_over {
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
            .is_none_or(|written| written.elapsed() >= PAUSE)
        {
            self.write_if_lasting();
        }
    }

    /// It is over, or paused, before its end; where it goes on, at that place within the next step if there is one.
    pub(super) fn ends(&mut self, resume_point: ResumePoint, within: Option<(u64, [f64; 3])>) {
        self.checkpoint.handed = self.handed();
        self.checkpoint.within = within;
        self.checkpoint = std::mem::take(&mut self.checkpoint).ended(resume_point);
        self.left = Some(Left::Known {
            resume_point,
            within: within.is_some(),
            burnt_twice: self.checkpoint.twice,
        });
        self.close();
    }

    /// As [`ends`](Self::ends), for an arm that was stopped at this pose. What `burns` goes on a braking way before it: where its
    /// light went out is not known.
    pub(super) fn ends_at(
        &mut self,
        resume_point: ResumePoint,
        within: Option<(u64, [f64; 3])>,
        (burns, pose): (bool, &Pose),
    ) {
        let rest = self.rest.as_ref().filter(|_| burns);
        match rest.and_then(|rest| rest.before_braking(resume_point, within, pose)) {
            Some(place) => self.ends_burning(place),
            None => self.ends(resume_point, within),
        }
    }

    /// It is over before its end, and what burns goes on there.
    pub(super) fn ends_burning(&mut self, place: BurnPlace) {
        let resume_point = match place.within {
            Some(_) => ResumePoint::Again(place.steps),
            None => ResumePoint::After(place.steps),
        };
        self.checkpoint.twice = place.twice;
        self.ends(resume_point, place.within.map(|at| (place.steps, at)));
    }

    /// It is over, and how far it came is not known yet.
    pub(super) fn breaks_off(&mut self) {
        self.checkpoint.handed = self.handed();
        self.left = Some(Left::NotAsked);
        self.close();
    }

    /// It is over, and the arm has forgotten what it did.
    pub(super) fn is_forgotten(&mut self) {
        self.checkpoint.handed = self.handed();
        let span = StepRange {
            least: self.checkpoint.finished,
            most: self.checkpoint.handed,
        };
        self.checkpoint = std::mem::take(&mut self.checkpoint).ended(ResumePoint::Doubt(span));
        self.left = Some(Left::Forgotten(span));
        self.close();
    }

    /// It has come to its end.
    pub(super) fn remove(&mut self) {
        self.open = false;
        self.left = None;
        self.journal.remove();
    }

    fn close(&mut self) {
        self.open = false;
        self.write();
    }

    fn write_if_lasting(&mut self) {
        if self.lasting {
            self.write();
        }
    }

    fn write(&mut self) {
        self.written = Some(Instant::now());
        let failed = self.journal.write(&self.checkpoint).err();
        self.unkept = failed.map(|error| error.to_string().into());
        if let Some(cause) = &self.unkept
            && !std::mem::replace(&mut self.told_unkept, true)
        {
            self.shared.tell(JobEvent::Unkept(Arc::clone(cause)));
        }
    }
}
