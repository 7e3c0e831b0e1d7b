//! Pauses: nothing of the job is in the arm, and the place to resume at is known.
//!
//! A pause stops the queue, lets the command in progress end, empties the queue and lifts the pen.
//! The place to resume at is found as after a stop: by the arm's index where that is exact, by its
//! pose otherwise. While the job is paused a person may move the arm, so a resume checks alarms,
//! homing and the program again before anything moves.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::{DeviceTime, Pose};
use magician::{Alarm, Error, ErrorCode, ErrorKind, Set};
use magician_program::resume::{ResumePoint, StepRange, resume_point_at};
use magician_program::{PauseCause, RemainingProgram};
use tokio::time::{Instant, sleep};

use super::inbox::{Inbox, PauseEnd, Stopped};
use super::segment::Segment;
use super::start_check::{StartCheck, rest_index};
use super::{Engine, StartTime};
use crate::error::{Fault, JobError, PenLift, ResumeError, ResumePlace, StopPosition};
use crate::event::{JobState, PauseReason};

/// Poll interval while the command in progress ends.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Longest wait for a command that does not show in the pose: homing, a motor, the rail
/// (model section 11).
const MAX_HIDDEN_COMMAND_TIME: Duration = Duration::from_secs(60);
/// Largest number of steps that are compared with the pose to find where to resume. An arbitrary
/// limit, which bounds the work.
const MAX_CANDIDATE_STEPS: u64 = 64;

/// Place where a paused job resumes, and the arm's state at the pause.
struct PausePlace {
    /// Finished steps and position within the next; `None` if unknown.
    from: Option<(u64, Option<[f64; 3]>)>,
    /// The arm's clock, ms.
    clock: u32,
    /// True if alarm 0x00 (reset) was set.
    was_reset: bool,
}

/// A step of the program that waits for a person.
struct PauseStep {
    reason: PauseReason,
    part: Option<u64>,
    text: Arc<str>,
}

impl Engine {
    /// Pauses before anything was sent; returns what to run when the pause ends.
    pub(super) async fn pause_before_start(
        &self,
        inbox: &mut Inbox,
        found: StartCheck,
    ) -> Result<StartCheck, JobError> {
        let place = async {
            Ok::<_, Error>(PausePlace {
                from: Some((found.rest.from(), found.rest.within())),
                clock: self.arm.get::<DeviceTime>().await?.g_systick,
                was_reset: self.arm.alarms().await?.contains(Alarm::ResetOccurred),
            })
        };
        let place = match inbox.unless_stopped(place).await {
            Ok(place) => place?,
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        let mut found = Some(found);
        loop {
            let reply = match self.wait_paused(inbox, None).await {
                PauseEnd::Resume(reply) => reply,
                PauseEnd::Stop => return Err(self.end_after_stop(inbox, None).await),
            };
            let look = self.check_resume(&place, found.take());
            match inbox.unless_stopped(look).await {
                Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
                Ok(Err(error)) => drop(reply.send(Err(error))),
                Ok(Ok(found)) => {
                    let _ = reply.send(Ok(()));
                    return Ok(found);
                }
            }
        }
    }

    /// Pauses a job whose queue was stopped, once the command in progress has ended. Returns the
    /// segment to run when the pause ends, `None` if that command was the last.
    pub(super) async fn pause(&self, inbox: &mut Inbox) -> Result<Option<Segment>, JobError> {
        let come_to_rest = self.come_to_rest();
        let stopped_at = match inbox.unless_stopped(come_to_rest).await {
            Ok(Ok(stopped_at)) => stopped_at,
            Ok(Err(error)) => return Err(self.end_after_failure(inbox, error).await),
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        let from = self.record_place(&stopped_at);
        let all_done = |(steps, _)| self.steps().is_some_and(|all| steps >= all);
        if from.is_some_and(all_done) {
            return Ok(None);
        }
        // The place to resume at is recorded: a stop from here on need not determine it.
        let rise = async {
            self.restore_full_speed(&self.arm).await?;
            let lift = self.lift(&stopped_at).await;
            let clock = self.arm.get::<DeviceTime>().await?.g_systick;
            let was_reset = self.arm.alarms().await?.contains(Alarm::ResetOccurred);
            Ok::<_, Error>((lift, clock, was_reset))
        };
        let (lift, clock, was_reset) = match inbox.unless_stopped(rise).await {
            Ok(Ok(risen)) => risen,
            Ok(Err(error)) => return Err(self.end_after_failure(inbox, error).await),
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        let place = PausePlace {
            from,
            clock,
            was_reset,
        };
        Box::pin(self.await_resume(inbox, &place, (stopped_at, lift), None))
            .await
            .map(Some)
    }

    /// Waits for the end of the pause and returns the segment to run after it.
    async fn await_resume(
        &self,
        inbox: &mut Inbox,
        place: &PausePlace,
        at: (StopPosition, PenLift),
        step: Option<&PauseStep>,
    ) -> Result<Segment, JobError> {
        let (stopped_at, lift) = at;
        loop {
            let reply = match self.wait_paused(inbox, step).await {
                PauseEnd::Resume(reply) => reply,
                PauseEnd::Stop => {
                    return Err(self.end_after_stop(inbox, Some((stopped_at, lift))).await);
                }
            };
            match Box::pin(inbox.unless_stopped(self.check_resume(place, None))).await {
                Err(Stopped) => {
                    return Err(self.end_after_stop(inbox, Some((stopped_at, lift))).await);
                }
                Ok(Err(error)) => drop(reply.send(Err(error))),
                Ok(Ok(found)) => {
                    let _ = reply.send(Ok(()));
                    let mut segment =
                        Segment::new(found.rest, found.timetable, found.started, false);
                    segment.stops = self.arm.stops();
                    segment.rest_index = found.rest_index;
                    return Ok(segment);
                }
            }
        }
    }

    /// Pauses at a step that waits for a person, once everything before it is done. Returns the
    /// segment to run when the pause ends, `None` if that step was the last.
    pub(super) async fn pause_at_step(
        &self,
        inbox: &mut Inbox,
        rest: &RemainingProgram,
    ) -> Result<Option<Segment>, JobError> {
        let Some((step, pause)) = rest.pause() else {
            return Ok(None);
        };
        let paused = PauseStep {
            reason: match pause.cause {
                PauseCause::Part => PauseReason::Part,
                // Every other cause is a pause written in the program.
                _ => PauseReason::Program,
            },
            part: rest.part_after(step).map(|part| part.n),
            text: Arc::from(&*pause.text),
        };
        self.shared.enter(JobState::Pausing);
        let stopped_at = match inbox.unless_stopped(self.come_to_rest()).await {
            Ok(Ok(stopped_at)) => stopped_at,
            Ok(Err(error)) => return Err(self.end_after_failure(inbox, error).await),
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        // The step itself is done when a person resumes.
        self.tracker().record_end(ResumePoint::After(step), None);
        let rise = async {
            self.restore_full_speed(&self.arm).await?;
            let lift = self.lift_at_pause(&stopped_at, paused.reason).await?;
            let clock = self.arm.get::<DeviceTime>().await?.g_systick;
            let was_reset = self.arm.alarms().await?.contains(Alarm::ResetOccurred);
            Ok::<_, Error>((lift, clock, was_reset))
        };
        let (lift, clock, was_reset) = match inbox.unless_stopped(rise).await {
            Ok(Ok(risen)) => risen,
            Ok(Err(error)) => return Err(self.end_after_failure(inbox, error).await),
            Err(Stopped) => return Err(self.end_after_stop(inbox, None).await),
        };
        let next = step.saturating_add(1);
        if self.steps().is_some_and(|all| next >= all) {
            return match self.wait_paused(inbox, Some(&paused)).await {
                PauseEnd::Resume(reply) => {
                    let _ = reply.send(Ok(()));
                    Ok(None)
                }
                PauseEnd::Stop => Err(self.end_after_stop(inbox, Some((stopped_at, lift))).await),
            };
        }
        let place = PausePlace {
            from: Some((next, None)),
            clock,
            was_reset,
        };
        let segment = Box::pin(self.await_resume(inbox, &place, (stopped_at, lift), Some(&paused)));
        segment.await.map(Some)
    }

    /// Lifts the pen at a step that waits; between parts also parks the tool.
    async fn lift_at_pause(
        &self,
        stopped_at: &StopPosition,
        reason: PauseReason,
    ) -> Result<PenLift, Error> {
        let (plan, ending) = (self.spec.program.plan(), &self.spec.ending);
        let at = [stopped_at.pose.x, stopped_at.pose.y, stopped_at.pose.z].map(f64::from);
        let started = self.tracker().pulled > 0;
        if reason == PauseReason::Part {
            // Between parts the program has already lifted the pen; this computes the lift that is
            // still missing.
            self.tracker().lift = ending.after_done(plan, at);
        }
        let lift = self.lift(stopped_at).await;
        if let Some(place) = ending.park
            && started
            && reason == PauseReason::Part
        {
            self.arm.park(place).await?;
        }
        Ok(lift)
    }

    /// Enters the paused state and waits for the next request. `step` is the step that waits for a
    /// person, if the program paused.
    async fn wait_paused(&self, inbox: &mut Inbox, step: Option<&PauseStep>) -> PauseEnd {
        let (reason, part) = match step {
            Some(step) => (step.reason, step.part),
            None => (inbox.reason(), None),
        };
        if !matches!(self.shared.state(), JobState::Paused { .. }) {
            let text = step.map(|step| Arc::clone(&step.text));
            self.shared
                .enter_pause(JobState::Paused { reason, part }, text);
        }
        inbox.answer_pauses(|| Ok(()));
        inbox.next_pause_end().await
    }

    /// Waits until the command in progress has ended, empties the queue and switches the laser off.
    /// Returns the pose and the index of the arm at rest.
    async fn come_to_rest(&self) -> Result<StopPosition, Error> {
        let arm = &self.arm;
        let began = Instant::now();
        let mut before = None;
        let stopped_at = loop {
            let index = arm.queue().current_index().await?.0;
            let pose = arm.get::<Pose>().await?;
            let now = StopPosition { pose, index };
            let still = before.replace(now) == Some(now);
            // An unchanged pose proves that no command is in progress, unless the command does not
            // change the pose.
            if still && !(self.is_hidden(index) && began.elapsed() < MAX_HIDDEN_COMMAND_TIME) {
                break now;
            }
            sleep(POLL_INTERVAL).await;
        };
        arm.queue().clear().await?;
        if self.burns {
            arm.laser().switch_off().await?;
        }
        // Counts a command that finished during the Clear.
        let index = arm.queue().current_index().await?.0.max(stopped_at.index);
        Ok(StopPosition {
            index,
            ..stopped_at
        })
    }

    /// True if the command after this index may be in progress while the pose stands still.
    fn is_hidden(&self, index: u64) -> bool {
        let tracker = self.tracker();
        let Some(rest) = &tracker.remaining else {
            return false;
        };
        let StepRange { least, most } = tracker.counter.finished(index);
        let next = rest.next_command(least);
        let hidden = |command| {
            matches!(
                command,
                Set::HomeCmd(_) | Set::EMotorS(_) | Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_)
            )
        };
        let handed = tracker
            .counter
            .last()
            .is_some_and(|(_, steps)| least < steps);
        least == most && handed && next.is_some_and(hidden)
    }

    /// Records where the job resumes, before anything moves again. `None` if that is unknown.
    fn record_place(&self, stopped_at: &StopPosition) -> Option<(u64, Option<[f64; 3]>)> {
        let mut tracker = self.tracker();
        if tracker.pulled == 0 {
            let from = tracker.from();
            return Some((
                from,
                tracker
                    .remaining
                    .as_ref()
                    .and_then(RemainingProgram::within),
            ));
        }
        let from = tracker.from();
        let rest = tracker.remaining.clone()?;
        let StepRange { least, most } = tracker.counter.finished(stopped_at.index);
        let (least, most) = (from + least, from + most);
        let found = if least == most {
            // The host splits burning lines into pieces, so an arm that has finished its last
            // command may still stand within an unfinished step.
            let half =
                self.burns && rest.stands_after(least, &stopped_at.pose, false) != Some(true);
            let half = half.then(|| rest.resume_place(ResumePoint::Again(least), &stopped_at.pose));
            if let Some(place @ (steps, Some(_))) = half.flatten() {
                Some((ResumePoint::Again(steps), place))
            } else {
                let resume_point = resume_point_at(least, |steps| {
                    rest.stands_after(steps, &stopped_at.pose, true)
                });
                rest.resume_place(resume_point, &stopped_at.pose)
                    .map(|place| (resume_point, place))
            }
        } else {
            resume_by_pose(&rest, (least, most), &stopped_at.pose)
        };
        let Some((resume_point, (steps, within))) = found else {
            tracker.record_end(ResumePoint::Doubt(StepRange { least, most }), None);
            return None;
        };
        let resume_point = within.map_or(resume_point, |_| ResumePoint::Again(steps));
        tracker.record_end(resume_point, within.map(|place| (steps, place)));
        Some((steps, within))
    }

    /// Checks if the job can resume now, and what to run then.
    async fn check_resume(
        &self,
        place: &PausePlace,
        found: Option<StartCheck>,
    ) -> Result<StartCheck, ResumeError> {
        let arm = &self.arm;
        let arm_error = |error: Error| ResumeError::Arm(Arc::new(error));
        let alarms = arm.alarms().await.map_err(arm_error)?;
        let clock = arm.get::<DeviceTime>().await.map_err(arm_error)?.g_systick;
        // The 32-bit clock wraps after 49.7 days, so a restart shows as a difference beyond half of
        // its range.
        let has_restarted = clock.wrapping_sub(place.clock) > u32::MAX / 2;
        if has_restarted || alarms.contains(Alarm::ResetOccurred) && !place.was_reset {
            return Err(ResumeError::Reset);
        }
        if alarms.blocking() {
            return Err(ResumeError::Alarms(alarms));
        }
        let Some((from, within)) = place.from else {
            return Err(ResumeError::Unknown);
        };
        // Clearing the alarm of a reset does not home the arm.
        if !self.spec.program.homes_first(from) {
            arm.homing()
                .check()
                .await
                .map_err(|error| match error.code() {
                    ErrorCode::NotHomed => ResumeError::Reset,
                    _ => arm_error(error),
                })?;
        }
        arm.wait_still().await.map_err(|error| match error.kind() {
            ErrorKind::Timeout => ResumeError::Busy,
            _ => arm_error(error),
        })?;
        if rest_index(arm).await.map_err(arm_error)?.is_none() {
            return Err(ResumeError::Busy);
        }
        self.check_ready().await.map_err(arm_error)?;
        let pose = arm.get::<Pose>().await.map_err(arm_error)?;
        // The arm has not moved since the first check, whose result still holds.
        if let Some(found) = found.filter(|found| found.pose == pose) {
            let started = StartTime::now(arm).await.map_err(arm_error)?;
            return Ok(StartCheck { started, ..found });
        }
        let found = Box::pin(self.check_rest(from, within, true)).await;
        let found = found.map_err(|error| match error.fault {
            Fault::Arm(error) => ResumeError::Arm(error),
            Fault::Program(problem) => ResumeError::Program(problem),
            Fault::Refused { report, .. } => match report.refused_steps.into_iter().next() {
                Some(first) => ResumeError::Refused(Arc::new(first.error)),
                None => ResumeError::Unknown,
            },
            // A check of known steps never returns doubt, a stop or a journal fault.
            _ => ResumeError::Unknown,
        })?;
        // From an unknown pose the approach cannot be checked.
        if found.rest.start().arm().is_none() {
            return Err(ResumeError::Unknown);
        }
        Ok(found)
    }

    /// Record of where a job that is stopped in a pause can be resumed.
    pub(super) fn resume_place(&self) -> Option<ResumePlace> {
        self.tracker().resume_place
    }
}

pub(super) type ResumeChoice = (ResumePoint, (u64, Option<[f64; 3]>));

/// Resume point according to the pose, if between `least` and `most` steps are done: after the only
/// step that ends at the pose, or within the only one whose line the pose is on.
///
/// `None` if no step matches, or several do. Lines that give the same place count as one.
pub(super) fn resume_by_pose(
    rest: &RemainingProgram,
    (least, most): (u64, u64),
    pose: &Pose,
) -> Option<ResumeChoice> {
    if most - least > MAX_CANDIDATE_STEPS {
        return None;
    }
    let ends = (least..=most).filter(|steps| rest.stands_after(*steps, pose, true) == Some(true));
    let ends: Vec<u64> = ends.collect();
    if let [steps] = ends[..] {
        return Some((ResumePoint::After(steps), (steps, None)));
    }
    if !ends.is_empty() {
        return None;
    }
    let mut within = (least..=most).filter_map(|steps| {
        let resume_point = ResumePoint::Again(steps);
        let place = rest.resume_place(resume_point, pose)?;
        place.1.map(|_| (ResumePoint::Again(place.0), place))
    });
    // Several candidates are acceptable if all of them give the same place.
    let first = within.next()?;
    within.all(|other| other.1 == first.1).then_some(first)
}

/// State of arm and pen at a pause, for a stop during it.
pub(super) type PausedState = Option<(StopPosition, PenLift)>;
