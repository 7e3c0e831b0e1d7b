//! Applies events to control and the arms, and effects of control to the arms.

use std::time::Duration;

use magician_station::control::{
    ArmId, Effect, JobClaim, JobId, JobPhase, LeaseLossPolicy, RequestId, WorkKind,
};

use super::mutant::AT_ONCE;
use super::{ARMS, Event, Model, TEACHER};
use crate::step::{Checked, must};

impl Model {
    pub(super) fn check_step(&mut self, before: &Self, event: Event) -> Checked {
        self.apply(event)?;
        let request = RequestId(self.requests);
        let frozen = matches!(event, Event::Freeze(_));
        self.carry_out_all(event, request, frozen)?;
        self.begin_jobs()?;
        self.check(before, event)
    }

    fn request(&mut self) -> RequestId {
        self.requests += 1;
        RequestId(self.requests)
    }

    fn apply(&mut self, event: Event) -> Checked {
        use Event::*;
        let now = self.now;
        let request = self.request();
        let sender = match event {
            Acquire(session, _)
            | Release(session, _)
            | KeepAlive(session)
            | Move(session, _)
            | StartJob(session, _)
            | QueueJob(session, _) => Some(session),
            Take(_) | Freeze(_) | Free(_) | EndTurn(_) | NextTurn(_) => {
                self.sockets[&TEACHER].0.then_some(TEACHER)
            }
            _ => None,
        };
        if let Some(session) = sender {
            self.control.control.keep_alive(now, session);
            // Effects of this keep-alive are carried out before the event.
            self.carry_out_all(event, request, false)?;
        }
        match event {
            Join(person, any) => self.control.join(now, person, any),
            Leave(person) => self.control.control.leave_turn(now, person),
            Acquire(session, arm) => {
                self.control
                    .control
                    .acquire(now, session, arm, request, AT_ONCE);
            }
            Release(session, arm) => {
                // The keep-alive may have passed the lease on.
                if self.arm(arm).lease == Some(session) {
                    let mut ended = Vec::new();
                    for (id, arm) in ARMS.into_iter().zip(&mut self.arms) {
                        if arm.lease == Some(session) {
                            let moves = std::mem::take(&mut arm.moves).into_keys();
                            ended.extend(moves.map(|request| (id, request)));
                        }
                    }
                    self.control.control.release_all(now, session);
                    // Motion of a released lease continues and comes to its end.
                    for (arm, request) in ended {
                        self.control.control.finish(now, arm, request);
                    }
                }
            }
            Take(arm) => {
                if self.sockets[&TEACHER].0 {
                    self.control.take(now, arm, request);
                }
            }
            KeepAlive(_) => {}
            Gone(session) => {
                self.sockets
                    .insert(session, (false, self.sockets[&session].1));
                self.control.gone(now, session);
            }
            Back(session) => {
                let known = self.sockets[&session].1;
                self.sockets.insert(session, (true, true));
                if known {
                    self.control.control.rejoin(now, session);
                } else {
                    self.control.control.join(now, session);
                    if let Some(person) = Self::person(session) {
                        self.control.identify(now, session, person);
                    }
                }
            }
            Move(session, arm) => {
                let kind = WorkKind::Queued;
                if self.control.begin(now, session, arm, request, kind) {
                    self.arm_mut(arm).moves.insert(request, session);
                }
            }
            StartJob(session, arm) => {
                let kind = WorkKind::StartJob;
                if self.control.begin(now, session, arm, request, kind) {
                    self.arm_mut(arm).job = Some(session);
                    self.set_job_phase(arm, Some(JobPhase::Active));
                    self.control.control.finish(now, arm, request);
                }
            }
            EndJob(arm) => {
                self.arm_mut(arm).job = None;
                self.set_job_phase(arm, None);
            }
            QueueJob(session, arm) => {
                let queue = &mut self.arm_mut(arm).queue;
                let mut numbers = (0..).map(|number| JobId(10 + 10 * arm.0 + number));
                let job = numbers.find(|job| queue.iter().all(|(known, _)| known != job));
                let job = job.expect("numbers do not end");
                queue.push((job, session));
                let person = Self::person(session);
                self.control.queue_job(JobClaim { job, arm, person });
            }
            Freeze(arm) => {
                self.arm_mut(arm).frozen = true;
                self.control.freeze(now, arm);
            }
            Free(arm) => {
                self.arm_mut(arm).frozen = false;
                self.control.control.free(now, arm);
            }
            EndTurn(arm) => self.control.finish_turn(now, arm),
            NextTurn(arm) => self.control.pass_turn(now, arm),
            Pass => {
                let due = self.control.control.poll_timeout();
                must(
                    due.is_none_or(|due| due > now),
                    "what is due is in the future",
                )?;
                self.now = due.unwrap_or(now + Duration::from_secs(6));
                self.control.pass(self.now);
            }
        }
        Ok(())
    }

    /// Starts waiting jobs that may start, as a station does after each event.
    fn begin_jobs(&mut self) -> Checked {
        for arm in ARMS {
            while let Some(claim) = self.control.next_job(self.now, arm) {
                self.check_begun(claim)?;
                let model = self.arm_mut(arm);
                let mut queue = model.queue.iter();
                let at = queue.position(|(job, _)| *job == claim.job);
                let at = at.ok_or("a job begins once")?;
                let (_, session) = model.queue.remove(at);
                model.job = Some(session);
                self.set_job_phase(arm, Some(JobPhase::Active));
            }
        }
        Ok(())
    }

    fn set_job_phase(&mut self, arm: ArmId, phase: Option<JobPhase>) {
        let (now, job) = (self.now, JobId(arm.0));
        self.control
            .control
            .set_job_phase(now, arm, job, LeaseLossPolicy::Pause, phase);
    }

    fn carry_out_all(&mut self, event: Event, request: RequestId, frozen: bool) -> Checked {
        loop {
            let effects = self.control.effects(frozen);
            if effects.is_empty() {
                return Ok(());
            }
            for effect in effects {
                self.carry_out(effect, event, request)?;
            }
        }
    }

    fn carry_out(&mut self, effect: Effect, event: Event, request: RequestId) -> Checked {
        match effect {
            Effect::Granted {
                request: answered,
                arm,
                lease,
            } => {
                must(answered == request, "a request is answered once")?;
                let session = match event {
                    Event::Acquire(session, _) => session,
                    _ => TEACHER,
                };
                // A holder that acquires again gets its own lease.
                if self.arm(arm).lease != Some(session) {
                    must(lease > self.last, "a number is used once")?;
                    self.last = lease;
                    self.arm_mut(arm).lease = Some(session);
                }
                Ok(())
            }
            Effect::TurnLease {
                arm,
                session,
                lease,
            } => {
                must(lease > self.last, "a number is used once")?;
                must(self.sockets[&session].0, "who is not there gets no lease")?;
                self.last = lease;
                self.arm_mut(arm).lease = Some(session);
                Ok(())
            }
            Effect::Denied {
                request: answered, ..
            } => must(answered == request, "a request is answered once"),
            Effect::Holder { arm, holder } => {
                if holder.is_none() {
                    self.arm_mut(arm).lease = None;
                }
                must(
                    self.arm(arm).lease == holder,
                    "the holder that is told is the holder",
                )
            }
            Effect::EndWork {
                arm,
                requests,
                stop,
                ..
            } => {
                let moves = &mut self.arm_mut(arm).moves;
                moves.retain(|request, _| !requests.contains(request));
                must(!stop || moves.is_empty(), "a stop ends all requests")
            }
            Effect::EndJob { arm, pause, .. } => {
                must(pause, "a job ends as it is to end")?;
                if self.arm_mut(arm).job.take().is_some() {
                    self.arm_mut(arm).paused = true;
                    self.set_job_phase(arm, Some(JobPhase::Paused));
                }
                Ok(())
            }
            Effect::SessionOver(session) => {
                let socket = self.sockets[&session].0;
                self.sockets.insert(session, (socket, false));
                Ok(())
            }
            Effect::Turns | Effect::TurnEnding { .. } | Effect::EndUnattended { .. } => Ok(()),
            other => Err(format!("unknown effect {other:?}")),
        }
    }
}
