//! Progress of a run, stored so that another run can resume where it ended.
//!
//! The arm counts finished commands (its current index). While a run lasts, a [`StepCounter`] maps
//! an index to a step, and a [`Checkpoint`] is kept outside the process. However the run ends, the
//! checkpoint and one reading of the arm's index and clock give the place to resume at, or the
//! range of steps in doubt: [`Checkpoint::resume_point`].

use std::collections::VecDeque;
use std::fmt;

use magician_host::{Message, message};
use serde::{Deserialize, Serialize};

use crate::program::StepNumbering;

/// Number of index and command pairs kept: more than any queue is long.
const MAX_INDEX_PAIRS: usize = 256;

/// Maps a queue index to a step. A driver may insert commands between those of a plan and skip
/// indices, so the difference is not constant.
#[derive(Clone, Debug, Default)]
pub struct StepCounter {
    /// Number of commands before the first step.
    lead: u64,
    /// True if the driver may insert commands between the steps, or skip indices.
    mixed: bool,
    /// Indices with the number of the plan's commands up to each.
    pairs: VecDeque<(u64, u64)>,
    /// Last finished index of the arm at rest, before the first command.
    rest: Option<u64>,
    /// Commands inserted by the driver, by their number among all commands taken.
    inserted: VecDeque<u64>,
    /// Number of inserted commands that are no longer listed.
    unlisted: u64,
    /// Numbering of the steps, some of which have no command.
    numbering: StepNumbering,
    /// Number of commands of the steps before the first.
    before: u64,
    /// The first step.
    from: u64,
}

/// Number of steps known within bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepRange {
    /// Lower bound.
    pub least: u64,
    /// Upper bound.
    pub most: u64,
}

impl StepCounter {
    /// Creates the counter of a run whose first step is preceded by `lead` commands. `mixed` is
    /// true if the driver may insert commands (to switch a laser off), or skip indices (above
    /// window 1, when lost commands are sent again).
    #[must_use]
    pub fn new(lead: u64, mixed: bool) -> Self {
        Self {
            lead,
            mixed,
            pairs: VecDeque::new(),
            rest: None,
            inserted: VecDeque::new(),
            unlisted: 0,
            numbering: StepNumbering::default(),
            before: 0,
            from: 0,
        }
    }

    /// Applies the numbering of a program in which some steps have no command, starting at step
    /// `from`.
    #[must_use]
    pub(crate) fn numbered(self, numbering: StepNumbering, from: u64) -> Self {
        Self {
            before: numbering.commands(from),
            numbering,
            from,
            ..self
        }
    }

    /// Number of steps that this many commands complete.
    fn steps(&self, commands: u64) -> u64 {
        match commands.saturating_sub(self.lead) {
            0 => 0,
            commands => {
                let steps = self.numbering.steps(self.before.saturating_add(commands));
                steps.saturating_sub(self.from)
            }
        }
    }

    /// Sets the last finished index of an arm that was at rest, with an empty queue, before the
    /// first command.
    #[must_use]
    pub fn from_rest(mut self, index: Option<u64>) -> Self {
        self.rest = index.map(first_counted_index);
        self
    }

    /// Marks the command with this number (from 1) as inserted: it counts for no step. Call this
    /// before the arm takes the command, and in order.
    pub fn insert(&mut self, command: u64) {
        if self.inserted.len() >= MAX_INDEX_PAIRS {
            self.inserted.pop_front();
            self.unlisted += 1;
        }
        self.inserted.push_back(command);
    }

    /// True if the arm has finished all inserted commands when it has finished this index.
    #[must_use]
    pub fn has_passed_inserted(&self, current: u64) -> bool {
        let last = self.inserted.back();
        last.is_none_or(|last| self.taken(current).least >= *last)
    }

    /// Number of commands without the inserted ones.
    fn plan_commands(&self, commands: u64) -> u64 {
        let later = self.inserted.iter().rev();
        let later = later.take_while(|inserted| **inserted > commands).count() as u64;
        let earlier = self.unlisted + self.inserted.len() as u64 - later;
        commands.saturating_sub(earlier)
    }

    /// Notes that the arm has taken `commands` in all, the last one under `index`.
    pub fn note(&mut self, commands: u64, index: u64) {
        if commands == 0 {
            return;
        }
        // Commands dropped from the queue and sent again get new indices.
        while self
            .pairs
            .back()
            .is_some_and(|(_, known)| *known > commands)
        {
            self.pairs.pop_back();
        }
        // Keep the first and the last index with the same number of commands: those between are the
        // driver's own.
        let as_many = self
            .pairs
            .iter()
            .rev()
            .take_while(|(_, known)| *known == commands);
        if as_many.count() > 1 {
            self.pairs.pop_back();
        }
        // The oldest pair is far behind anything still in the queue.
        if self.pairs.len() >= MAX_INDEX_PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back((index, commands));
    }

    /// Range of steps finished when the arm has finished this index.
    #[must_use]
    pub fn finished(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.commands(current);
        StepRange {
            least: self.steps(least),
            most: self.steps(most),
        }
    }

    /// True if the commands before the first step are certainly finished when the arm has finished
    /// this index.
    #[must_use]
    pub fn is_at_first(&self, current: u64) -> bool {
        self.commands(current).least >= self.lead
    }

    /// Like [`finished`](Self::finished), but counts commands, including the lead before the first
    /// step.
    pub(crate) fn commands(&self, current: u64) -> StepRange {
        let StepRange { least, most } = self.taken(current);
        StepRange {
            least: self.plan_commands(least),
            most: self.plan_commands(most),
        }
    }

    /// Like [`commands`](Self::commands), including inserted ones.
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
            // Without foreign commands the nearest known index is exact.
            (least, most) = match after {
                Some(_) => (least, least),
                None => (most, most),
            };
        }
        // Before the first reply the arm may have taken any number of commands, up to its progress
        // since the run began.
        if self.pairs.is_empty() {
            (least, most) = (0, current.saturating_sub(self.rest.unwrap_or(current)));
        }
        StepRange {
            least,
            most: most.max(least),
        }
    }

    /// Like [`finished`](Self::finished), for an arm where indices after the last known one may
    /// belong to foreign or duplicate commands.
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

    /// Last known index, and the steps up to it.
    ///
    /// Until a step is taken, this is the index of the last command before the first step. The
    /// queue was empty at the start, so that index is known before the arm reports it.
    #[must_use]
    pub fn last(&self) -> Option<(u64, u64)> {
        let ahead = self.lead_commands();
        match self.pairs.back() {
            Some((index, commands)) if *commands < ahead => Some((index + (ahead - commands), 0)),
            Some((index, commands)) => Some((*index, self.steps(self.plan_commands(*commands)))),
            None => Some((self.rest?.saturating_add(ahead), 0)),
        }
    }

    /// Number of commands before the first step, including those inserted among them.
    fn lead_commands(&self) -> u64 {
        let inserted = (0..).zip(&self.inserted);
        let ahead = inserted.take_while(|(nth, command)| **command <= self.lead + nth + 1);
        self.lead + ahead.count() as u64
    }
}

/// Progress of a run, stored while it lasts and after it ended early. Steps are counted over all
/// loops.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Version of the format.
    pub version: u32,
    /// Title of the program.
    pub title: String,
    /// Number of all steps; `None` if endless.
    pub steps: Option<u64>,
    /// Steps known to be finished.
    pub finished: u64,
    /// Upper bound of the steps handed to the arm.
    pub handed: u64,
    /// Index of a step that the arm has taken, and the number of steps up to it.
    pub index: Option<(u64, u64)>,
    /// Last finished index of the arm before the run, if it was at rest then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<u64>,
    /// The arm's clock at that observation, ms.
    pub clock: u32,
    /// True if the driver may have inserted commands or skipped indices.
    pub mixed: bool,
    /// Number of finished steps, and the position (x, y, z) within the next one where the run
    /// resumes; `None` for its beginning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<(u64, [f64; 3])>,
    /// Upper bound of the length after that place that is burnt already, mm.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub twice: f64,
    /// End of the run, with which `finished` is exact. `None` if the run was interrupted.
    pub ended: Option<RunEnd>,
}

/// End of a run as stored in its checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunEnd {
    /// Between two steps.
    Between,
    /// Within the step after the finished ones.
    Within,
    /// Unknown: steps up to `handed` may be finished or not.
    Doubt,
}

/// Progress reported by the arm after a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObservedProgress {
    /// Last finished index.
    pub current: u64,
    /// The arm's clock, ms.
    pub clock: u32,
}

/// Place where a run resumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResumePoint {
    /// After this many finished steps; the next one has not begun.
    After(u64),
    /// After this many finished steps; the next one was cut short and is repeated.
    Again(u64),
    /// Unknown within this range.
    Doubt(StepRange),
}

/// Reason for unknown progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DoubtReason {
    /// The run itself ended in doubt, as recorded in its checkpoint.
    Recorded,
    /// The arm's progress cannot be read.
    NotReadable,
    /// Commands waited in the arm's queue when the run began, so its index says nothing about the
    /// run.
    NotAtRest,
    /// The arm's clock or index has restarted.
    Reset,
    /// The arm has finished more commands than the run sent.
    ForeignCommands,
    /// The arm also counts commands outside the plan, so its index is ambiguous.
    Mixed,
}

/// Unknown progress of a run, with bounds and reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// Bounds of the finished steps.
    pub span: StepRange,
    /// Reason.
    pub why: DoubtReason,
}

impl DoubtReason {
    /// Returns the reason, which completes "the progress of the last run is not known: ".
    #[must_use]
    pub fn sentence(self) -> Message {
        match self {
            Self::Recorded => message!("it ended while an answer of the arm was missing"),
            Self::NotReadable => message!("the arm does not tell how far it came"),
            Self::NotAtRest => {
                message!("other commands waited in the arm's queue when it began")
            }
            Self::Reset => message!("the arm was switched off or reset since"),
            Self::ForeignCommands => message!(
                "the arm has done more than the run gave it, so another program used it since"
            ),
            Self::Mixed => message!(
                "settings or commands sent again went out between its last steps, and the arm \
                    counts them like steps"
            ),
        }
    }
}

impl fmt::Display for DoubtReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence())
    }
}

impl Checkpoint {
    /// Current version of the format.
    pub const VERSION: u32 = 1;

    /// Checkpoint of a run that has not begun.
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

    /// Place to resume at. To be called once the arm's queue holds no command of the run.
    ///
    /// `seen` is the arm's report, if it can be read. `stands_after` returns true if the arm stands
    /// where this number of finished steps leaves it, `None` if that is unknown. The arm counts
    /// commands, and `numbering` maps them to steps.
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
            Some(RunEnd::Doubt) => return resume_in_doubt(self.bounds()),
            None => {}
        }
        let after = |commands: u64| self.steps_after(commands, numbering);
        // The arm counts commands; steps without one follow from the numbering.
        let point = match self.in_commands(numbering).finished_range(seen) {
            Ok(span) => resume_point_at(span.least, |commands| stands_after(after(commands))),
            Err((_, span)) => resume_in_doubt(span),
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

    /// Reason why the arm's report leaves the progress unknown; `None` if it is exact.
    #[must_use]
    pub fn doubt(
        &self,
        seen: Option<ObservedProgress>,
        numbering: &StepNumbering,
    ) -> Option<Doubt> {
        match self.ended {
            Some(RunEnd::Doubt) => Some(Doubt {
                span: self.bounds(),
                why: DoubtReason::Recorded,
            }),
            Some(RunEnd::Between | RunEnd::Within) => None,
            None => {
                let (why, StepRange { least, most }) =
                    self.in_commands(numbering).finished_range(seen).err()?;
                let [least, most] =
                    [least, most].map(|commands| self.steps_after(commands, numbering));
                let span = StepRange { least, most };
                Some(Doubt { span, why })
            }
        }
    }

    /// Bounds of the finished steps from the checkpoint alone.
    fn bounds(&self) -> StepRange {
        StepRange {
            least: self.finished,
            most: self.handed.max(self.finished),
        }
    }

    /// Number of steps that this many commands complete, but not less than `finished`: a pause or
    /// the beginning of a part after them may be done already.
    fn steps_after(&self, commands: u64, numbering: &StepNumbering) -> u64 {
        numbering.steps(commands).max(self.finished)
    }

    /// True if the arm's queue was empty when the run began, and the arm has taken nothing since.
    #[must_use]
    pub fn is_untouched(&self, seen: Option<ObservedProgress>) -> bool {
        self.ended.is_none()
            && seen.is_some_and(|seen| self.rest == Some(seen.current) && seen.clock >= self.clock)
    }

    /// Same checkpoint counted in commands, which is what the arm counts.
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

    /// Range of finished commands, for a checkpoint counted in commands
    /// ([`in_commands`](Self::in_commands)). The error has the bounds.
    fn finished_range(
        &self,
        seen: Option<ObservedProgress>,
    ) -> Result<StepRange, (DoubtReason, StepRange)> {
        let all = self.bounds();
        let seen = seen.ok_or((DoubtReason::NotReadable, all))?;
        let span = match self.index {
            Some((index, steps)) => {
                // A clock or index that runs behind means a power cycle. Until the first step is
                // finished the arm may be at any of the commands before it.
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
                self.range_from(seen.current, (index, steps))
            }
            // No index at all: the arm was not at rest, and no reply arrived.
            None if self.rest.is_none() => return Err((DoubtReason::NotAtRest, all)),
            None => self
                .range_since_rest(seen)
                .ok_or((DoubtReason::Reset, all))?,
        };
        // More than this run sent: another client has used the arm since.
        if span.most > all.most {
            Err((DoubtReason::ForeignCommands, all))
        } else if span.least != span.most {
            Err((DoubtReason::Mixed, span))
        } else {
            Ok(span)
        }
    }

    /// Place within the step after `steps` where it resumes; `None` for its beginning.
    #[must_use]
    pub fn place_after(&self, steps: u64) -> Option<[f64; 3]> {
        let (behind, place) = self.within?;
        (behind == steps).then_some(place)
    }

    /// Checkpoint of a run that is over and resumes at this point.
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

    /// Range for a run without a reply, on an arm that was at rest before: each command that the
    /// arm has done since then has raised its index by one.
    fn range_since_rest(&self, seen: ObservedProgress) -> Option<StepRange> {
        let raised =
            first_counted_index(seen.current).checked_sub(first_counted_index(self.rest?))?;
        let most = self.finished.saturating_add(raised);
        (seen.clock >= self.clock).then_some(StepRange {
            least: self.finished,
            most: most.min(self.handed.max(self.finished)),
        })
    }

    fn range_from(&self, current: u64, (index, steps): (u64, u64)) -> StepRange {
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

/// Index from which the commands of an arm at rest are counted. Arms number their first command 2
/// (model section 14), so the index 0 of an arm that has finished none counts as 1. On an arm that
/// begins with 1 the count is one command too low until its first reply.
fn first_counted_index(current: u64) -> u64 {
    current.max(1)
}

/// Place to resume at for an exact count. The arm counts an interrupted step as finished; only its
/// pose shows the difference.
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

/// True if nothing is burnt twice; used to skip the field.
fn is_zero(mm: &f64) -> bool {
    *mm == 0.0
}

/// Repeats a single step in doubt. With more steps in doubt, a person has to decide.
fn resume_in_doubt(span: StepRange) -> ResumePoint {
    match span.most.saturating_sub(span.least) {
        0 => ResumePoint::After(span.least),
        1 => ResumePoint::Again(span.least),
        _ => ResumePoint::Doubt(span),
    }
}

#[cfg(test)]
mod tests;
