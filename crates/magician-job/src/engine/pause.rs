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

use super::inbox::{Inbox, Next, Stopped};
use super::look::{Readiness, at_rest};
use super::segment::Segment;
use super::{Begun, Work};
use crate::error::{Fault, JobError, Left, PenLift, ResumeError, Stood};
use crate::event::{JobState, PauseReason};

/// Poll interval while the command in progress ends.
const LOOKS: Duration = Duration::from_millis(50);
/// Longest wait for a command that does not show in the pose: homing, a motor, the rail
/// (model section 11).
const HIDDEN: Duration = Duration::from_secs(60);
/// Largest number of steps among which the pose may choose. A choice that bounds the work.
const MOST: u64 = 64;

/// Place where a paused job resumes, and the arm's state at the pause.
struct Place {
    /// Finished steps and position within the next; `None` if unknown.
    from: Option<(u64, Option<[f64; 3]>)>,
    /// The arm's clock, ms.
    clock: u32,
    /// True if alarm 0x00 (reset) was set.
    was_reset: bool,
}

/// A step of the program that waits for a person.
struct PausedAt {
    reason: PauseReason,
    part: Option<u64>,
    text: Arc<str>,
}

impl Work {
    /// Pauses before anything was sent; returns what to run when the pause ends.
    pub(super) async fn pause_ahead(
        &self,
        inbox: &mut Inbox,
        found: Readiness,
    ) -> Result<Readiness, JobError> {
        let place = async {
            Ok::<_, Error>(Place {
                from: Some((found.rest.from(), found.rest.within())),
                clock: self.arm.get::<DeviceTime>().await?.g_systick,
                was_reset: self.arm.alarms().await?.contains(Alarm::ResetOccurred),
            })
        };
        let place = match inbox.unless_stopped(place).await {
            Ok(place) => place?,
            Err(Stopped) => return Err(self.stopped(inbox, None).await),
        };
        let mut found = Some(found);
        loop {
            let reply = match self.hold(inbox, None).await {
                Next::Resume(reply) => reply,
                Next::Stop => return Err(self.stopped(inbox, None).await),
            };
            let look = self.look_again(&place, found.take());
            match inbox.unless_stopped(look).await {
                Err(Stopped) => return Err(self.stopped(inbox, None).await),
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
        let stood = match inbox.unless_stopped(come_to_rest).await {
            Ok(Ok(stood)) => stood,
            Ok(Err(error)) => return Err(self.fails(inbox, error).await),
            Err(Stopped) => return Err(self.stopped(inbox, None).await),
        };
        let from = self.keep_place(&stood);
        let all_done = |(steps, _)| self.steps().is_some_and(|all| steps >= all);
        if from.is_some_and(all_done) {
            return Ok(None);
        }
        // From here on a stop finds everything recorded.
        let rise = async {
            self.leaves_pace(&self.arm).await?;
            let lift = self.lift(&stood).await;
            let clock = self.arm.get::<DeviceTime>().await?.g_systick;
            let was_reset = self.arm.alarms().await?.contains(Alarm::ResetOccurred);
            Ok::<_, Error>((lift, clock, was_reset))
        };
        let (lift, clock, was_reset) = match inbox.unless_stopped(rise).await {
            Ok(Ok(risen)) => risen,
            Ok(Err(error)) => return Err(self.fails(inbox, error).await),
            Err(Stopped) => return Err(self.stopped(inbox, None).await),
        };
        let place = Place {
            from,
            clock,
            was_reset,
        };
        Box::pin(self.resumed_after(inbox, &place, (stood, lift), None))
            .await
            .map(Some)
    }

    /// Waits for the end of the pause and returns the segment to run after it.
    async fn resumed_after(
        &self,
        inbox: &mut Inbox,
        place: &Place,
        at: (Stood, PenLift),
        step: Option<&PausedAt>,
    ) -> Result<Segment, JobError> {
        let (stood, lift) = at;
        loop {
            let reply = match self.hold(inbox, step).await {
                Next::Resume(reply) => reply,
                Next::Stop => return Err(self.stopped(inbox, Some((stood, lift))).await),
            };
            match Box::pin(inbox.unless_stopped(self.look_again(place, None))).await {
                Err(Stopped) => return Err(self.stopped(inbox, Some((stood, lift))).await),
                Ok(Err(error)) => drop(reply.send(Err(error))),
                Ok(Ok(found)) => {
                    let _ = reply.send(Ok(()));
                    let mut segment = Segment::of(found.rest, found.timetable, found.begun, false);
                    segment.stops = self.arm.stops();
                    segment.rests_at = found.rests_at;
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
        let paused = PausedAt {
            reason: match pause.cause {
                PauseCause::Part => PauseReason::Part,
                // Every other cause is a pause written in the program.
                _ => PauseReason::Program,
            },
            part: rest.part_after(step).map(|part| part.n),
            text: Arc::from(&*pause.text),
        };
        self.shared.enter(JobState::Pausing);
        let stood = match inbox.unless_stopped(self.come_to_rest()).await {
            Ok(Ok(stood)) => stood,
            Ok(Err(error)) => return Err(self.fails(inbox, error).await),
            Err(Stopped) => return Err(self.stopped(inbox, None).await),
        };
        // The step itself is done when a person resumes.
        self.track().ends(ResumePoint::After(step), None);
        let rise = async {
            self.leaves_pace(&self.arm).await?;
            let lift = self.rises(&stood, paused.reason).await?;
            let clock = self.arm.get::<DeviceTime>().await?.g_systick;
            let was_reset = self.arm.alarms().await?.contains(Alarm::ResetOccurred);
            Ok::<_, Error>((lift, clock, was_reset))
        };
        let (lift, clock, was_reset) = match inbox.unless_stopped(rise).await {
            Ok(Ok(risen)) => risen,
            Ok(Err(error)) => return Err(self.fails(inbox, error).await),
            Err(Stopped) => return Err(self.stopped(inbox, None).await),
        };
        let next = step.saturating_add(1);
        if self.steps().is_some_and(|all| next >= all) {
            return match self.hold(inbox, Some(&paused)).await {
                Next::Resume(reply) => {
                    let _ = reply.send(Ok(()));
                    Ok(None)
                }
                Next::Stop => Err(self.stopped(inbox, Some((stood, lift))).await),
            };
        }
        let place = Place {
            from: Some((next, None)),
            clock,
            was_reset,
        };
        let segment = Box::pin(self.resumed_after(inbox, &place, (stood, lift), Some(&paused)));
        segment.await.map(Some)
    }

    /// Lifts the pen at a step that waits; between parts also parks the tool.
    async fn rises(&self, stood: &Stood, reason: PauseReason) -> Result<PenLift, Error> {
        let (plan, ending) = (self.spec.program.plan(), &self.spec.ending);
        let at = [stood.pose.x, stood.pose.y, stood.pose.z].map(f64::from);
        let begun = self.track().pulled > 0;
        if reason == PauseReason::Part {
            // Between parts the program has lifted the pen already, except for the rest computed
            // here.
            self.track().lift = ending.after_done(plan, at);
        }
        let lift = self.lift(stood).await;
        if let Some(place) = ending.park
            && begun
            && reason == PauseReason::Part
        {
            self.arm.park(place).await?;
        }
        Ok(lift)
    }

    /// Enters the paused state and waits for the next request. `step` is the step that waits for a
    /// person, if the program paused.
    async fn hold(&self, inbox: &mut Inbox, step: Option<&PausedAt>) -> Next {
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
        inbox.while_paused().await
    }

    /// Waits until the command in progress has ended, empties the queue and switches the laser off.
    /// Returns how the arm stands.
    async fn come_to_rest(&self) -> Result<Stood, Error> {
        let arm = &self.arm;
        let began = Instant::now();
        let mut before = None;
        let stood = loop {
            let index = arm.queue().current_index().await?.0;
            let pose = arm.get::<Pose>().await?;
            let now = Stood { pose, index };
            let still = before.replace(now) == Some(now);
            // A pose that stands proves rest, unless the command in progress does not show in it.
            if still && !(self.is_hidden(index) && began.elapsed() < HIDDEN) {
                break now;
            }
            sleep(LOOKS).await;
        };
        arm.queue().clear().await?;
        if self.burns {
            arm.laser().switch_off().await?;
        }
        // Counts a command that finished during the Clear.
        let index = arm.queue().current_index().await?.0.max(stood.index);
        Ok(Stood { index, ..stood })
    }

    /// True if the command after this index may be in progress while the pose stands still.
    fn is_hidden(&self, index: u64) -> bool {
        let track = self.track();
        let Some(rest) = &track.rest else {
            return false;
        };
        let StepRange { least, most } = track.counter.finished(index);
        let next = rest.next_command(least);
        let hidden = |command| {
            matches!(
                command,
                Set::HomeCmd(_) | Set::EMotorS(_) | Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_)
            )
        };
        let handed = track.counter.last().is_some_and(|(_, steps)| least < steps);
        least == most && handed && next.is_some_and(hidden)
    }

    /// Records where the job resumes, before anything moves again. `None` if that is unknown.
    fn keep_place(&self, stood: &Stood) -> Option<(u64, Option<[f64; 3]>)> {
        let mut track = self.track();
        if track.pulled == 0 {
            let from = track.from();
            return Some((from, track.rest.as_ref().and_then(RemainingProgram::within)));
        }
        let from = track.from();
        let rest = track.rest.clone()?;
        let StepRange { least, most } = track.counter.finished(stood.index);
        let (least, most) = (from + least, from + most);
        let found = if least == most {
            // The host splits burning lines into pieces: an unfinished step may be half done while
            // its last piece is complete.
            let half = self.burns && rest.stands_after(least, &stood.pose, false) != Some(true);
            let half = half.then(|| rest.goes_on(ResumePoint::Again(least), &stood.pose));
            if let Some(place @ (steps, Some(_))) = half.flatten() {
                Some((ResumePoint::Again(steps), place))
            } else {
                let resume_point =
                    resume_point_at(least, |steps| rest.stands_after(steps, &stood.pose, true));
                rest.goes_on(resume_point, &stood.pose)
                    .map(|place| (resume_point, place))
            }
        } else {
            by_pose(&rest, (least, most), &stood.pose)
        };
        let Some((resume_point, (steps, within))) = found else {
            track.ends(ResumePoint::Doubt(StepRange { least, most }), None);
            return None;
        };
        let resume_point = within.map_or(resume_point, |_| ResumePoint::Again(steps));
        track.ends(resume_point, within.map(|place| (steps, place)));
        Some((steps, within))
    }

    /// Checks if the job can resume now, and what to run then.
    async fn look_again(
        &self,
        place: &Place,
        found: Option<Readiness>,
    ) -> Result<Readiness, ResumeError> {
        let arm = &self.arm;
        let told = |error: Error| ResumeError::Arm(Arc::new(error));
        let alarms = arm.alarms().await.map_err(told)?;
        let clock = arm.get::<DeviceTime>().await.map_err(told)?.g_systick;
        // The 32-bit clock wraps after 49.7 days, so a restart shows as a difference beyond half of
        // its range.
        let began_anew = clock.wrapping_sub(place.clock) > u32::MAX / 2;
        if began_anew || alarms.contains(Alarm::ResetOccurred) && !place.was_reset {
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
                    _ => told(error),
                })?;
        }
        arm.wait_still().await.map_err(|error| match error.kind() {
            ErrorKind::Timeout => ResumeError::Busy,
            _ => told(error),
        })?;
        if at_rest(arm).await.map_err(told)?.is_none() {
            return Err(ResumeError::Busy);
        }
        self.check_ready().await.map_err(told)?;
        let pose = arm.get::<Pose>().await.map_err(told)?;
        // The arm has not moved since the first check, whose result still holds.
        if let Some(found) = found.filter(|found| found.pose == pose) {
            let begun = Begun::now(arm).await.map_err(told)?;
            return Ok(Readiness { begun, ..found });
        }
        let found = Box::pin(self.look(from, within, true)).await;
        let found = found.map_err(|error| match error.fault {
            Fault::Arm(error) => ResumeError::Arm(error),
            Fault::Program(problem) => ResumeError::Program(problem),
            Fault::Refused { report, .. } => match report.refused_steps.into_iter().next() {
                Some(first) => ResumeError::Refused(Arc::new(first.error)),
                None => ResumeError::Unknown,
            },
            // Doubt, stops and journal faults do not come from a look at known steps.
            _ => ResumeError::Unknown,
        })?;
        // From an unknown pose the approach cannot be checked.
        if found.rest.start().arm().is_none() {
            return Err(ResumeError::Unknown);
        }
        Ok(found)
    }

    /// Record of where a job that is stopped in a pause can be resumed.
    pub(super) fn left(&self) -> Option<Left> {
        self.track().left
    }
}

pub(super) type Goes = (ResumePoint, (u64, Option<[f64; 3]>));

/// Resume point chosen by the pose, if between `least` and `most` steps are done: after the only
/// step that ends at the pose, or within the only one whose line the pose is on.
///
/// `None` if several steps match.
pub(super) fn by_pose(
    rest: &RemainingProgram,
    (least, most): (u64, u64),
    pose: &Pose,
) -> Option<Goes> {
    if most - least > MOST {
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
        let place = rest.goes_on(resume_point, pose)?;
        place.1.map(|_| (ResumePoint::Again(place.0), place))
    });
    // Several candidates are acceptable if all of them give the same place.
    let first = within.next()?;
    within.all(|other| other.1 == first.1).then_some(first)
}

/// State of arm and pen at a pause, for a stop during it.
pub(super) type AtPause = Option<(Stood, PenLift)>;
