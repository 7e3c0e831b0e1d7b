//! End of a job that stops or fails early.
//!
//! The order is the same for all causes: stop the arm, read where it stands, write the checkpoint,
//! then move. The checkpoint comes first because the lift of the pen counts among the arm's queued
//! commands and would shift its index. Every phase has a deadline, so that a silent arm cannot hold
//! the caller; settings that the arm does not take in time are left to the next program.

use std::sync::atomic::Ordering;
use std::time::Duration;

use magician::commands::{DeviceTime, Pose, PtpCommonParams};
use magician::{Error, ErrorKind};
use magician_program::RemainingProgram;
use magician_program::resume::{ResumePoint, StepRange, resume_point_at};
use magician_protocol::Readable;
use tokio::time::timeout;

use super::Engine;
use super::burn::{laser_off_place, resume_in_last_step};
use super::inbox::{Inbox, Stopped};
use super::pause::{PausedState, resume_by_pose};
use super::tracker::ProgressTracker;
use crate::error::{Fault, JobError, PauseError, PenLift, StopPosition};
use crate::event::{JobEvent, JobState, JobSummary, JobWait};
use crate::saved::SavedSettings;

/// Deadline for the arm to report its state, and to take its settings.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);
/// Deadline after a second stop, whose caller waits. A healthy line needs a tenth of it.
const SECOND_STOP_TIMEOUT: Duration = Duration::from_millis(800);
/// Deadline for the pen to go up.
const LIFT_TIMEOUT: Duration = Duration::from_secs(4);
/// Longest wait for a line to come back that broke while the laser burnt.
const RECONNECT_TIMEOUT: Duration = Duration::from_secs(10);

impl Engine {
    /// Ends a job that was asked to stop.
    ///
    /// Writes the checkpoint before anything moves, because the lift of the pen counts among the
    /// arm's commands.
    pub(super) async fn end_after_stop(&self, inbox: &mut Inbox, paused: PausedState) -> JobError {
        self.shared.enter(JobState::Stopping);
        inbox.answer_pauses(|| Err(PauseError::Ending));
        let mut error = JobError::new(Fault::Stopped { twice: false });
        error.stopped_by_line_end = inbox.was_stopped_by_line();
        if error.stopped_by_line_end && paused.is_none() && self.has_sent_nothing() {
            // Another client's run may be about to finish on the arm: a stop would drop the lift of
            // its pen.
            return error;
        }
        let ends = self.stop_and_clean_up(&mut error, paused);
        if inbox.unless_stopped(ends).await.is_ok() {
            return error;
        }
        // A second stop: nothing moves after it.
        error.fault = Fault::Stopped { twice: true };
        error.resume_place = error.resume_place.or(self.resume_place());
        error.pose = match timeout(SECOND_STOP_TIMEOUT, self.stop_and_read()).await {
            Ok(Ok((stopped_at, _))) => {
                self.write_checkpoint(false, Some(&stopped_at));
                error.resume_place = error.resume_place.or(self.resume_place());
                Some(stopped_at.pose)
            }
            _ => None,
        };
        error
    }

    /// True if the arm has received nothing of the job: no command and no setting.
    fn has_sent_nothing(&self) -> bool {
        let saved = self.spec.saved.as_ref();
        self.resume_place().is_none()
            && self.tracker().pulled == 0
            && saved.is_none_or(SavedSettings::is_empty)
    }

    async fn stop_and_clean_up(&self, error: &mut JobError, paused: PausedState) {
        match timeout(ANSWER_TIMEOUT, self.stop_and_read()).await {
            Ok(Ok((stopped_at, _))) => error.stopped_at = Some(stopped_at),
            Ok(Err(why)) => error.unconfirmed = Some(why),
            // Timed out: neither a pose nor an error is known.
            Err(_) => {}
        }
        self.write_checkpoint(false, error.stopped_at.as_ref());
        error.resume_place = self.resume_place();
        let Some(stopped_at) = error.stopped_at else {
            return;
        };
        error.pose = Some(stopped_at.pose);
        // The result is ignored: an arm that refuses these settings also refuses the lift or the
        // restore below, which report it.
        let _ = timeout(ANSWER_TIMEOUT, self.restore_full_speed(&self.arm)).await;
        error.lift = match paused {
            Some((_, lift)) => lift,
            None => match timeout(LIFT_TIMEOUT, self.lift(&stopped_at)).await {
                Ok(lift) => lift,
                Err(_) => PenLift::TimedOut,
            },
        };
        let last = async {
            if let Some(saved) = &self.spec.saved {
                saved.restore(&self.arm).await?;
            }
            self.arm.get::<Pose>().await
        };
        match timeout(ANSWER_TIMEOUT, last).await {
            Ok(Ok(pose)) => error.pose = Some(pose),
            Ok(Err(why)) => error.unconfirmed = Some(why),
            // Timed out after the lift: the pose read before it no longer holds.
            Err(_) => error.pose = None,
        }
    }

    /// Restores the settings that the job still owes the arm, however it ended: after a second
    /// stop, an error or a slow arm some are outstanding. Settings that the arm does not take in
    /// time are left to the next program.
    pub(super) async fn restore_settings(&self, outcome: &Result<JobSummary, JobError>) {
        let Some(saved) = self.spec.saved.as_ref().filter(|saved| !saved.is_empty()) else {
            return;
        };
        // With a known pose the arm was stopped; otherwise the restore has to stop it first.
        let stands = matches!(outcome, Err(error) if error.pose.is_some());
        let restoring = async {
            if stands {
                drop(saved.restore(&self.arm).await)
            } else {
                saved.restore_after_failure(&self.arm).await
            }
        };
        let _ = timeout(SECOND_STOP_TIMEOUT, restoring).await;
        // Settings not taken by the arm stay in the file, for the next program.
        saved.leave();
    }

    /// Ends a job that has failed: stops the arm and reads its progress, if the arm answers.
    pub(super) async fn end_after_failure(&self, inbox: &mut Inbox, error: Error) -> JobError {
        inbox.answer_pauses(|| Err(PauseError::Ended));
        let mut failed = JobError::from(error);
        let ends = self.clean_up_after_failure(&mut failed);
        if let Err(Stopped) = inbox.unless_stopped(ends).await {
            return self.end_after_stop(inbox, None).await;
        }
        failed
    }

    async fn clean_up_after_failure(&self, failed: &mut JobError) {
        let Fault::Arm(error) = &failed.fault else {
            return;
        };
        let kind = error.kind();
        let gone = kind == ErrorKind::Port;
        // A line that comes back is first used to switch the laser off, so a job that burns waits
        // for it.
        let gone = gone && !(self.spec.program.plan().burns() && self.wait_for_reconnect().await);
        let asked = if gone {
            None
        } else {
            timeout(ANSWER_TIMEOUT, self.stop_and_read())
                .await
                .ok()
                .and_then(Result::ok)
        };
        let uncertain = kind == ErrorKind::Uncertain;
        if let Some((stopped_at, clock)) = &asked
            && uncertain
            && self.was_reset(stopped_at, *clock)
        {
            let mut tracker = self.tracker();
            // After a reset the arm's index no longer counts this job's commands.
            if tracker.open && tracker.pulled > 0 {
                tracker.record_reset();
            }
            drop(tracker);
            failed.resume_place = self.resume_place();
        } else {
            let stopped_at = asked.map(|(stopped_at, _)| stopped_at);
            failed.stopped_at = stopped_at;
            failed.pose = stopped_at.map(|stopped_at| stopped_at.pose);
            self.write_checkpoint(uncertain, stopped_at.as_ref());
            failed.resume_place = self.resume_place();
            // After an alarm or another client's stop nothing may move, not even a pen.
            if let Some(stopped_at) = stopped_at.filter(|_| kind.lifts()) {
                let _ = timeout(ANSWER_TIMEOUT, self.restore_full_speed(&self.arm)).await;
                failed.lift = self.lift(&stopped_at).await;
            }
        }
        if let Some(saved) = &self.spec.saved {
            saved.restore_after_failure(&self.arm).await;
        }
    }

    /// Stops the arm; returns its pose, index and clock (ms).
    async fn stop_and_read(&self) -> Result<(StopPosition, u32), Error> {
        self.arm.stop().await?;
        let pose = self.arm.get::<Pose>().await?;
        let index = self.arm.queue().current_index().await?.0;
        let clock = self.arm.get::<DeviceTime>().await?.g_systick;
        Ok((StopPosition { pose, index }, clock))
    }

    /// Lifts the pen of a drawing that has begun. Tries once, whatever the outcome.
    pub(super) async fn lift(&self, stopped_at: &StopPosition) -> PenLift {
        if self.shared.halted.load(Ordering::SeqCst) {
            return PenLift::KeptDown;
        }
        let height = {
            let tracker = self.tracker();
            let ProgressTracker {
                remaining, counter, ..
            } = &*tracker;
            let moved = |rest: &RemainingProgram| {
                rest.has_moved(counter, stopped_at.index, &stopped_at.pose)
            };
            // A pen that moved before the first command was not moved by this job.
            let moved = tracker.pulled > 0 && remaining.as_ref().is_some_and(moved);
            if !moved {
                return PenLift::None;
            }
            tracker.lift
        };
        let Some(height) = height else {
            let ending = &self.spec.ending;
            return if ending.stay && ending.draws(self.spec.program.plan()) {
                PenLift::KeptDown
            } else {
                PenLift::None
            };
        };
        self.save_speed().await;
        let lifted = self.arm.lift(height).await;
        // Cleared only now: if a stop interrupts the lift of a pause, the pen still has to go up.
        self.tracker().lift = None;
        match lifted {
            Ok(lifted) => PenLift::Lifted(lifted),
            Err(error) => PenLift::Failed(error.into()),
        }
    }

    /// Saves the speed of moves for the restore. The lift sets its own speed, which the driver
    /// restores, unless a stop drops the lift.
    pub(super) async fn save_speed(&self) {
        let Some(saved) = &self.spec.saved else {
            return;
        };
        if !saved.has(PtpCommonParams::ROW.id)
            && let Ok(speed) = self.arm.get::<PtpCommonParams>().await
        {
            saved.save(&self.arm, speed).await;
        }
    }

    /// Waits up to [`RECONNECT_TIMEOUT`] for a line that broke while the laser burnt; true if it is
    /// back.
    async fn wait_for_reconnect(&self) -> bool {
        // The driver keeps this request and sends it as soon as the line is back.
        let _ = self.arm.stopper().request_stop();
        self.shared.emit(JobEvent::Wait(JobWait::Line));
        let back = timeout(RECONNECT_TIMEOUT, self.arm.reconnected()).await;
        self.shared.emit(JobEvent::Wait(JobWait::Over));
        matches!(back, Ok(Ok(())))
    }

    /// True if the arm was reset since the job began: its index then says nothing about the job.
    fn was_reset(&self, stopped_at: &StopPosition, clock: u32) -> bool {
        let tracker = self.tracker();
        if !tracker.open {
            return false;
        }
        let most = tracker.from() + tracker.counter.finished(stopped_at.index).most;
        // A clock or a count below an earlier observation means that the arm has restarted.
        clock < tracker.checkpoint.clock || most < tracker.checkpoint.finished
    }

    /// Writes the checkpoint of a job that ended early, unless that is done already.
    fn write_checkpoint(&self, uncertain: bool, stopped_at: Option<&StopPosition>) {
        let mut tracker = self.tracker();
        if !tracker.open || tracker.pulled == 0 {
            return;
        }
        let Some(stopped_at) = stopped_at else {
            // The arm could not be asked: the job that resumes reads its index instead.
            tracker.record_unknown_end();
            return;
        };
        let span = if uncertain {
            tracker.counter.certain(stopped_at.index)
        } else {
            tracker.counter.finished(stopped_at.index)
        };
        let from = tracker.from();
        let (least, most) = (from + span.least, from + span.most);
        if let (true, Some(rest)) = (self.burns, &tracker.remaining)
            && let Some(dark) = self.arm.laser().lights_out()
            && let Some(place) = laser_off_place(rest, (least, most), &dark, &stopped_at.pose)
        {
            return tracker.record_burn_end(place);
        }
        // If the index counts other commands too, the pose decides, unless a command may have run
        // twice.
        if let (true, false, Some(rest)) = (least < most, uncertain, &tracker.remaining)
            && let Some((resume_point, (steps, within))) =
                resume_by_pose(rest, (least, most), &stopped_at.pose).or_else(|| {
                    let burns = self.burns;
                    burns.then(|| resume_in_last_step(rest, least, &stopped_at.pose))?
                })
        {
            let within = within.map(|place| (steps, place));
            return tracker.record_end_at(resume_point, within, (self.burns, &stopped_at.pose));
        }
        // During the first step the index says nothing about its progress, but the pose does.
        let first = tracker
            .remaining
            .as_ref()
            .filter(|_| (least, most) == (from, from));
        if let (Some(rest), true, false) = (first, self.burns, tracker.at_first)
            && let Some(place) = rest.from_start_position(&stopped_at.pose)
        {
            return tracker.record_burn_end(place);
        }
        let is_within_first = tracker.at_first
            && first.is_some_and(|rest| {
                let place = rest.resume_place(ResumePoint::Again(from), &stopped_at.pose);
                place.is_some_and(|(_, at)| at.is_some())
            });
        let resume_point = if is_within_first {
            ResumePoint::Again(from)
        } else if least == most {
            resume_point_at(least, |steps| {
                let rest = tracker.remaining.as_ref()?;
                rest.stands_after(steps, &stopped_at.pose, true)
            })
        } else {
            ResumePoint::Doubt(StepRange { least, most })
        };
        let goes_on = (tracker.remaining.as_ref())
            .and_then(|rest| rest.resume_place(resume_point, &stopped_at.pose));
        let (resume_point, within) = match goes_on {
            Some((steps, Some(place))) => (ResumePoint::Again(steps), Some((steps, place))),
            // No position within a step: resume at the beginning of one.
            _ => (resume_point, None),
        };
        tracker.record_end_at(resume_point, within, (self.burns, &stopped_at.pose));
    }
}
