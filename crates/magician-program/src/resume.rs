//! How far a run has come, kept so that another can go on where it ended.
//!
//! The arm counts what it has finished (its current index). While a run lasts, a [`StepCounter`] says which step an index belongs to,
//! and a [`Checkpoint`] is kept outside the process. However the run ends, the checkpoint and one more look at the arm tell where to
//! resume, or which steps are in doubt: [`Checkpoint::resume_point`].

use std::collections::VecDeque;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::program::StepNumbering;

/// As many pairs are remembered: more than any queue is long.
const REMEMBERED: usize = 256;

/// Which step a queue index belongs to. A driver may put commands of its own between those of a plan, and pass over indices, so
/// that there is no fixed difference.
#[derive(Clone, Debug, Default)]
pub struct StepCounter {
    /// Commands before the first step.
    lead: u64,
    /// Whether the driver may put commands of its own between the steps, or pass over indices.
    mixed: bool,
    /// An index, and the commands of the plan up to it.
    pairs: VecDeque<(u64, u64)>,
    /// The index that the arm had finished last when it was at rest, before the first command.
    rest: Option<u64>,
    /// Commands that are none of the plan's, by how many the arm had taken with each.
    inserted: VecDeque<u64>,
    /// Those of them that are remembered no more.
    forgotten: u64,
    /// Which steps have no command, and the commands of those before the first.
    numbering: StepNumbering,
    before: u64,
    /// The first step.
    from: u64,
}

/// A number of steps that is known within bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepRange {
    /// At least.
    pub least: u64,
    /// At most.
    pub most: u64,
}

impl StepCounter {
    /// For a run whose first step is preceded by so many commands. `mixed`: the driver may put commands of its own between
    /// them (to darken a laser), or pass over indices (above window 1, when commands were lost and go again).
    #[must_use]
    pub fn new(lead: u64, mixed: bool) -> Self {
        Self {
            lead,
            mixed,
            pairs: VecDeque::new(),
            rest: None,
            inserted: VecDeque::new(),
            forgotten: 0,
            numbering: StepNumbering::default(),
            before: 0,
            from: 0,
        }
    }

    /// The same of a program whose steps do not all have a command, from this step of it on.
    #[must_use]
    pub(crate) fn numbered(self, numbering: StepNumbering, from: u64) -> Self {
        Self {
            before: numbering.commands(from),
            numbering,
            from,
            ..self
        }
    }

    /// The steps up to the last of so many commands.
    fn steps(&self, commands: u64) -> u64 {
        match commands.saturating_sub(self.lead) {
            0 => 0,
            commands => {
                let steps = self.numbering.steps(self.before.saturating_add(commands));
                steps.saturating_sub(self.from)
            }
        }
    }

    /// Before the first command the arm was at rest, its queue empty, and this was the index it had finished last.
    #[must_use]
    pub fn from_rest(mut self, index: Option<u64>) -> Self {
        self.rest = index.map(counts_from);
        self
    }

    /// The command with this number, from 1, is none of the plan's: it is counted for no step. To be said before the arm takes it,
    /// and in order.
    pub fn insert(&mut self, command: u64) {
        if self.inserted.len() >= REMEMBERED {
            self.inserted.pop_front();
            self.forgotten += 1;
        }
        self.inserted.push_back(command);
    }

    /// Whether the arm has finished all that was inserted, when it has finished this index.
    #[must_use]
    pub fn has_passed_inserted(&self, current: u64) -> bool {
        let last = self.inserted.back();
        last.is_none_or(|last| self.taken(current).least >= *last)
    }

    /// So many commands without those that were inserted.
    fn of_plan(&self, commands: u64) -> u64 {
        let later = self.inserted.iter().rev();
        let later = later.take_while(|inserted| **inserted > commands).count() as u64;
        let earlier = self.forgotten + self.inserted.len() as u64 - later;
        commands.saturating_sub(earlier)
    }

    /// The arm has taken so many commands, the last of them under this index.
    pub fn note(&mut self, commands: u64, index: u64) {
        if commands == 0 {
            return;
        }
        // What was dropped from the queue is counted anew.
        while self
            .pairs
            .back()
            .is_some_and(|(_, known)| *known > commands)
        {
            self.pairs.pop_back();
        }
        // The first and the last index with as many commands up to them: between those are the driver's own.
        let as_many = self
            .pairs
            .iter()
            .rev()
            .take_while(|(_, known)| *known == commands);
        if as_many.count() > 1 {
            self.pairs.pop_back();
        }
        if self.pairs.len() >= REMEMBERED {
            self.pairs.pop_front();
        }
        self.pairs.push_back((index, commands));
    }

    /// The steps that are finished when the arm has finished this index.
    #[must_use]
    pub fn finished(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.commands(current);
        StepRange {
            least: self.steps(least),
            most: self.steps(most),
        }
    }

    /// True if the commands before the first step are finished for certain when the arm has finished this index.
    #[must_use]
    pub fn is_at_first(&self, current: u64) -> bool {
        self.commands(current).least >= self.lead
    }

    /// The same in commands, with those before the first step.
    pub(crate) fn commands(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.taken(current);
        StepRange {
            least: self.of_plan(least),
            most: self.of_plan(most),
        }
    }

    /// The same with those that were inserted.
    fn taken(&self, current: u64) -> StepRange {
        let before = self.pairs.iter().rev().find(|(index, _)| *index <= current);
        let after = self.pairs.iter().find(|(index, _)| *index > current);
        let (mut least, mut most) = (0, u64::MAX);
        if let Some((index, commands)) = before {
            least = *commands;
            most = commands.saturating_add(current.saturating_sub(*index));
        }
        if let Some((index, commands)) = after {
            least = least.max(commands.saturating_sub(index.saturating_sub(current)));
            most = most.min(*commands);
        }
        if !self.mixed {
            (least, most) = match after {
                Some(_) => (least, least),
                None => (most, most),
            };
        }
        // Before the first answer nothing is, but for what the arm may have taken without saying so.
        if self.pairs.is_empty() {
            (least, most) = (0, current.saturating_sub(self.rest.unwrap_or(current)));
        }
        StepRange {
            least,
            most: most.max(least),
        }
    }

    /// The same where an index may stand for a command of others, or for one that came twice, behind the last that the arm is
    /// known to have taken.
    #[must_use]
    pub fn certain(&self, current: u64) -> StepRange {
        let span = self.finished(current);
        match self.last() {
            Some((index, steps)) if current > index => StepRange {
                least: steps,
                ..span
            },
            _ => span,
        }
    }

    /// The last index, and the steps up to it.
    ///
    /// As long as no step was taken it is the one of the last command before the first step. The
    /// arm's queue was empty when the run began, so its index is known before the arm has given it.
    #[must_use]
    pub fn last(&self) -> Option<(u64, u64)> {
        let ahead = self.ahead();
        match self.pairs.back() {
            Some((index, commands)) if *commands < ahead => Some((index + (ahead - commands), 0)),
            Some((index, commands)) => Some((*index, self.steps(self.of_plan(*commands)))),
            None => Some((self.rest?.saturating_add(ahead), 0)),
        }
    }

    /// Commands before the first step, with those that were inserted among them.
    fn ahead(&self) -> u64 {
        let inserted = (0..).zip(&self.inserted);
        let ahead = inserted.take_while(|(nth, command)| **command <= self.lead + nth + 1);
        self.lead + ahead.count() as u64
    }
}

/// How far a run has come: what is kept while it lasts, and after it ended badly. Steps are counted over all loops.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Of this form.
    pub version: u32,
    /// What is run.
    pub title: String,
    /// Steps in all; none if they go on for ever.
    pub steps: Option<u64>,
    /// So many are known to be finished.
    pub finished: u64,
    /// So many, at most, have been given to the arm.
    pub handed: u64,
    /// The index of a step that the arm has taken, and how many steps there are up to it.
    pub index: Option<(u64, u64)>,
    /// The index that the arm had finished last when the run began, if it was at rest then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<u64>,
    /// The arm's clock when that was seen, ms.
    pub clock: u32,
    /// Whether the driver may have put commands of its own between the steps, or passed over indices.
    pub mixed: bool,
    /// Where the step behind so many goes on, if not at its beginning: x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<(u64, [f64; 3])>,
    /// Largest length from where it goes on that has been burnt already, mm.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub twice: f64,
    /// The run has ended and said so: `finished` is exact.
    pub ended: Option<RunEnd>,
}

/// How a run has ended, as its checkpoint keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunEnd {
    /// Between two steps.
    Between,
    /// In the middle of one: the one after those that are finished.
    Within,
    /// The steps up to `handed` may be finished or not.
    Doubt,
}

/// How far the arm says that it is, when a run is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObservedProgress {
    /// The index that it finished last.
    pub current: u64,
    /// Its clock, ms.
    pub clock: u32,
}

/// Where a run is resumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResumePoint {
    /// So many steps are finished, and the next has not begun.
    After(u64),
    /// So many steps are finished; the next was cut short and has to be done again.
    Again(u64),
    /// So many at least and so many at most.
    Doubt(StepRange),
}

/// Why it is not known how far a run came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DoubtReason {
    /// The run ended in doubt, and its checkpoint says so.
    Ended,
    /// The arm cannot be asked.
    NotAsked,
    /// Commands waited in the arm's queue when the run began, so its indices say nothing of the run.
    NotAtRest,
    /// The arm's clock or index began anew.
    Reset,
    /// The arm has finished more commands than the run gave it.
    Others,
    /// The arm counts commands that are no steps, and does not say which it has finished.
    Mixed,
}

/// Uncertain progress of a run: its bounds, and the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// Steps at least and at most.
    pub span: StepRange,
    /// Why.
    pub why: DoubtReason,
}

/// Follows "the progress of the last run is not known: ".
impl fmt::Display for DoubtReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ended => "it ended while an answer of the arm was missing",
            Self::NotAsked => "the arm does not tell how far it came",
            Self::NotAtRest => "other commands waited in the arm's queue when it began",
            Self::Reset => "the arm was switched off or reset since",
            Self::Others => {
                "the arm has done more than the run gave it, so another program used it since"
            }
            Self::Mixed => {
                "settings or commands sent again went out between its last steps, and the arm \
                    counts them like steps"
            }
        })
    }
}

impl Checkpoint {
    /// The form that is written now.
    pub const VERSION: u32 = 1;

    /// A run that has not begun.
    #[must_use]
    pub fn new(title: &str, steps: Option<u64>, mixed: bool) -> Self {
        Self {
            version: Self::VERSION,
            title: title.to_owned(),
            steps,
            mixed,
            ..Self::default()
        }
    }

    /// Where to go on, when nothing of the run waits in the arm's queue any more. `seen` is what the arm says, if it can be
    /// asked. `stands_after` tells whether the arm stands where so many steps leave it; `None` if that is not known. The arm counts
    /// commands, of which not all steps have one (`numbering`).
    #[must_use]
    pub fn resume_point(
        &self,
        seen: Option<ObservedProgress>,
        numbering: &StepNumbering,
        stands_after: impl FnOnce(u64) -> Option<bool>,
    ) -> ResumePoint {
        match self.ended {
            Some(RunEnd::Between) => return ResumePoint::After(self.finished),
            Some(RunEnd::Within) => return ResumePoint::Again(self.finished),
            Some(RunEnd::Doubt) => return in_doubt(self.all()),
            None => {}
        }
        let after = |commands: u64| self.after(commands, numbering);
        let point = match self.in_commands(numbering).counted(seen) {
            Ok(span) => resume_point_at(span.least, |commands| stands_after(after(commands))),
            Err((_, span)) => in_doubt(span),
        };
        match point {
            ResumePoint::After(commands) => ResumePoint::After(after(commands)),
            ResumePoint::Again(commands) => {
                let next = numbering.steps(commands.saturating_add(1));
                ResumePoint::Again(next.saturating_sub(1).max(self.finished))
            }
            ResumePoint::Doubt(StepRange { least, most }) => ResumePoint::Doubt(StepRange {
                least: after(least),
                most: after(most),
            }),
        }
    }

    /// Why the arm does not tell exactly how far the run came; `None` if it does.
    #[must_use]
    pub fn doubt(
        &self,
        seen: Option<ObservedProgress>,
        numbering: &StepNumbering,
    ) -> Option<Doubt> {
        match self.ended {
            Some(RunEnd::Doubt) => Some(Doubt {
                span: self.all(),
                why: DoubtReason::Ended,
            }),
            Some(RunEnd::Between | RunEnd::Within) => None,
            None => {
                let (why, StepRange { least, most }) =
                    self.in_commands(numbering).counted(seen).err()?;
                let [least, most] = [least, most].map(|commands| self.after(commands, numbering));
                let span = StepRange { least, most };
                Some(Doubt { span, why })
            }
        }
    }

    /// Bounds of the finished steps by the checkpoint alone.
    fn all(&self) -> StepRange {
        StepRange {
            least: self.finished,
            most: self.handed.max(self.finished),
        }
    }

    /// The steps up to the last of so many commands. A pause or the beginning of a part behind it may
    /// be done already.
    fn after(&self, commands: u64, numbering: &StepNumbering) -> u64 {
        numbering.steps(commands).max(self.finished)
    }

    /// True if the arm had an empty queue when the run began, and has taken nothing since.
    #[must_use]
    pub fn is_untouched(&self, seen: Option<ObservedProgress>) -> bool {
        self.ended.is_none()
            && seen.is_some_and(|seen| self.rest == Some(seen.current) && seen.clock >= self.clock)
    }

    /// The same with commands for steps: the arm counts those.
    fn in_commands(&self, numbering: &StepNumbering) -> Self {
        Self {
            finished: numbering.commands(self.finished),
            handed: numbering.commands(self.handed),
            index: self
                .index
                .map(|(index, steps)| (index, numbering.commands(steps))),
            ..self.clone()
        }
    }

    /// Commands that are finished. Of a run in commands, as [`in_commands`](Self::in_commands) makes
    /// it; an error has the bounds.
    fn counted(
        &self,
        seen: Option<ObservedProgress>,
    ) -> Result<StepRange, (DoubtReason, StepRange)> {
        let all = self.all();
        let seen = seen.ok_or((DoubtReason::NotAsked, all))?;
        let span = match self.index {
            Some((index, steps)) => {
                // A clock that runs behind, or an index: the arm was switched off and on. Before the
                // first step is finished the arm may be at any command ahead of it.
                let under_way = steps.saturating_sub(self.finished);
                let least = index.saturating_sub(under_way);
                let least = match self.rest {
                    Some(rest) if under_way == 0 => rest.min(least),
                    _ => least,
                };
                let reset = seen.current < least;
                if reset || seen.clock < self.clock {
                    return Err((DoubtReason::Reset, all));
                }
                self.count(seen.current, (index, steps))
            }
            None if self.rest.is_none() => return Err((DoubtReason::NotAtRest, all)),
            None => self.since_rest(seen).ok_or((DoubtReason::Reset, all))?,
        };
        if span.most > all.most {
            Err((DoubtReason::Others, all))
        } else if span.least != span.most {
            Err((DoubtReason::Mixed, span))
        } else {
            Ok(span)
        }
    }

    /// Where the step behind so many goes on, if not at its beginning.
    #[must_use]
    pub fn place_after(&self, steps: u64) -> Option<[f64; 3]> {
        let (behind, place) = self.within?;
        (behind == steps).then_some(place)
    }

    /// The checkpoint of a run that is over: where it is resumed.
    #[must_use]
    pub fn ended(mut self, resume_point: ResumePoint) -> Self {
        match resume_point {
            ResumePoint::After(steps) => {
                (self.finished, self.ended) = (steps, Some(RunEnd::Between))
            }
            ResumePoint::Again(steps) => {
                (self.finished, self.ended) = (steps, Some(RunEnd::Within))
            }
            ResumePoint::Doubt(span) => {
                (self.finished, self.handed) = (span.least, span.most);
                self.ended = Some(RunEnd::Doubt);
            }
        }
        self
    }

    /// Of a run that had no answer from an arm that was at rest when it began: an arm that still is has done nothing of it, and
    /// each step that it has done has raised its index.
    fn since_rest(&self, seen: ObservedProgress) -> Option<StepRange> {
        let raised = counts_from(seen.current).checked_sub(counts_from(self.rest?))?;
        let most = self.finished.saturating_add(raised);
        (seen.clock >= self.clock).then_some(StepRange {
            least: self.finished,
            most: most.min(self.handed.max(self.finished)),
        })
    }

    fn count(&self, current: u64, (index, steps): (u64, u64)) -> StepRange {
        if current <= index {
            let least = steps.saturating_sub(index - current).max(self.finished);
            let most = if self.mixed { steps } else { least };
            return StepRange {
                least,
                most: most.max(least),
            };
        }
        let most = steps.saturating_add(current - index);
        let least = if self.mixed { steps } else { most };
        StepRange { least, most }
    }
}

/// Index behind which the next commands of an arm at rest are numbered. Arms begin with 2 (model section 14), so that 0, of
/// one that has finished none, counts as 1. On an arm that begins with 1 one command too few counts, until its first answer.
fn counts_from(current: u64) -> u64 {
    current.max(1)
}

/// The arm counts a step that was cut short as finished; where it stands tells the two apart.
#[must_use]
pub fn resume_point_at(
    finished: u64,
    stands_after: impl FnOnce(u64) -> Option<bool>,
) -> ResumePoint {
    match stands_after(finished) {
        Some(false) if finished > 0 => ResumePoint::Again(finished - 1),
        _ => ResumePoint::After(finished),
    }
}

/// True if nothing is burnt twice.
fn is_zero(mm: &f64) -> bool {
    *mm == 0.0
}

/// One step in doubt is done again; more are for a person to decide.
fn in_doubt(span: StepRange) -> ResumePoint {
    match span.most.saturating_sub(span.least) {
        0 => ResumePoint::After(span.least),
        1 => ResumePoint::Again(span.least),
        _ => ResumePoint::Doubt(span),
    }
}

#[cfg(test)]
mod tests;
