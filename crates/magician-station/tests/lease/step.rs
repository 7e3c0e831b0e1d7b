//! Applies events to control and the arms.

use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{ArmId, JobPhase, LeaseLossPolicy, RequestId, SessionId, WorkKind};

use crate::model::{Event, KEEP, Model, Request, RunningJog, RunningRequest, SHORT_PAUSE, WAIT};

/// Result of a check. The error is the broken invariant.
pub(crate) type Checked = Result<(), String>;

pub(crate) fn must(good: bool, what: &str) -> Checked {
    if good { Ok(()) } else { Err(what.to_owned()) }
}

impl Model {
    /// Applies an event and checks all invariants.
    pub(super) fn check_step(&mut self, before: &Self, event: Event) -> Checked {
        self.control.next_event(self.now);
        self.apply(event)?;
        self.take_effects(event)?;
        self.check(before, event)
    }

    /// Message of a session.
    fn keep_alive(&mut self, session: SessionId) {
        self.sessions[session.0 as usize].heard = self.now;
        self.control.control.keep_alive(self.now, session);
    }

    fn request(&mut self, session: SessionId, arm: ArmId, until: Option<HostInstant>) -> RequestId {
        let id = self.free_request();
        let request = Request {
            session,
            arm,
            until,
            asks: false,
            asked: None,
        };
        self.requests.insert(id, request);
        id
    }

    fn apply(&mut self, event: Event) -> Checked {
        use Event::*;
        let now = self.now;
        let (session, arm) = match event {
            Acquire(session, arm)
            | Wait(session, arm)
            | Release(session, arm)
            | Ask(session, arm)
            | Take(session, arm)
            | Begin(session, arm, _)
            | StartJog(session, arm)
            | KeepJog(session, arm)
            | StopJog(session, arm)
            | SwitchOn(session, arm)
            | StartJob(session, arm, _)
            | PauseJob(session, arm)
            | Stop(session, arm) => (Some(session), Some(arm)),
            KeepAlive(session) | Leave(session) | Return(session) => (Some(session), None),
            Answer(arm, ..) => (self.arm(arm).lease.map(|(holder, _)| holder), Some(arm)),
            Finish(..) | EndJob(_) | Pass | ShortPause => (None, None),
        };
        self.uses(session, arm);
        if let Some(session) = session
            && !matches!(event, Leave(_) | Return(_))
        {
            self.keep_alive(session);
        }
        match event {
            KeepAlive(_) => {}
            Acquire(session, arm) => {
                let request = self.request(session, arm, Some(now));
                self.control
                    .acquire(now, session, arm, request, Duration::ZERO);
            }
            Wait(session, arm) => {
                let request = self.request(session, arm, Some(now + WAIT));
                if self.arm(arm).lease.is_some() {
                    self.arms[arm.0 as usize].line.push(request);
                }
                self.control.acquire(now, session, arm, request, WAIT);
            }
            Release(session, arm) => {
                let lease = self.arm(arm).lease.map(|(_, lease)| lease);
                self.free(arm);
                self.control.release(now, session, lease.ok_or("a lease")?);
            }
            Ask(session, arm) => {
                let request = self.request(session, arm, Some(now));
                self.control.ask(now, session, arm, request);
            }
            Answer(arm, asker, grant) => {
                let answered = self.control.answer(now, arm, asker, grant);
                must(answered.is_ok(), "a question that is open can be answered")?;
            }
            Take(session, arm) => {
                let lease = { self.arm(arm).lease }.filter(|(holder, _)| *holder != session);
                let request = self.request(session, arm, Some(now));
                self.control.take(now, session, arm, lease, request);
            }
            Leave(session) => {
                self.sessions[session.0 as usize].left = Some(now);
                self.control.leave(now, session);
            }
            Return(session) => {
                let known = &mut self.sessions[session.0 as usize];
                (known.left, known.heard) = (None, now);
                if !std::mem::replace(&mut known.joined, true) {
                    self.control.control.join(now, session);
                }
                self.control.control.rejoin(now, session);
            }
            Begin(session, arm, kind) => {
                let request = self.request(session, arm, None);
                let begun = self.control.begin(now, session, arm, request, kind).is_ok();
                self.began(session, arm, begun, request)?;
                if begun {
                    self.arms[arm.0 as usize].running.push(RunningRequest {
                        session,
                        free: false,
                        request,
                        queued: kind == WorkKind::Queued,
                    });
                }
            }
            Finish(arm, request) => self.finish(arm, request)?,
            StartJog(session, arm) => self.start_jog(session, arm)?,
            KeepJog(session, arm) => {
                let jog = self.arms[arm.0 as usize].jog.as_mut().ok_or("a jog")?;
                let kept = self.control.keep_jog(now, session, jog.id);
                // Only the session of the jog keeps it alive.
                if jog.session == session {
                    must(kept, "a jog under way can be kept up by its session")?;
                    jog.until = now + KEEP;
                }
            }
            StopJog(_, arm) => {
                let jog = self.arm(arm).jog.as_ref().ok_or("a jog")?.id;
                self.control.control.stop_jog(jog);
            }
            SwitchOn(session, arm) => {
                let (request, kind) = (self.request(session, arm, None), WorkKind::Queued);
                let begun = self.control.begin(now, session, arm, request, kind).is_ok();
                self.began(session, arm, begun, request)?;
                if begun {
                    // Answered at once; the motor or laser stays on.
                    self.arms[arm.0 as usize].unattended = Some(session);
                    self.arms[arm.0 as usize].queue.insert((session, false));
                    self.control.control.finish(now, arm, request);
                    self.requests.remove(&request);
                }
            }
            StartJob(session, arm, on_lost) => {
                let request = self.request(session, arm, None);
                let kind = WorkKind::StartJob;
                let begun = self.control.begin(now, session, arm, request, kind).is_ok();
                self.began(session, arm, begun, request)?;
                if begun {
                    // The job starts when the arm has done what was queued.
                    self.arms[arm.0 as usize].queue.clear();
                    self.set_job_phase(arm, on_lost, Some(JobPhase::Active));
                    self.control.control.finish(now, arm, request);
                    self.requests.remove(&request);
                }
            }
            PauseJob(session, arm) => {
                let may = self
                    .control
                    .control
                    .check_work(session, arm, WorkKind::SteerJob);
                if let (Ok(()), Some((on_lost, _))) = (may, self.arm(arm).job) {
                    self.set_job_phase(arm, on_lost, Some(JobPhase::Paused));
                }
            }
            EndJob(arm) => self.set_job_phase(arm, LeaseLossPolicy::Pause, None),
            Stop(_, arm) => self.stop(arm)?,
            ShortPause => self.now += SHORT_PAUSE,
            Pass => {
                let due = self.control.control.poll_timeout();
                must(
                    due.is_none_or(|due| due > now),
                    "what is due is in the future",
                )?;
                // Without a deadline: a long silence.
                self.now = due.unwrap_or(now + Duration::from_secs(6));
                self.control.handle_timeout(self.now);
            }
        }
        Ok(())
    }

    fn began(
        &mut self,
        session: SessionId,
        arm: ArmId,
        begun: bool,
        request: RequestId,
    ) -> Checked {
        if !begun {
            self.requests.remove(&request);
        }
        let holds = self
            .arm(arm)
            .lease
            .is_some_and(|(holder, _)| holder == session);
        must(holds || !begun, "nothing begins without the lease")
    }

    /// The lease is given back: motion that began under it continues.
    fn free(&mut self, arm: ArmId) {
        let arm = &mut self.arms[arm.0 as usize];
        arm.running
            .iter_mut()
            .for_each(|running| running.free = true);
        let queue = std::mem::take(&mut arm.queue);
        arm.queue = queue
            .into_iter()
            .map(|(session, _)| (session, true))
            .collect();
    }

    fn finish(&mut self, arm: ArmId, request: RequestId) -> Checked {
        let arm_model = &mut self.arms[arm.0 as usize];
        let at = { arm_model.running.iter() }.position(|running| running.request == request);
        let running = arm_model.running.remove(at.ok_or("something under way")?);
        if running.queued {
            arm_model.queue.insert((running.session, running.free));
        }
        let known = self.control.control.finish(self.now, arm, request);
        must(known, "what is under way is known")?;
        self.sessions[running.session.0 as usize].heard = self.now;
        self.requests.remove(&request);
        Ok(())
    }

    fn start_jog(&mut self, session: SessionId, arm: ArmId) -> Checked {
        let Ok(id) = self.control.control.start_jog(self.now, session, arm, KEEP) else {
            return Ok(());
        };
        // The stop of the replaced jog comes first.
        self.take_effects(Event::StartJog(session, arm))?;
        must(id.0 > self.last, "a number is used once")?;
        self.last = id.0;
        self.control.control.note_jog_started(self.now, id);
        must(self.arm(arm).jog.is_none(), "one jog an arm")?;
        let until = self.now + KEEP;
        self.arms[arm.0 as usize].jog = Some(RunningJog { id, session, until });
        Ok(())
    }

    pub(crate) fn set_job_phase(
        &mut self,
        arm: ArmId,
        on_lost: LeaseLossPolicy,
        phase: Option<JobPhase>,
    ) {
        self.arms[arm.0 as usize].job = phase.map(|phase| (on_lost, phase));
        self.control.set_job_phase(self.now, arm, on_lost, phase);
    }

    fn stop(&mut self, arm: ArmId) -> Checked {
        let model = self.arm(arm);
        let runs = matches!(model.job, Some((_, JobPhase::Active)));
        let Some(ended) = self.control.stop(self.now, arm, model.lease, runs) else {
            return Ok(());
        };
        self.end_requests(arm, &ended)?;
        if runs {
            self.set_job_phase(arm, LeaseLossPolicy::Pause, None);
        }
        Ok(())
    }
}
