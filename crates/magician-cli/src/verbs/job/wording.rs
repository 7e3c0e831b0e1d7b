//! Wording of a job's failures and of how to resume it, for the command line.

use magician::{ErrorKind, Setting, SettingValue};
use magician_job::{
    Fault, InterruptedJob, JobError, JournalError, MIN_REPORTED_OVERLAP, PenLift, ResumeError,
    ResumePlace,
};
use magician_program::resume::{ResumePoint, StepRange};
use magician_program::{Diagnostic, Origin};

use super::{PreparedJob, needs_start, report};
use crate::context::{INTERRUPTED, STATION_ENDED, format_position, kind_of_stop, not_confirmed};
use crate::failure::{Failure, Kind};

/// Message after a second stop that was not confirmed.
pub(super) const STOP_UNCONFIRMED: &str = "interrupted twice: the arm may still be moving";

/// Context of the sentences: the job that ran.
pub(super) struct Wording<'a> {
    pub(super) made: &'a PreparedJob,
    /// True if the arm is reached through a station.
    pub(super) at_station: bool,
}

impl Wording<'_> {
    /// Formats as ` of 800`; empty if the number of steps is unknown.
    pub(super) fn of(&self) -> String {
        let steps = self.made.prepared.program.steps();
        steps.map_or_else(String::new, |steps| format!(" of {steps}"))
    }

    /// Converts the error of a job into a failure.
    pub(super) fn failure(&self, error: &JobError) -> Failure {
        let mut failure = self.fault(error);
        if error.all_done {
            failure.message = format!("all steps are done, but then: {}", failure.message);
        }
        if let Some(said) = pen_lift_text(&error.lift) {
            failure.message = format!("{}; {said}", failure.message);
        }
        self.with_advice(failure, error)
    }

    /// Returns the note about an earlier run of the same file that was cut off and is not resumed.
    pub(super) fn unfinished(&self, finished: u64, resumable: bool) -> Diagnostic {
        let of = self.of();
        let text = format!(
            "an earlier run of this file was interrupted after at least {finished}{of} steps; this \
                run starts from the beginning"
        );
        let goes_on = "continues where it ended";
        let note = Diagnostic::new(Origin::NONE, text);
        if resumable {
            note.remedy((Setting::Resume, SettingValue::On), goes_on)
        } else {
            note
        }
    }

    /// Returns the failure of a stopped job, and true if the arm is known to stand.
    pub(super) fn stopped(&self, error: &JobError) -> (Failure, bool) {
        let twice = matches!(error.fault, Fault::Stopped { twice: true });
        let cause = if error.stopped_by_line_end {
            STATION_ENDED
        } else {
            INTERRUPTED
        };
        let (message, stands) = match (&error.pose, &error.unconfirmed) {
            (Some(pose), None) if twice => (
                format!("interrupted twice: {}; queue empty", format_position(pose)),
                true,
            ),
            _ if twice => (STOP_UNCONFIRMED.to_owned(), false),
            (Some(pose), None) => {
                let said =
                    pen_lift_text(&error.lift).map_or_else(String::new, |said| format!("{said}; "));
                let message = format!("{cause}: {said}{}; queue empty", format_position(pose));
                (message, true)
            }
            (None, None) if error.stopped_by_line_end && error.resume_place.is_none() => (
                format!("{cause} before the arm received a command of this job"),
                true,
            ),
            _ if error.stopped_by_line_end => (
                format!("{cause} before the arm confirmed that it has stopped: look at the arm"),
                false,
            ),
            (_, Some(why)) => (not_confirmed(cause, &why.to_string()), false),
            (None, None) => (not_confirmed(cause, "it took too long"), false),
        };
        let failure = Failure::new(kind_of_stop(error.stopped_by_line_end, twice), message);
        (self.with_advice(failure, error), stands)
    }

    /// Converts an error of starting or resuming into a failure.
    pub(super) fn resume(&self, error: &ResumeError) -> Failure {
        match error {
            ResumeError::Arm(error) | ResumeError::Refused(error) => Failure::from(&**error),
            ResumeError::Program(problem) => self.made.source.failure(problem),
            other if other.wants_homing() => Failure::unexpected(format!(
                "{other} (`magician home`), or stop the job, home the arm, and use --resume"
            )),
            other => Failure::invalid(other.to_string()),
        }
    }

    fn fault(&self, error: &JobError) -> Failure {
        let from_step = "--from STEP starts at any step";
        match &error.fault {
            Fault::Arm(error) => Failure::from(&**error),
            Fault::Program(problem) => self.made.source.failure(problem),
            Fault::Refused { report, rest } => report::failure(self.made, rest, report, false),
            Fault::Journal(JournalError::Unreadable { place }) => {
                Failure::invalid(format!("{place} cannot be read: another version wrote it"))
                    .hint(from_step)
            }
            Fault::Journal(JournalError::OtherPrograms(others))
                if self.with_other_flags(others).is_some() =>
            {
                let message = self.with_other_flags(others).unwrap_or_default();
                Failure::invalid(message).hint(format!(
                    "repeat the flags of that run with --resume; {from_step}"
                ))
            }
            Fault::Journal(_) => Failure::invalid(
                "nothing to resume: no interrupted run of this program in this placement",
            )
            .hint(from_step),
            Fault::AllDone => Failure::invalid("nothing to resume: all steps are done"),
            Fault::Doubt { span, why } => {
                let message = format!("the progress of the last run is not known: {why}");
                Failure::new(Kind::Driver(ErrorKind::Uncertain), message).hint(self.in_doubt(*span))
            }
            Fault::StuckQueue { waiting } => {
                let message = format!(
                    "{waiting} commands of the last run wait in the arm's queue, and nothing moves"
                );
                Failure::invalid(message).hint(
                    "`magician alarms` shows alarms that may hold it; `magician stop` drops the \
                        commands, then --resume continues",
                )
            }
            Fault::UnknownStartPose => needs_start(),
            other => Failure::invalid(format!("{other:?}")),
        }
    }

    /// Returns a hint if the same file was interrupted with other flags.
    fn with_other_flags(&self, others: &[InterruptedJob]) -> Option<String> {
        let title = &self.made.prepared.program.plan().title;
        let job = others.iter().find(|job| job.title == *title)?;
        let age = job.at.elapsed().unwrap_or_default().as_secs() / 60;
        let age = match age {
            0 => "a moment ago".to_owned(),
            minutes if minutes < 120 => format!("{minutes} min ago"),
            minutes => format!("{} h ago", minutes / 60),
        };
        Some(format!(
            "no run of {title} with these flags was interrupted, but one with other flags was, \
                {age}, after at least {} steps",
            job.finished
        ))
    }

    /// Adds the advice how to resume.
    fn with_advice(&self, failure: Failure, error: &JobError) -> Failure {
        let command = format!("the same command with {}--resume", self.with_start());
        let advice = match error.resume_place {
            Some(left) if error.storage_error.is_some() => self.advice_unsaved(left),
            None => return failure,
            Some(ResumePlace::NotRead) if self.at_station => format!(
                "the state of the arm is unknown: look at the arm; when a station serves it again \
                    and it has stopped, {command} continues"
            ),
            Some(ResumePlace::NotRead) => {
                format!("the arm finishes its queue; after that, {command} continues")
            }
            Some(ResumePlace::Known {
                resume_point,
                within,
                burnt_twice,
            }) => self.advice(resume_point, (within, burnt_twice), &command),
            Some(ResumePlace::Forgotten(span)) => self.in_doubt(span),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let advice = match error.resume_place {
            Some(ResumePlace::Known { .. }) if error.stopped_by_line_end => {
                format!("start the station again; {advice}")
            }
            _ => advice,
        };
        failure.hint(advice)
    }

    /// Returns the advice for a job whose progress was not saved.
    fn advice_unsaved(&self, left: ResumePlace) -> String {
        let lost = "the progress could not be saved";
        let steps = match left {
            ResumePlace::Known { resume_point, .. } => match resume_point {
                ResumePoint::After(steps) | ResumePoint::Again(steps) => steps,
                ResumePoint::Doubt(span) => return format!("{lost}: {}", self.in_doubt(span)),
            },
            ResumePlace::Forgotten(span) => return format!("{lost}: {}", self.in_doubt(span)),
            ResumePlace::NotRead => {
                return format!("{lost}: the same command starts from the beginning");
            }
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        let (of, start, next) = (self.of(), self.with_start(), steps + 1);
        format!("{steps}{of} steps are done; {lost}: {start}--from {next} starts with step {next}")
    }

    fn advice(
        &self,
        resume_point: ResumePoint,
        (within, burnt_twice): (bool, f64),
        command: &str,
    ) -> String {
        let of = self.of();
        match resume_point {
            ResumePoint::Again(steps) | ResumePoint::After(steps)
                if burnt_twice >= MIN_REPORTED_OVERLAP =>
            {
                format!(
                    "{steps}{of} steps are done; {command} continues in step {}, before where it \
                        stopped, and up to {burnt_twice:.1} mm are burnt twice",
                    steps + 1
                )
            }
            ResumePoint::Again(steps) if within => {
                let place = if self.made.prepared.program.plan().burns() {
                    "the laser went out"
                } else {
                    "it stopped"
                };
                format!(
                    "{steps}{of} steps are done and the next was interrupted; {command} continues \
                        where {place}, in step {}",
                    steps + 1
                )
            }
            ResumePoint::After(steps) => format!(
                "{steps}{of} steps are done; {command} continues with step {}",
                steps + 1
            ),
            ResumePoint::Again(steps) => format!(
                "{steps}{of} steps are done and the next was interrupted; {command} continues with step {}",
                steps + 1
            ),
            ResumePoint::Doubt(span) => self.in_doubt(span),
        }
    }

    fn in_doubt(&self, StepRange { least, most }: StepRange) -> String {
        let which = match most.saturating_sub(least) {
            0 | 1 => format!("step {}", least + 1),
            _ => format!("steps {} to {most}", least + 1),
        };
        let start = self.with_start();
        format!(
            "{least} steps are certainly done, {which} may be: look at the work, then \
                {start}--from {} repeats them, {start}--from {} skips them",
            least + 1,
            most + 1
        )
    }

    /// Returns the `--start` flag that resuming needs; empty unless the program depends on its
    /// start position.
    fn with_start(&self) -> String {
        match self.made.prepared.start {
            Some([x, y, z]) if self.made.prepared.program.depends_throughout() => {
                format!("--start {x:.3},{y:.3},{z:.3} ")
            }
            _ => String::new(),
        }
    }
}

/// Describes what happened to the pen; `None` if it needed nothing.
fn pen_lift_text(lift: &PenLift) -> Option<String> {
    Some(match lift {
        PenLift::Lifted(lifted) => lifted.to_string(),
        PenLift::KeptDown => "the pen stays down (`--stay`)".to_owned(),
        PenLift::Failed(error) => format!("the pen was not lifted: {error}"),
        PenLift::TimedOut => "the pen may not be up: lifting it took too long".to_owned(),
        _ => return None,
    })
}
