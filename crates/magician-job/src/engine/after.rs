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

use super::Work;
use super::burn::{cut_short, goes_on_dark};
use super::inbox::{Inbox, Stopped};
use super::pause::{AtPause, by_pose};
use super::track::Track;
use crate::error::{Fault, JobError, PauseError, PenLift, Stood};
use crate::event::{Done, JobEvent, JobState, Waits};
use crate::saved::SavedSettings;

/// Deadline for the arm to report its state, and to take its settings.
const AFTERMATH: Duration = Duration::from_secs(3);
/// Deadline after a second stop, whose caller waits. A healthy line needs a tenth of it.
const AT_ONCE: Duration = Duration::from_millis(800);
/// Deadline for the pen to go up.
const LIFT: Duration = Duration::from_secs(4);
/// Longest wait for a line to come back that broke while the laser burnt.
const BACK: Duration = Duration::from_secs(10);

impl Work {
    /// Ends a job that was asked to stop.
    ///
    /// Writes the checkpoint before anything moves, because the lift of the pen counts among the
    /// arm's commands.
    pub(super) async fn stopped(&self, inbox: &mut Inbox, paused: AtPause) -> JobError {
        self.shared.enter(JobState::Stopping);
        inbox.answer_pauses(|| Err(PauseError::Ending));
        let mut error = JobError::new(Fault::Stopped { twice: false });
        error.line_ends = inbox.line_ends();
        if error.line_ends && paused.is_none() && self.has_done_nothing() {
            // Another client's run may be about to finish on the arm: a stop would drop the lift of
            // its pen.
            return error;
        }
        let ends = self.comes_to_a_stop(&mut error, paused);
        if inbox.unless_stopped(ends).await.is_ok() {
            return error;
        }
        // A second stop: nothing moves after it.
        error.fault = Fault::Stopped { twice: true };
        error.left = error.left.or(self.left());
        error.pose = match timeout(AT_ONCE, self.stand()).await {
            Ok(Ok((stood, _))) => {
                self.keep(false, Some(&stood));
                error.left = error.left.or(self.left());
                Some(stood.pose)
            }
            _ => None,
        };
        error
    }

    /// True if the arm has received nothing of the job: no command and no setting.
    fn has_done_nothing(&self) -> bool {
        let saved = self.spec.saved.as_ref();
        self.left().is_none()
            && self.track().pulled == 0
            && saved.is_none_or(SavedSettings::is_empty)
    }

    async fn comes_to_a_stop(&self, error: &mut JobError, paused: AtPause) {
        match timeout(AFTERMATH, self.stand()).await {
            Ok(Ok((stood, _))) => error.stood = Some(stood),
            Ok(Err(why)) => error.unconfirmed = Some(why),
            // Timed out: neither a pose nor an error is known.
            Err(_) => {}
        }
        self.keep(false, error.stood.as_ref());
        error.left = self.left();
        let Some(stood) = error.stood else {
            return;
        };
        error.pose = Some(stood.pose);
        // The result is ignored: an arm that refuses these settings also refuses the lift or the
        // restore below, which report it.
        let _ = timeout(AFTERMATH, self.leaves_pace(&self.arm)).await;
        error.lift = match paused {
            Some((_, lift)) => lift,
            None => match timeout(LIFT, self.lift(&stood)).await {
                Ok(lift) => lift,
                Err(_) => PenLift::Late,
            },
        };
        let last = async {
            if let Some(saved) = &self.spec.saved {
                saved.restore(&self.arm).await?;
            }
            self.arm.get::<Pose>().await
        };
        match timeout(AFTERMATH, last).await {
            Ok(Ok(pose)) => error.pose = Some(pose),
            Ok(Err(why)) => error.unconfirmed = Some(why),
            // Timed out after the lift: the pose read before it no longer holds.
            Err(_) => error.pose = None,
        }
    }

    /// Restores the settings that the job still owes the arm, however it ended: after a second
    /// stop, an error or a slow arm some are outstanding. Settings that the arm does not take in
    /// time are left to the next program.
    pub(super) async fn restores_settings(&self, outcome: &Result<Done, JobError>) {
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
        let _ = timeout(AT_ONCE, restoring).await;
        // Settings not taken by the arm stay in the file, for the next program.
        saved.leave();
    }

    /// Ends a job that has failed: stops the arm and reads its progress, if the arm answers.
    pub(super) async fn fails(&self, inbox: &mut Inbox, error: Error) -> JobError {
        inbox.answer_pauses(|| Err(PauseError::Ended));
        let mut failed = JobError::from(error);
        let ends = self.comes_to_an_end(&mut failed);
        if let Err(Stopped) = inbox.unless_stopped(ends).await {
            return self.stopped(inbox, None).await;
        }
        failed
    }

    async fn comes_to_an_end(&self, failed: &mut JobError) {
        let Fault::Arm(error) = &failed.fault else {
            return;
        };
        let kind = error.kind();
        let gone = kind == ErrorKind::Port;
        // A line that comes back is first used to switch the laser off, so a job that burns waits
        // for it.
        let gone = gone && !(self.spec.program.plan().burns() && self.is_back().await);
        let asked = if gone {
            None
        } else {
            timeout(AFTERMATH, self.stand())
                .await
                .ok()
                .and_then(Result::ok)
        };
        let uncertain = kind == ErrorKind::Uncertain;
        if let Some((stood, clock)) = &asked
            && uncertain
            && self.was_reset(stood, *clock)
        {
            let mut track = self.track();
            // After a reset the arm's index no longer counts this job's commands.
            if track.open && track.pulled > 0 {
                track.is_forgotten();
            }
            drop(track);
            failed.left = self.left();
        } else {
            let stood = asked.map(|(stood, _)| stood);
            failed.stood = stood;
            failed.pose = stood.map(|stood| stood.pose);
            self.keep(uncertain, stood.as_ref());
            failed.left = self.left();
            // After an alarm or another client's stop nothing may move, not even a pen.
            if let Some(stood) = stood.filter(|_| kind.lifts()) {
                let _ = timeout(AFTERMATH, self.leaves_pace(&self.arm)).await;
                failed.lift = self.lift(&stood).await;
            }
        }
        if let Some(saved) = &self.spec.saved {
            saved.restore_after_failure(&self.arm).await;
        }
    }

    /// Stops the arm; returns its pose, index and clock (ms).
    async fn stand(&self) -> Result<(Stood, u32), Error> {
        self.arm.stop().await?;
        let pose = self.arm.get::<Pose>().await?;
        let index = self.arm.queue().current_index().await?.0;
        let clock = self.arm.get::<DeviceTime>().await?.g_systick;
        Ok((Stood { pose, index }, clock))
    }

    /// Lifts the pen of a drawing that has begun. Tries once, whatever the outcome.
    pub(super) async fn lift(&self, stood: &Stood) -> PenLift {
        if self.shared.halted.load(Ordering::SeqCst) {
            return PenLift::Stays;
        }
        let height = {
            let track = self.track();
            let Track { rest, counter, .. } = &*track;
            let moved = |rest: &RemainingProgram| rest.has_moved(counter, stood.index, &stood.pose);
            // A pen that moved before the first command was not moved by this job.
            let moved = track.pulled > 0 && rest.as_ref().is_some_and(moved);
            if !moved {
                return PenLift::None;
            }
            track.lift
        };
        let Some(height) = height else {
            let ending = &self.spec.ending;
            return if ending.stay && ending.draws(self.spec.program.plan()) {
                PenLift::Stays
            } else {
                PenLift::None
            };
        };
        self.saves_speed().await;
        let lifted = self.arm.lift(height).await;
        // Cleared only now: if a stop interrupts the lift of a pause, the pen still has to go up.
        self.track().lift = None;
        match lifted {
            Ok(lifted) => PenLift::Lifted(lifted),
            Err(error) => PenLift::Failed(error.into()),
        }
    }

    /// Saves the speed of moves for the restore. The lift sets its own speed, which the driver
    /// restores, unless a stop drops the lift.
    pub(super) async fn saves_speed(&self) {
        let Some(saved) = &self.spec.saved else {
            return;
        };
        if !saved.has(PtpCommonParams::ROW.id)
            && let Ok(speed) = self.arm.get::<PtpCommonParams>().await
        {
            saved.save(&self.arm, speed).await;
        }
    }

    /// Waits up to [`BACK`] for a line that broke while the laser burnt; true if it is back.
    async fn is_back(&self) -> bool {
        // The driver keeps this request and sends it as soon as the line is back.
        let _ = self.arm.stopper().request_stop();
        self.shared.tell(JobEvent::Waits(Waits::Line));
        let back = timeout(BACK, self.arm.reconnected()).await;
        self.shared.tell(JobEvent::Waits(Waits::Nothing));
        matches!(back, Ok(Ok(())))
    }

    /// True if the arm was reset since the job began: its index then says nothing about the job.
    fn was_reset(&self, stood: &Stood, clock: u32) -> bool {
        let track = self.track();
        if !track.open {
            return false;
        }
        let most = track.from() + track.counter.finished(stood.index).most;
        // A clock or a count below an earlier observation means that the arm has restarted.
        clock < track.checkpoint.clock || most < track.checkpoint.finished
    }

    /// Writes the checkpoint of a job that ended early, unless that is done already.
    fn keep(&self, uncertain: bool, stood: Option<&Stood>) {
        let mut track = self.track();
        if !track.open || track.pulled == 0 {
            return;
        }
        let Some(stood) = stood else {
            // The arm could not be asked: the job that resumes reads its index instead.
            track.breaks_off();
            return;
        };
        let span = if uncertain {
            track.counter.certain(stood.index)
        } else {
            track.counter.finished(stood.index)
        };
        let from = track.from();
        let (least, most) = (from + span.least, from + span.most);
        if let (true, Some(rest)) = (self.burns, &track.rest)
            && let Some(dark) = self.arm.laser().lights_out()
            && let Some(place) = goes_on_dark(rest, (least, most), &dark, &stood.pose)
        {
            return track.ends_burning(place);
        }
        // If the index counts other commands too, the pose decides, unless a command may have run
        // twice.
        if let (true, false, Some(rest)) = (least < most, uncertain, &track.rest)
            && let Some((resume_point, (steps, within))) = by_pose(rest, (least, most), &stood.pose)
                .or_else(|| {
                    let burns = self.burns;
                    burns.then(|| cut_short(rest, least, &stood.pose))?
                })
        {
            let within = within.map(|place| (steps, place));
            return track.ends_at(resume_point, within, (self.burns, &stood.pose));
        }
        // During the first step the index says nothing about its progress, but the pose does.
        let first = track
            .rest
            .as_ref()
            .filter(|_| (least, most) == (from, from));
        if let (Some(rest), true, false) = (first, self.burns, track.at_first)
            && let Some(place) = rest.from_start_position(&stood.pose)
        {
            return track.ends_burning(place);
        }
        let is_within_first = track.at_first
            && first.is_some_and(|rest| {
                let place = rest.resume_place(ResumePoint::Again(from), &stood.pose);
                place.is_some_and(|(_, at)| at.is_some())
            });
        let resume_point = if is_within_first {
            ResumePoint::Again(from)
        } else if least == most {
            resume_point_at(least, |steps| {
                let rest = track.rest.as_ref()?;
                rest.stands_after(steps, &stood.pose, true)
            })
        } else {
            ResumePoint::Doubt(StepRange { least, most })
        };
        let goes_on =
            (track.rest.as_ref()).and_then(|rest| rest.resume_place(resume_point, &stood.pose));
        let (resume_point, within) = match goes_on {
            Some((steps, Some(place))) => (ResumePoint::Again(steps), Some((steps, place))),
            // No position within a step: resume at the beginning of one.
            _ => (resume_point, None),
        };
        track.ends_at(resume_point, within, (self.burns, &stood.pose));
    }
}
