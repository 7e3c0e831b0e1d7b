//! The engine: one job from its check to its end.
//!
//! A job is a task that owns an [`Engine`] and an [`Inbox`]. It checks (`start_check`), then runs
//! one [`Segment`] after another; a segment ends at a pause, a stop, an error or the end of the
//! program. `tracker` counts what is finished and writes the journal, `pace` changes the speed
//! between two commands, `early_end` handles an early end. Every long wait also listens to the
//! inbox, so a stop is never delayed by the step in progress.

mod burn;
mod early_end;
mod inbox;
mod pace;
mod pause;
mod segment;
mod start_check;
mod tracker;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician::commands::{DeviceTime, Pose};
use magician::message;
use magician::{Arm, Error, ErrorCode, Ran, RunOptions, SettingsBackup};
use magician_program::Action;
use tokio::time::Instant;

pub use self::burn::MIN_REPORTED_OVERLAP;
use self::inbox::{Inbox, Stopped};
use self::pace::Pace;
use self::segment::Segment;
use self::tracker::ProgressTracker;
use crate::error::{Fault, JobError, PauseError};
use crate::event::{FinalState, JobState, JobSummary};
use crate::handle::{JobHandle, LaserUse, Shared};
use crate::journal::Journal;
use crate::spec::{JobSpec, Start};

/// Entry point of the engine; [`start`](Self::start) runs a program as a job.
#[derive(Debug)]
pub struct Job;

impl Job {
    /// Starts a job on the current tokio runtime and returns at once. [`JobHandle`] documents what
    /// happens when handles are dropped.
    ///
    /// The job holds a clone of `arm`: the connection lasts as long as the job, and its calls may
    /// switch the laser on if those of this handle may.
    ///
    /// # Panics
    /// Panics outside of a tokio runtime.
    pub fn start(arm: &Arm, spec: JobSpec, journal: impl Journal + 'static) -> JobHandle {
        let outlives_process = spec
            .outlives_process
            .unwrap_or_else(|| !arm.front_end().is_in_process());
        let burns = spec
            .program
            .plan()
            .commands()
            .any(|command| arm.laser().burns(&command));
        // A burn with a fixed power needs the speed it was made for; so does a laser outside of
        // path commands.
        let steps = spec.program.plan().steps.iter();
        let needs_speed = burns && { steps }.any(|step| {
            let follows = step.follows_speed && matches!(step.action, Action::Burn { .. });
            !follows
                && step
                    .action
                    .command()
                    .is_some_and(|command| arm.laser().burns(&command))
        });
        let laser_use = LaserUse { burns, needs_speed };
        let (handle, shared, requests) =
            JobHandle::new(spec.name.clone(), spec.origin.clone(), laser_use);
        let engine = Engine {
            stops: arm.stops(),
            index_may_skip: spec.index_may_skip
                || spec.program.plan().burns()
                || !arm.front_end().keeps_order(),
            burns,
            needs_speed,
            outlives_process,
            arm: arm.clone(),
            tracker: Mutex::new(ProgressTracker::new(
                Box::new(journal),
                &spec,
                outlives_process,
                Arc::clone(&shared),
            )),
            pace: Mutex::default(),
            spec,
            shared: Arc::clone(&shared),
        };
        let ends = EndGuard(shared);
        tokio::spawn(async move {
            // Move the guard into the task, so that it drops with the task.
            let ends = ends;
            let mut inbox = Inbox::new(requests, engine.arm.front_end().end_notice());
            let mut outcome = engine.run_to_end(&mut inbox).await;
            if let Err(error) = &mut outcome {
                error.storage_error = engine.tracker().storage_error.clone();
            }
            engine.restore_settings(&outcome).await;
            inbox.answer_pauses(|| Err(PauseError::Ended));
            // The drop comes before the end is reported: the waiting process may exit at once.
            drop(engine);
            ends.0.end(outcome.map(Arc::new).map_err(Arc::new));
        });
        handle
    }
}

/// Guard that ends the wait for a job whose task is gone because its runtime has ended.
struct EndGuard(Arc<Shared>);

impl Drop for EndGuard {
    fn drop(&mut self) {
        if self.0.state() != JobState::Ended {
            let gone = Error::new(
                ErrorCode::Stopped,
                message!("the job was dropped before its end"),
            );
            self.0.end(Err(Arc::new(JobError::from(gone))));
        }
    }
}

/// State of the engine for one job.
struct Engine {
    arm: Arm,
    spec: JobSpec,
    shared: Arc<Shared>,
    tracker: Mutex<ProgressTracker>,
    pace: Mutex<Pace>,
    /// Stops of the arm before the job began, which are not the job's.
    stops: u64,
    /// True if the arm's index may skip numbers: the driver may insert commands between the
    /// program's, and a line that duplicates frames adds some.
    index_may_skip: bool,
    /// True if the job may switch a laser on.
    burns: bool,
    /// True if the power of something it burns is right for one speed only.
    needs_speed: bool,
    outlives_process: bool,
}

/// Start of a job by the host's clock and by the arm's, ms.
#[derive(Clone, Copy)]
struct StartTime {
    host: Instant,
    clock: u32,
}

impl Engine {
    async fn run_to_end(&self, inbox: &mut Inbox) -> Result<JobSummary, JobError> {
        let resumes = self.spec.start == Start::Resume;
        let look = async {
            let (from, within) = self.prepare_arm().await?;
            self.check_rest(from, within, resumes).await
        };
        let found = match inbox.unless_stopped(look).await {
            Ok(found) => found?,
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        let (started, from) = (found.started, found.rest.from());
        let (found, stops) = if inbox.wants_pause() {
            let found = Box::pin(self.pause_before_start(inbox, found)).await?;
            // Stops during the pause were not aimed at this job.
            (found, self.arm.stops())
        } else {
            (found, self.stops)
        };
        *self.pace() = Pace::new(found.rest.changes());
        let before = async {
            if let Some(saved) = &self.spec.saved {
                let before = SettingsBackup::read(&self.arm, found.rest.changes()).await?;
                saved.save_all(&self.arm, before).await;
            }
            Ok::<_, Error>(())
        };
        match inbox.unless_stopped(before).await {
            Ok(saved) => saved?,
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        }
        let report = found.report;
        let mut segment = Segment::new(found.rest, found.timetable, found.started, self.spec.keep);
        segment.stops = stops;
        segment.rest_index = found.rest_index;
        let mut all = Ran::default();
        loop {
            let (ran, end) = Box::pin(self.run(&segment, inbox)).await;
            add_run(&mut all, ran);
            segment = match end {
                segment::SegmentEnd::Completed => break,
                segment::SegmentEnd::Failed(error) => {
                    return Err(Box::pin(self.end_after_failure(inbox, error)).await);
                }
                segment::SegmentEnd::Stopped => {
                    return Err(Box::pin(self.end_after_stop(inbox, None)).await);
                }
                segment::SegmentEnd::AtPause => {
                    match Box::pin(self.pause_at_step(inbox, &segment.rest)).await? {
                        Some(segment) => segment,
                        None => break,
                    }
                }
                segment::SegmentEnd::Paused => match Box::pin(self.pause(inbox)).await? {
                    Some(segment) => segment,
                    None => break,
                },
            };
        }
        self.shared.enter(JobState::Ending);
        inbox.answer_pauses(|| Err(PauseError::Ending));
        Box::pin(self.finish(inbox, started, from, all, report)).await
    }

    /// Ends a job whose steps are all done: pen up, tool parked, settings restored.
    async fn finish(
        &self,
        inbox: &mut Inbox,
        started: StartTime,
        from: u64,
        ran: Ran,
        report: magician_program::Report,
    ) -> Result<JobSummary, JobError> {
        // The commands after the run get the run's patience: a slow arm must not fail here.
        let arm = &self.arm.front_end().patient(RunOptions::default().patience);
        let ends = async {
            let seconds = started.seconds(arm).await?;
            // All steps are done: a failure from here on must not make them resumable.
            self.tracker().remove();
            self.restore_full_speed(arm).await?;
            let end = self.finish_tool(arm).await?;
            if let Some(saved) = &self.spec.saved {
                saved.restore(arm).await?;
            }
            Ok::<_, Error>((seconds, end))
        };
        match inbox.unless_stopped(ends).await {
            Err(Stopped) => {
                let mut error = self.end_after_stop(inbox, None).await;
                error.all_done = true;
                Err(error)
            }
            Ok(Err(error)) => {
                let mut error = self.end_after_failure(inbox, error).await;
                error.all_done = true;
                Err(error)
            }
            Ok(Ok((seconds, end))) => {
                let steps = self.spec.program.steps().unwrap_or_default();
                Ok(JobSummary {
                    steps: steps.saturating_sub(from),
                    from,
                    ran,
                    seconds,
                    report,
                    end,
                })
            }
        }
    }

    /// Lifts the pen as far as the program has not, and parks the tool.
    async fn finish_tool(&self, arm: &Arm) -> Result<Option<FinalState>, Error> {
        let (plan, ending) = (self.spec.program.plan(), &self.spec.ending);
        if !ending.draws(plan) && ending.park.is_none() {
            return Ok(None);
        }
        let mut pose = arm.get::<Pose>().await?;
        let up = ending.after_done(plan, [pose.x, pose.y, pose.z].map(f64::from));
        // From here on a stop lifts the pen by this much only.
        self.tracker().lift = up;
        if up.is_some() || ending.park.is_some() {
            self.save_speed().await;
        }
        if let Some(up) = up {
            pose = arm.lift(up).await?.pose;
            self.tracker().lift = None;
        }
        if let Some(place) = ending.park {
            pose = arm.park(place).await?;
        }
        Ok(Some(FinalState {
            pose,
            pen_is_up: ending.draws(plan).then_some(!ending.stay),
            parked: ending.park.is_some(),
        }))
    }

    fn tracker(&self) -> MutexGuard<'_, ProgressTracker> {
        self.tracker.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pace(&self) -> MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of all steps; `None` for an endless program.
    fn steps(&self) -> Option<u64> {
        self.spec.program.steps()
    }
}

/// Adds the commands of a segment to those of the job.
fn add_run(all: &mut Ran, ran: Ran) {
    all.commands += ran.commands;
    all.first = all.first.or(ran.first);
    all.last = ran.last.or(all.last);
}

impl StartTime {
    async fn now(arm: &Arm) -> Result<Self, Error> {
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        let host = Instant::now();
        Ok(Self { host, clock })
    }

    /// Lower bound of the arm's clock now, ms. The arm's clock may run an eighth slower than the
    /// host's.
    fn clock_at_least(self) -> u32 {
        let elapsed = u32::try_from(self.host.elapsed().as_millis()).unwrap_or(u32::MAX);
        self.clock.saturating_add(elapsed - elapsed / 8)
    }

    /// Seconds since then by the arm's clock.
    async fn seconds(self, arm: &Arm) -> Result<f64, Error> {
        let clock = arm.get::<DeviceTime>().await?.g_systick;
        Ok(f64::from(clock.wrapping_sub(self.clock)) / 1000.0)
    }
}

impl From<Fault> for JobError {
    fn from(fault: Fault) -> Self {
        Self::new(fault)
    }
}
