//! Progress of a run, stored so that another run can resume where it ended.
//!
//! The arm counts finished commands (its current index). While a run lasts, a [`StepCounter`] maps
//! an index to a step, and a [`Checkpoint`] is kept outside the process. However the run ends, the
//! checkpoint and one reading of the arm's index and clock give the place to resume at, or the
//! range of steps in doubt: [`Checkpoint::resume_point`].

mod step_counter;

use std::fmt;

use magician_host::{Message, message};
use serde::{Deserialize, Serialize};

use crate::program::StepNumbering;
use step_counter::first_counted_index;
pub use step_counter::{StepCounter, StepRange};

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
