//! How far a job is, and what of that is kept outside of the process.

use std::time::Duration;

use magician_program::Rest;
use magician_program::resume::{Mark, Span, Tally, Verdict};
use tokio::time::Instant;

use crate::error::Left;
use crate::journal::{Journal, JournalKey};
use crate::spec::JobSpec;

/// Between two writes that only say how far it is.
const PAUSE: Duration = Duration::from_millis(100);
/// So many steps are written down before they are given to the arm.
const AHEAD: u64 = 64;

/// What must be known of a job when it is given up in its middle.
pub(super) struct Track {
    pub(super) journal: Box<dyn Journal>,
    pub(super) mark: Mark,
    /// While the job runs its journal is written only for an arm that outlives this process.
    lasting: bool,
    written: Option<Instant>,
    /// Whether what is known has still to be kept.
    pub(super) open: bool,
    pub(super) tally: Tally,
    /// Commands taken from the program since it began, or went on.
    pub(super) pulled: u64,
    /// Those of them that are not the program's.
    inserted: u64,
    /// Whether indices may be passed over, or stand for commands that are not the program's, all along.
    passes_over: bool,
    /// What is run.
    pub(super) rest: Option<Rest>,
    /// How far the pen goes up when the job is stopped now, mm.
    pub(super) lift: Option<f64>,
    /// Where it goes on, once that is known.
    pub(super) left: Option<Left>,
    /// When progress was told last.
    pub(super) told: Option<Instant>,
}

impl Track {
    pub(super) fn new(journal: Box<dyn Journal>, spec: &JobSpec, lasting: bool) -> Self {
        Self {
            journal,
            mark: Mark::new(&spec.program.plan().title, spec.program.steps(), false),
            lasting,
            written: None,
            open: false,
            tally: Tally::default(),
            pulled: 0,
            inserted: 0,
            passes_over: false,
            rest: None,
            lift: None,
            left: None,
            told: None,
        }
    }

    /// The journal is of this arm.
    pub(super) fn is_of(&mut self, key: &JournalKey, passes_over: bool) {
        self.journal.open(key);
        (self.mark.mixed, self.passes_over) = (passes_over, passes_over);
    }

    /// The job begins, or goes on, behind so many steps, at that place within the next if there is one, when the arm's clock
    /// shows this, ms, and its index this, if it is at rest.
    pub(super) fn begins(
        &mut self,
        rest: &Rest,
        within: Option<[f64; 3]>,
        clock: u32,
        rests_at: Option<u64>,
        passes_over: bool,
    ) {
        let from = rest.from();
        let mark = &mut self.mark;
        (mark.finished, mark.handed) = (from, from);
        mark.within = within.map(|place| (from, place));
        (mark.clock, mark.rest) = (clock, rests_at);
        (mark.index, mark.ended) = (None, None);
        self.tally = Tally::new(rest.lead(), passes_over).from_rest(rests_at);
        (self.pulled, self.inserted, self.open) = (0, 0, true);
        self.mark.mixed = passes_over;
        self.rest = Some(rest.clone());
    }

    /// The first step, over all rounds.
    pub(super) fn from(&self) -> u64 {
        self.rest.as_ref().map_or(0, Rest::from)
    }

    /// Steps that have been given to the arm, at most.
    pub(super) fn handed(&self) -> u64 {
        let steps = self.from() + self.pulled;
        steps.min(self.mark.steps.unwrap_or(u64::MAX))
    }

    /// Steps since it began, or went on, that have been taken from the program.
    pub(super) fn steps_pulled(&self, lead: u64) -> u64 {
        self.pulled.saturating_sub(self.inserted + lead)
    }

    /// A command is about to go out that is not the program's. While the arm has not finished it an index may stand for it.
    pub(super) fn inserts(&mut self) {
        self.pulled += 1;
        self.inserted += 1;
        self.tally.insert(self.pulled);
        if !self.mark.mixed {
            self.mark.mixed = true;
            self.write_if_lasting();
        }
    }

    /// The next command is about to go out.
    pub(super) fn pulls(&mut self, lead: u64) {
        self.pulled += 1;
        let steps = self.from() + self.steps_pulled(lead);
        if steps > self.mark.handed {
            let most = self.mark.steps.unwrap_or(u64::MAX);
            self.mark.handed = steps.saturating_add(AHEAD).min(most);
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
        if self.mark.mixed && !self.passes_over {
            self.mark.mixed = !self.tally.has_passed_inserted(current);
        }
        let mark = &mut self.mark;
        mark.clock = clock;
        if mark.finished == finished && mark.index == index {
            return;
        }
        (mark.finished, mark.index) = (finished, index);
        if self
            .written
            .is_none_or(|written| written.elapsed() >= PAUSE)
        {
            self.write_if_lasting();
        }
    }

    /// It is over, or paused, before its end; where it goes on, at that place within the next step if there is one.
    pub(super) fn ends(&mut self, verdict: Verdict, within: Option<(u64, [f64; 3])>) {
        self.mark.handed = self.handed();
        self.mark.within = within;
        self.mark = std::mem::take(&mut self.mark).ended(verdict);
        self.left = Some(Left::Known {
            verdict,
            within: within.is_some(),
        });
        self.close();
    }

    /// It is over, and how far it came is not known yet.
    pub(super) fn breaks_off(&mut self) {
        self.mark.handed = self.handed();
        self.left = Some(Left::NotAsked);
        self.close();
    }

    /// It is over, and the arm has forgotten what it did.
    pub(super) fn is_forgotten(&mut self) {
        self.mark.handed = self.handed();
        let span = Span {
            least: self.mark.finished,
            most: self.mark.handed,
        };
        self.mark = std::mem::take(&mut self.mark).ended(Verdict::Doubt(span));
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
        self.journal.write(&self.mark);
    }
}
