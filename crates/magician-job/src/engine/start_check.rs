//! Checks before anything moves: readiness, place to begin at, and the check of the program.
//!
//! A resumed job has to find out how far the earlier one came. The checkpoint says what was handed
//! over, the arm's index how many commands it has finished, and its pose where it stands. The index
//! decides if nothing else counts on it; the pose decides where foreign commands are mixed in. If
//! neither is conclusive the job refuses with [`Fault::Doubt`] instead of guessing.

use std::time::Duration;

use magician::commands::{DeviceSn, DeviceTime, Pose};
use magician::preflight::{Guards, Preflight};
use magician::{Arm, Error, Set};
use magician_program::resume::{DoubtReason, ObservedProgress, ResumePoint, StepRange};
use magician_program::turns::Turns;
use magician_program::{Diagnostic, Program, RemainingProgram, Report, Timetable};
use tokio::time::{Instant, sleep};

use super::burn::{MIN_REPORTED_OVERLAP, laser_off_place, resume_in_last_step};
use super::pause::resume_by_pose;
use super::{Engine, StartTime};
use crate::background::{BackgroundTurns, run_in_background};
use crate::error::{Fault, JobError};
use crate::event::{JobEvent, JobWait, StartPlace};
use crate::journal::JournalKey;
use crate::saved::{Access, SavedSettings};
use crate::spec::Start;

/// Poll interval while the arm still moves: a choice between load on the line and delay.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Steps whose permissions are checked between two yields, so that a long program does not block
/// the runtime.
const STEPS_PER_YIELD: usize = 65_536;
/// Time after which a queue without progress is taken to be stuck. A choice: a longer wait command
/// in the queue looks the same and is refused too.
const STUCK_AFTER: Duration = Duration::from_secs(3);

/// Result of the checks before anything moves.
pub(super) struct StartCheck {
    pub(super) rest: RemainingProgram,
    pub(super) report: Report,
    pub(super) timetable: Timetable,
    pub(super) started: StartTime,
    /// Index of the arm if it is at rest, `None` otherwise.
    pub(super) rest_index: Option<u64>,
    /// Pose of the arm when it was checked.
    pub(super) pose: Pose,
}

impl Engine {
    /// Makes the arm ready and finds the place to begin at: number of finished steps, and the
    /// position within the next step.
    pub(super) async fn prepare_arm(&self) -> Result<(u64, Option<[f64; 3]>), JobError> {
        let (arm, spec) = (&self.arm, &self.spec);
        let program = &spec.program;
        // Refuse here what the driver would refuse only when the command goes out, in mid-program.
        for steps in program.plan().steps.chunks(STEPS_PER_YIELD) {
            let commands: Vec<Set> = steps
                .iter()
                .filter_map(|step| step.action.command())
                .collect();
            arm.permission().check(&commands)?;
            BackgroundTurns.give().await;
        }
        let resumes = spec.start == Start::Resume;
        if resumes && program.plan().burns() {
            // A run whose process died may have left the laser on. The pose is read at the same
            // instant: if the arm is moving, the burn is resumed from there.
            let (dark, _) = tokio::join!(arm.laser().switch_off(), arm.get::<Pose>());
            dark?;
            arm.stop_gentle().await?;
            // Wait before clearing: a Clear may cut the command in progress short, and the arm
            // would count it as finished.
            if !arm.stands().await? {
                self.shared.emit(JobEvent::Wait(JobWait::Queue));
                while !arm.stands().await? {
                    sleep(POLL_INTERVAL).await;
                }
                self.shared.emit(JobEvent::Wait(JobWait::Over));
            }
            // Commands of the dead run must not follow once the arm is started again.
            arm.queue().clear().await?;
        }
        self.check_ready().await?;
        let key = self.journal_key().await;
        self.tracker().open_journal(&key, self.index_may_skip);
        let place = match spec.start {
            Start::Step(step) => {
                self.report_unfinished().await?;
                (step, None)
            }
            Start::Resume => self.resume_start().await?,
        };
        if spec.depends_on_pose && program.depends_on_start(place.0) {
            return Err(Fault::UnknownStartPose.into());
        }
        // A program that homes first needs no homed arm. The query is made all the same, so that
        // the driver records the homing it will see.
        if program.homes_first(place.0) {
            arm.homing().is_homed().await?;
        } else {
            arm.homing().check().await?;
        }
        // Comes after the homing check: a surface can be measured only with a homed arm.
        if spec.assumes_surface && !arm.is_virtual() {
            return Err(Fault::Program(Diagnostic::unknown_surface()).into());
        }
        if spec.saved.is_some() {
            let settled = SavedSettings::recover(arm, Access::Sets).await;
            self.shared.emit(JobEvent::RecoveredSettings(settled));
        }
        if !spec.keep {
            // Starting an empty run refuses foreign commands in the queue. That error is clearer
            // than a check from an unknown start.
            arm.start([]).wait(|_| {}).await?;
        }
        Ok(place)
    }

    /// Reports an interrupted run of the same program that this job is about to forget.
    async fn report_unfinished(&self) -> Result<(), Error> {
        let left = self.tracker().journal.load();
        // A run that ended in order has reported its end itself.
        let cut_off = left
            .ok()
            .filter(|left| left.ended.is_none() && left.handed > 0);
        if let Some(left) = cut_off.filter(|_| self.outlives_process) {
            let seen = ObservedProgress {
                current: self.arm.queue().current_index().await?.0,
                clock: self.arm.get::<DeviceTime>().await?.g_systick,
            };
            let doubt = left.doubt(Some(seen), self.spec.program.numbering());
            // After a reset no source says how far the run came. Other doubts may be settled by the
            // pose.
            let reset = doubt.is_some_and(|doubt| doubt.why == DoubtReason::Reset);
            self.shared.emit(JobEvent::Unfinished {
                finished: left.finished,
                resumable: !reset,
            });
        }
        Ok(())
    }

    pub(super) async fn check_ready(&self) -> Result<(), Error> {
        let guards = Guards::default().require_homed(self.spec.require_homed);
        let first: Vec<Set> = self.spec.program.plan().commands().take(1).collect();
        self.arm.front_end().check_ready(&first, guards).await
    }

    /// Checks the rest of the program after `from` steps, from the current pose.
    pub(super) async fn check_rest(
        &self,
        from: u64,
        within: Option<[f64; 3]>,
        is_resume: bool,
    ) -> Result<StartCheck, JobError> {
        let started = StartTime::now(&self.arm).await?;
        let rest_index = rest_index(&self.arm).await?;
        let (rest, report, timetable) = self.checked_rest(from, within).await?;
        if self.spec.check && !report.is_good() {
            let (report, rest) = (Box::new(report), Box::new(rest));
            return Err(Fault::Refused { report, rest }.into());
        }
        self.spec.ending.check(&rest)?;
        {
            let mut tracker = self.tracker();
            tracker.begin(
                &rest,
                within,
                started.clock,
                rest_index,
                self.index_may_skip,
            );
            tracker.lift = self.spec.ending.after_stop(self.spec.program.plan());
        }
        if !is_resume && from > 0 {
            let starts = StartPlace {
                steps: from,
                within: within.is_some(),
                again: false,
                burnt_twice: 0.0,
                is_upper_bound: false,
                nothing_queued: false,
            };
            self.shared.emit(JobEvent::Start(starts));
        }
        Ok(StartCheck {
            pose: self.arm.get::<Pose>().await?,
            rest,
            report,
            timetable,
            started,
            rest_index,
        })
    }

    /// Returns the rest of the program, its check report and its timetable.
    ///
    /// Long programs take a while, so this runs beside the runtime's tasks, which serve other
    /// connections.
    pub(super) async fn checked_rest(
        &self,
        from: u64,
        within: Option<[f64; 3]>,
    ) -> Result<(RemainingProgram, Report, Timetable), JobError> {
        let start = self.arm.preflight_for(&self.spec.program.kinds()).await?;
        let program = self.spec.program.clone();
        let checked =
            run_in_background(async move { checked_rest(&program, from, within, start).await });
        Ok(checked.await??)
    }

    /// Key of the job's journal: program and arm.
    async fn journal_key(&self) -> JournalKey {
        // An arm may report no serial number; then its name identifies it.
        let serial = self.arm.get::<DeviceSn>().await;
        let serial = serial
            .map(|serial| serial.device_sn.to_string())
            .unwrap_or_default();
        let arm = match (self.outlives_process, serial.trim()) {
            // The serial number of an arm that ends with this process identifies nothing.
            (false, _) => "virtual",
            (true, "") => self.arm.name(),
            (true, serial) => serial,
        };
        let program = self.spec.program.key_in_turns(&BackgroundTurns).await;
        let mut key = JournalKey::new(program, arm);
        key.virtual_arm = self
            .arm
            .front_end()
            .virtual_number()
            .filter(|_| !self.outlives_process);
        key
    }

    /// Steps after which an earlier job of the same program is resumed, and the position within the
    /// next step unless that starts at its beginning.
    async fn resume_start(&self) -> Result<(u64, Option<[f64; 3]>), JobError> {
        let (arm, program) = (&self.arm, &self.spec.program);
        let left = self.tracker().journal.load();
        let checkpoint = left.map_err(|error| JobError::new(Fault::Journal(error)))?;
        if checkpoint.ended.is_none() {
            self.shared.emit(JobEvent::Wait(JobWait::Queue));
            let idle = self.wait_for_idle().await;
            self.shared.emit(JobEvent::Wait(JobWait::Over));
            idle?;
        }
        let seen = ObservedProgress {
            current: arm.queue().current_index().await?.0,
            clock: arm.get::<DeviceTime>().await?.g_systick,
        };
        let pose = arm.get::<Pose>().await?;
        let start = arm.preflight_for(&program.kinds()).await?;
        // Without the whole plan, the pose cannot be compared with it and the index alone decides.
        let whole = program.remaining(0, start).ok();
        let seen = self.outlives_process.then_some(seen);
        let resume_point = checkpoint.resume_point(seen, program.numbering(), |steps| {
            whole.as_ref()?.stands_after(steps, &pose, false)
        });
        // If the arm also counts commands outside the program, its pose may decide. Not before the
        // first motion of the program, because the position in which the arm began is no longer
        // known.
        let doubt = checkpoint.doubt(seen, program.numbering());
        let mixed = doubt.filter(|doubt| doubt.why == DoubtReason::Mixed);
        let told = mixed.zip(whole.as_ref()).and_then(|(doubt, whole)| {
            let StepRange { least, most } = doubt.span;
            let least = least.max(whole.first_motion()?);
            let found = (least <= most).then(|| resume_by_pose(whole, (least, most), &pose))?;
            let burns = program.plan().burns();
            found.or_else(|| burns.then(|| resume_in_last_step(whole, least, &pose))?)
        });
        let resume_point = told.map_or(resume_point, |(told, _)| told);
        // A run without a recorded end may have been stopped within a step. If the arm still stands
        // on that step's line, it continues from there.
        let stopped = matches!(resume_point, ResumePoint::Again(_)) && checkpoint.ended.is_none();
        let standing = whole.as_ref().filter(|_| stopped);
        let standing = standing.and_then(|whole| whole.goes_on(resume_point, &pose));
        let standing = standing.and_then(|(steps, place)| Some((steps, place?)));
        let burns = program.plan().burns() && checkpoint.ended.is_none();
        let burn = whole.as_ref().filter(|_| burns);
        let burn = burn.and_then(|whole| {
            let span = match resume_point {
                ResumePoint::After(steps) => (steps, steps),
                ResumePoint::Again(steps) => (steps + 1, steps + 1),
                ResumePoint::Doubt(_) => return None,
            };
            let dark = arm.laser().lights_out();
            dark.and_then(|dark| laser_off_place(whole, span, &dark, &pose))
                .or_else(|| whole.before_braking(resume_point, standing, &pose))
        });
        let (steps, within, kept_twice) = match (resume_point, standing, burn) {
            (_, _, Some(place)) => (place.steps, place.within, place.twice),
            (_, Some((steps, place)), None) => (steps, Some(place), 0.0),
            (ResumePoint::After(steps) | ResumePoint::Again(steps), None, None) => {
                (steps, checkpoint.place_after(steps), checkpoint.twice)
            }
            (ResumePoint::Doubt(span), None, None) => {
                let why = doubt.map_or(DoubtReason::Mixed, |doubt| doubt.why);
                return Err(Fault::Doubt { span, why }.into());
            }
        };
        let again =
            within.is_none() && kept_twice == 0.0 && matches!(resume_point, ResumePoint::Again(_));
        let (steps, within, burnt_twice) = match &whole {
            // The position within the step is unknown: as much as the whole step may be burnt
            // twice.
            Some(whole) if again => (steps, within, whole.burn_after(steps).unwrap_or(0.0)),
            Some(whole) => whole.overlapped((steps, within), self.spec.overlap),
            None => (steps, within, 0.0),
        };
        let burnt_twice = burnt_twice + kept_twice;
        let starts = StartPlace {
            steps,
            within: within.is_some(),
            again,
            burnt_twice,
            is_upper_bound: again || kept_twice >= MIN_REPORTED_OVERLAP,
            nothing_queued: checkpoint.is_untouched(seen),
        };
        self.shared.emit(JobEvent::Start(starts));
        // The earlier run finished its last step, but ended before it removed the journal.
        if program.steps().is_some_and(|all| steps >= all) {
            self.tracker().journal.remove();
            return Err(Fault::AllDone.into());
        }
        Ok((steps, within))
    }

    /// Waits until the arm has finished what a dead job left in its queue.
    async fn wait_for_idle(&self) -> Result<(), JobError> {
        let (_, places) = self.arm.stats().await?;
        let mut before = None;
        let mut changed = Instant::now();
        loop {
            let left = self.arm.queue().left_space().await?;
            let waiting = places.saturating_sub(left);
            let now = (
                self.arm.queue().current_index().await?,
                self.arm.get::<Pose>().await?,
            );
            // An empty queue and two equal readings: nothing moves any more.
            if waiting == 0 && before == Some(now) {
                return Ok(());
            }
            if before.replace(now) != Some(now) {
                changed = Instant::now();
            }
            if changed.elapsed() > STUCK_AFTER {
                return Err(Fault::StuckQueue { waiting }.into());
            }
            sleep(POLL_INTERVAL).await;
        }
    }
}

async fn checked_rest(
    program: &Program,
    from: u64,
    within: Option<[f64; 3]>,
    start: Preflight,
) -> Result<(RemainingProgram, Report, Timetable), Diagnostic> {
    let rest = program.remaining_within(from, within, start)?;
    let report = rest.check_in_turns(&BackgroundTurns).await;
    let timetable = rest.timetable_in_turns(&report, &BackgroundTurns).await;
    Ok((rest, report, timetable))
}

/// Index of the last finished command if the queue is empty, `None` otherwise.
pub(super) async fn rest_index(arm: &Arm) -> Result<Option<u64>, Error> {
    let (_, places) = arm.stats().await?;
    let empty = arm.queue().left_space().await? >= places;
    let index = arm.queue().current_index().await?.0;
    Ok(empty.then_some(index))
}
