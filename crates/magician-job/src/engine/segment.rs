//! Segments: the part of a program that runs between two pauses.

use std::pin::pin;
use std::time::Duration;

use magician::{Error, ErrorKind, Progress, Ran, RunOptions};
use magician_program::{RemainingProgram, Timetable};
use tokio::time::{Instant, timeout};

use super::inbox::{Inbox, RunInterruption, Stopped};
use super::pace::Paced;
use super::{Engine, StartTime};
use crate::event::{JobEvent, JobProgress, JobState};

/// Interval between two progress events.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);
/// Deadline for a run to end after the queue was stopped. A choice, far above a reply's usual
/// delay.
const RUN_END_TIMEOUT: Duration = Duration::from_secs(3);

/// Part of a program, from where it begins or resumes.
pub(super) struct Segment {
    pub(super) rest: RemainingProgram,
    pub(super) timetable: Timetable,
    pub(super) started: StartTime,
    pub(super) keep: bool,
    /// Stops of the arm before the segment.
    pub(super) stops: u64,
    /// Index of the arm at rest before the segment.
    pub(super) rest_index: Option<u64>,
}

/// Outcome of a segment.
pub(super) enum SegmentEnd {
    Completed,
    /// Everything before a step that waits for a person is done.
    AtPause,
    /// The queue is stopped, and the command in progress runs to its end.
    Paused,
    Stopped,
    Failed(Error),
}

impl Segment {
    pub(super) fn new(
        rest: RemainingProgram,
        timetable: Timetable,
        started: StartTime,
        keep: bool,
    ) -> Self {
        Self {
            rest,
            timetable,
            started,
            keep,
            stops: 0,
            rest_index: None,
        }
    }
}

impl Engine {
    /// Runs a segment until it ends; returns what it has run.
    pub(super) async fn run(&self, segment: &Segment, inbox: &mut Inbox) -> (Ran, SegmentEnd) {
        let rest = &segment.rest;
        if rest.begins_with_pause() {
            let progress = self.progress(rest.from(), segment, Duration::ZERO);
            self.shared.publish_progress(progress);
            return (Ran::default(), SegmentEnd::AtPause);
        }
        let pause = rest.pause().map(|(step, _)| step);
        let completed = || match pause {
            Some(_) => SegmentEnd::AtPause,
            None => SegmentEnd::Completed,
        };
        match inbox.unless_stopped(self.prepare_pace(segment)).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return (Ran::default(), SegmentEnd::Failed(error)),
            Err(Stopped) => return (Ran::default(), SegmentEnd::Stopped),
        }
        self.shared
            .publish_progress(self.progress(rest.from(), segment, Duration::ZERO));
        self.shared.enter(JobState::Running);
        if inbox.wants_pause() {
            // Requested while the job was about to start or resume: nothing is sent before the
            // pause.
            self.shared.enter(JobState::Pausing);
            return (Ran::default(), SegmentEnd::Paused);
        }
        let commands = Paced {
            engine: self,
            commands: rest.commands_to_pause().peekable(),
            lead: rest.lead(),
            end: None,
            on_path: false,
        };
        // The lead over the arm is limited so that a speed change takes effect soon. A job that
        // keeps its speed needs no limit.
        let lead = Some(RunOptions::default().horizon).filter(|_| !self.needs_speed);
        let options = RunOptions::default()
            .keep(segment.keep)
            .lead(lead)
            .unless_stopped_since(segment.stops);
        let run = self.arm.start_with(commands, options);
        let mut run = run.along(rest.start().clone());
        let end = {
            let mut finish = pin!(run.wait(|progress| self.note_progress(segment, &progress)));
            let interruption = tokio::select! {
                // Requests first: a run that ends at the same moment must not hide a stop.
                biased;
                interruption = inbox.next_interruption() => Ok(interruption),
                never = self.follow_pace(segment) => match never {},
                ran = &mut finish => Err(ran),
            };
            match interruption {
                Err(Ok(_)) => completed(),
                Err(Err(error)) => SegmentEnd::Failed(error),
                // Waits for the run's last report: a dropped run reports nothing.
                Ok(RunInterruption::Stop) => {
                    let stop = self.arm.stop();
                    let _ = tokio::join!(stop, timeout(RUN_END_TIMEOUT, &mut finish));
                    SegmentEnd::Stopped
                }
                Ok(RunInterruption::Pause) => {
                    self.shared.enter(JobState::Pausing);
                    let stop = self.arm.stop_gentle();
                    let (stopped, ran) = tokio::join!(stop, timeout(RUN_END_TIMEOUT, &mut finish));
                    match (stopped, ran) {
                        // The run ended before the stop reached it.
                        (_, Ok(Ok(_))) => completed(),
                        (Err(error), _) => SegmentEnd::Failed(error),
                        (_, Ok(Err(error))) if !self.is_own_stop(segment, &error) => {
                            SegmentEnd::Failed(error)
                        }
                        // Ended by the stop of this pause, or too slow to report: the arm is asked
                        // next.
                        _ => SegmentEnd::Paused,
                    }
                }
            }
        };
        let ran = run.ran();
        drop(run);
        let mut tracker = self.tracker();
        tracker
            .counter
            .note(ran.commands, ran.last.map_or(0, |last| last.0));
        drop(tracker);
        let progress = self.shared.progress();
        let reached = match (&end, pause) {
            (SegmentEnd::AtPause, Some(step)) => {
                let steps = step.saturating_sub(rest.from());
                Some((step, self.pace().left(&segment.timetable, steps)))
            }
            (SegmentEnd::Completed, _) => self.steps().map(|steps| (steps, Some(Duration::ZERO))),
            _ => None,
        };
        let progress = match reached {
            Some((step, left)) => JobProgress {
                step,
                remaining: left,
                silent: Duration::ZERO,
                ..progress
            },
            None => progress,
        };
        self.shared.publish_progress(progress);
        self.shared.emit(JobEvent::Progress(progress));
        (ran, end)
    }

    /// True if the run was ended by the queue stop of a pause, and by nothing else.
    fn is_own_stop(&self, segment: &Segment, error: &Error) -> bool {
        error.kind() == ErrorKind::Closed && self.arm.stops() == segment.stops
    }

    /// Records what was sent and finished.
    fn note_progress(&self, segment: &Segment, progress: &Progress) {
        let mut tracker = self.tracker();
        let from = tracker.from();
        tracker.counter.note(progress.sent, progress.last.0);
        let finished = from + tracker.counter.finished(progress.current.0).least;
        let index = tracker
            .counter
            .last()
            .map(|(index, steps)| (index, from + steps));
        let clock = segment.started.clock_at_least();
        tracker.note_progress(finished, index, clock, progress.current.0);
        let now = self.progress(finished, segment, progress.silent);
        self.shared.publish_progress(now);
        if tracker
            .last_report
            .is_none_or(|last_report| last_report.elapsed() >= PROGRESS_INTERVAL)
        {
            tracker.last_report = Some(Instant::now());
            self.shared.emit(JobEvent::Progress(now));
        }
    }

    fn progress(&self, step: u64, segment: &Segment, silent: Duration) -> JobProgress {
        let iteration = self.spec.program.plan().steps.len().max(1) as u64;
        let iterations = self.spec.program.iterations().unwrap_or(u64::MAX);
        JobProgress {
            step,
            steps: self.steps(),
            iteration: (step / iteration).saturating_add(1).min(iterations.max(1)),
            remaining: self
                .pace()
                .left(&segment.timetable, step.saturating_sub(segment.rest.from())),
            silent,
        }
    }
}
