//! Segments: the part of a program that runs between two pauses.

use std::pin::pin;
use std::time::Duration;

use magician::{Error, ErrorKind, Progress, RunOptions, RunSummary};
use magician_program::{RemainingProgram, Timetable};
use tokio::time::{Instant, timeout};

use super::inbox::{Inbox, Stopped, Wish};
use super::pace::Paced;
use super::{Begun, Work};
use crate::event::{JobEvent, JobProgress, JobState};

/// Interval between two progress events.
const TELL: Duration = Duration::from_millis(100);
/// Deadline for a run to end after the queue was stopped. A choice, far above a reply's usual
/// delay.
const GIVE_UP: Duration = Duration::from_secs(3);

/// Part of a program, from where it begins or resumes.
pub(super) struct Segment {
    pub(super) rest: RemainingProgram,
    pub(super) timetable: Timetable,
    pub(super) begun: Begun,
    pub(super) keep: bool,
    /// Stops of the arm before the segment.
    pub(super) stops: u64,
    /// Index of the arm at rest before the segment.
    pub(super) rests_at: Option<u64>,
}

/// Outcome of a segment.
pub(super) enum End {
    Done,
    /// Everything before a step that waits for a person is done.
    AtPause,
    /// The queue is stopped, and the command in progress runs to its end.
    Paused,
    Stopped,
    Failed(Error),
}

impl Segment {
    pub(super) fn of(
        rest: RemainingProgram,
        timetable: Timetable,
        begun: Begun,
        keep: bool,
    ) -> Self {
        Self {
            rest,
            timetable,
            begun,
            keep,
            stops: 0,
            rests_at: None,
        }
    }
}

impl Work {
    /// Runs a segment until it ends; returns what it has run.
    pub(super) async fn run(&self, segment: &Segment, inbox: &mut Inbox) -> (RunSummary, End) {
        let rest = &segment.rest;
        if rest.begins_with_pause() {
            let progress = self.progress(rest.from(), segment, Duration::ZERO);
            self.shared.reach(progress);
            return (RunSummary::default(), End::AtPause);
        }
        let pause = rest.pause().map(|(step, _)| step);
        let comes_to_end = || match pause {
            Some(_) => End::AtPause,
            None => End::Done,
        };
        match inbox.unless_stopped(self.begins_paced(segment)).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return (RunSummary::default(), End::Failed(error)),
            Err(Stopped) => return (RunSummary::default(), End::Stopped),
        }
        self.shared
            .reach(self.progress(rest.from(), segment, Duration::ZERO));
        self.shared.enter(JobState::Running);
        if inbox.wants_pause() {
            // Requested while the job was about to start or resume: nothing is sent before the
            // pause.
            self.shared.enter(JobState::Pausing);
            return (RunSummary::default(), End::Paused);
        }
        let commands = Paced {
            work: self,
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
            let mut finish = pin!(run.wait(|progress| self.reached(segment, &progress)));
            let wish = tokio::select! {
                // Requests first: a run that ends at the same moment must not hide a stop.
                biased;
                wish = inbox.wish() => Ok(wish),
                never = self.follow_pace(segment) => match never {},
                ran = &mut finish => Err(ran),
            };
            match wish {
                Err(Ok(_)) => comes_to_end(),
                Err(Err(error)) => End::Failed(error),
                // Waits for the run's last report: a dropped run reports nothing.
                Ok(Wish::Stop) => {
                    let stop = self.arm.stop();
                    let _ = tokio::join!(stop, timeout(GIVE_UP, &mut finish));
                    End::Stopped
                }
                Ok(Wish::Pause) => {
                    self.shared.enter(JobState::Pausing);
                    let stop = self.arm.stop_gentle();
                    let (stopped, ran) = tokio::join!(stop, timeout(GIVE_UP, &mut finish));
                    match (stopped, ran) {
                        // The run ended before the stop reached it.
                        (_, Ok(Ok(_))) => comes_to_end(),
                        (Err(error), _) => End::Failed(error),
                        (_, Ok(Err(error))) if !self.is_own_stop(segment, &error) => {
                            End::Failed(error)
                        }
                        // Ended by the stop of this pause, or too slow to report: the arm is asked
                        // next.
                        _ => End::Paused,
                    }
                }
            }
        };
        let ran = run.ran();
        drop(run);
        let mut track = self.track();
        track
            .counter
            .note(ran.commands, ran.last.map_or(0, |last| last.0));
        drop(track);
        let progress = self.shared.progress();
        let reached = match (&end, pause) {
            (End::AtPause, Some(step)) => {
                let steps = step.saturating_sub(rest.from());
                Some((step, self.pace().left(&segment.timetable, steps)))
            }
            (End::Done, _) => self.steps().map(|steps| (steps, Some(Duration::ZERO))),
            _ => None,
        };
        let progress = match reached {
            Some((step, left)) => JobProgress {
                step,
                left,
                silent: Duration::ZERO,
                ..progress
            },
            None => progress,
        };
        self.shared.reach(progress);
        self.shared.tell(JobEvent::Progress(progress));
        (ran, end)
    }

    /// True if the run was ended by the queue stop of a pause, and by nothing else.
    fn is_own_stop(&self, segment: &Segment, error: &Error) -> bool {
        error.kind() == ErrorKind::Closed && self.arm.stops() == segment.stops
    }

    /// Records what was sent and finished.
    fn reached(&self, segment: &Segment, progress: &Progress) {
        let mut track = self.track();
        let from = track.from();
        track.counter.note(progress.sent, progress.last.0);
        let finished = from + track.counter.finished(progress.current.0).least;
        let index = track
            .counter
            .last()
            .map(|(index, steps)| (index, from + steps));
        let clock = segment.begun.clock_at_least();
        track.reached(finished, index, clock, progress.current.0);
        let now = self.progress(finished, segment, progress.silent);
        self.shared.reach(now);
        if track.told.is_none_or(|told| told.elapsed() >= TELL) {
            track.told = Some(Instant::now());
            self.shared.tell(JobEvent::Progress(now));
        }
    }

    fn progress(&self, step: u64, segment: &Segment, silent: Duration) -> JobProgress {
        let iteration = self.spec.program.plan().steps.len().max(1) as u64;
        let iterations = self.spec.program.iterations().unwrap_or(u64::MAX);
        JobProgress {
            step,
            steps: self.steps(),
            iteration: (step / iteration).saturating_add(1).min(iterations.max(1)),
            left: self
                .pace()
                .left(&segment.timetable, step.saturating_sub(segment.rest.from())),
            silent,
        }
    }
}
