//! A job that is paused: nothing of it is in the arm, and where it goes on is known.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::{DeviceTime, Pose};
use magician::{Alarm, Error, ErrorCode, ErrorKind, Set};
use magician_program::resume::{ResumePoint, StepRange, resume_point_at};
use magician_program::{PauseCause, RemainingProgram};
use tokio::time::{Instant, sleep};

use super::inbox::{Inbox, Next, Stopped};
use super::look::{Found, at_rest};
use super::segment::Segment;
use super::{Begun, Work};
use crate::error::{Fault, JobError, Left, PenLift, ResumeError, Stood};
use crate::event::{JobState, PauseReason};

/// Between two looks whether the piece under way has ended.
const LOOKS: Duration = Duration::from_millis(50);
/// The longest that a command is waited for which the pose does not show: homing, a motor, the rail (model section 11).
const HIDDEN: Duration = Duration::from_secs(60);
/// As many steps are told apart by where the arm stands.
const MOST: u64 = 64;

/// Where a paused job goes on, and how the arm was then.
struct Place {
    /// Nothing if it cannot be told.
    from: Option<(u64, Option<[f64; 3]>)>,
    /// The arm's clock, ms.
    clock: u32,
    /// Whether alarm 0x00 stood.
    was_reset: bool,
}

/// A step that waits for a person.
struct PausedAt {
    reason: PauseReason,
    part: Option<u64>,
    text: Arc<str>,
}

impl Work {
    /// A pause that came before anything was sent: what is to be run when it ends.
    pub(super) async fn pause_ahead(
        &self,
        inbox: &mut Inbox,
        found: Found,
    ) -> Result<Found, JobError> {
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

    /// The queue was stopped: the job is paused when the piece under way has ended. What is to be run when the pause ends;
    /// nothing if that piece was the last.
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
        // From here on a stop finds a job of which all is known.
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

    /// The segment behind a pause, when it ends.
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

    /// All before a step that waits for a person is done: the job is paused there. What is to be run when the pause ends; nothing if
    /// that step was the last.
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
        // The step itself is done when a person has gone on.
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

    /// The pen goes up at a step that waits, and between parts the tool to where it is parked.
    async fn rises(&self, stood: &Stood, reason: PauseReason) -> Result<PenLift, Error> {
        let (plan, ending) = (self.spec.program.plan(), &self.spec.ending);
        let at = [stood.pose.x, stood.pose.y, stood.pose.z].map(f64::from);
        let begun = self.track().pulled > 0;
        if reason == PauseReason::Part {
            // Between parts the pen is up already, but for what the program has not lifted it.
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

    /// The job is paused until the next request; `step` is the one that waits, if one does.
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

    /// Waits until the piece under way has ended, empties the queue, switches the laser off; how the arm stands then.
    async fn come_to_rest(&self) -> Result<Stood, Error> {
        let arm = &self.arm;
        let began = Instant::now();
        let mut before = None;
        let stood = loop {
            let index = arm.queue().current_index().await?.0;
            let pose = arm.get::<Pose>().await?;
            let now = Stood { pose, index };
            let still = before.replace(now) == Some(now);
            if still && !(self.is_hidden(index) && began.elapsed() < HIDDEN) {
                break now;
            }
            sleep(LOOKS).await;
        };
        arm.queue().clear().await?;
        if self.burns {
            arm.laser().switch_off().await?;
        }
        // What was finished meanwhile counts.
        let index = arm.queue().current_index().await?.0.max(stood.index);
        Ok(Stood { index, ..stood })
    }

    /// Whether the command behind this index is one that may be under way while the pose stands.
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

    /// Keeps where the job goes on, before anything moves again; nothing if that cannot be told.
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
            // What burns goes out in pieces: the step that is not finished may be half done, and the last one is whole.
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

    /// Whether the job can go on now, and what is run then.
    async fn look_again(&self, place: &Place, found: Option<Found>) -> Result<Found, ResumeError> {
        let arm = &self.arm;
        let told = |error: Error| ResumeError::Arm(Arc::new(error));
        let alarms = arm.alarms().await.map_err(told)?;
        let clock = arm.get::<DeviceTime>().await.map_err(told)?.g_systick;
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
        // Clearing the alarm of a reset homes nothing.
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
        if let Some(found) = found.filter(|found| found.pose == pose) {
            let begun = Begun::now(arm).await.map_err(told)?;
            return Ok(Found { begun, ..found });
        }
        let found = Box::pin(self.look(from, within, true)).await;
        let found = found.map_err(|error| match error.fault {
            Fault::Arm(error) => ResumeError::Arm(error),
            Fault::Program(problem) => ResumeError::Program(problem),
            Fault::Refused { report, .. } => match report.refused_steps.into_iter().next() {
                Some(first) => ResumeError::Refused(Arc::new(first.error)),
                None => ResumeError::Unknown,
            },
            _ => ResumeError::Unknown,
        })?;
        if found.rest.start().arm().is_none() {
            return Err(ResumeError::Unknown);
        }
        Ok(found)
    }

    /// What is left of a pause that is stopped.
    pub(super) fn left(&self) -> Option<Left> {
        self.track().left
    }
}

pub(super) type Goes = (ResumePoint, (u64, Option<[f64; 3]>));

/// Where a job goes on of which so many steps are done at least, and so many at most, by where the arm stands: behind the one
/// step that ends there, or within the one whose line it is on. Nothing where several would do.
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
    let first = within.next()?;
    within.all(|other| other.1 == first.1).then_some(first)
}

/// What became of the pen at a pause, where the job is stopped then.
pub(super) type AtPause = Option<(Stood, PenLift)>;
