//! Applies effects of control to the model, with the invariants of each.

use magician_station::control::{ASK_TIMEOUT, ArmId, Effect, JobPhase, LeaseLossPolicy, RequestId};

use crate::model::{Event, Model};
use crate::step::{Checked, must};

impl Model {
    /// Stops the arm: everything it does is over, and each request is answered.
    pub(crate) fn end_requests(&mut self, arm: ArmId, ended: &[RequestId]) -> Checked {
        let arm = &mut self.arms[arm.0 as usize];
        arm.queue.clear();
        arm.unattended = None;
        for running in std::mem::take(&mut arm.running) {
            must(ended.contains(&running.request), "a stop ends all requests")?;
            // The request counted as a sign of life until now.
            self.sessions[running.session.0 as usize].heard = self.now;
        }
        ended.iter().try_for_each(|request| self.answered(*request))
    }

    fn answered(&mut self, request: RequestId) -> Checked {
        let known = self.requests.remove(&request);
        must(known.is_some(), "a request is answered once")?;
        for arm in &mut self.arms {
            arm.line.retain(|waits| *waits != request);
        }
        Ok(())
    }

    pub(crate) fn take_effects(&mut self, event: Event) -> Checked {
        for effect in self.control.effects() {
            self.carry_out(event, effect)?;
        }
        Ok(())
    }

    fn carry_out(&mut self, event: Event, effect: Effect) -> Checked {
        match effect {
            Effect::Granted {
                request,
                arm,
                lease,
            } => {
                let known = self.requests.get(&request);
                let session = known.ok_or("a request is answered once")?.session;
                let model = &mut self.arms[arm.0 as usize];
                if model.lease != Some((session, lease)) {
                    must(lease.0 > self.last, "a number is used once")?;
                    self.last = lease.0;
                    let bound = model.running.iter().any(|running| !running.free);
                    let bound = bound || model.queue.iter().any(|(_, free)| !free);
                    must(
                        !bound && model.jog.is_none() && model.unattended.is_none(),
                        "the arm is stopped before the next holder is told",
                    )?;
                    let in_turn = model.line.first() == Some(&request);
                    must(
                        in_turn || !model.line.contains(&request),
                        "those who wait get it in order",
                    )?;
                    let direct = matches!(event, Event::Answer(..) | Event::Take(..) | Event::Pass);
                    must(
                        in_turn || direct || model.line.is_empty(),
                        "those who wait come before those who ask",
                    )?;
                    model.lease = Some((session, lease));
                    // A lease starts with a sign of life.
                    self.sessions[session.0 as usize].heard = self.now;
                }
                self.answered(request)
            }
            Effect::Denied { request, .. } => self.answered(request),
            Effect::Place {
                session,
                arm,
                place,
            } => {
                self.arms[arm.0 as usize].places.insert(session, place);
                Ok(())
            }
            Effect::Holder { arm, holder } => {
                let model = &mut self.arms[arm.0 as usize];
                if holder.is_none() {
                    model.lease = None;
                }
                let has = model.lease.map(|(session, _)| session);
                must(has == holder, "the holder that is told is the holder")
            }
            Effect::Asked {
                arm,
                holder,
                request,
                ..
            } => {
                let has = self.arm(arm).lease.map(|(session, _)| session);
                must(has == Some(holder), "the holder is asked")?;
                let asked = self
                    .requests
                    .get_mut(&request)
                    .ok_or("a request that asks")?;
                (asked.until, asked.asks) = (Some(self.now + ASK_TIMEOUT), true);
                asked.asked = Some(holder);
                Ok(())
            }
            Effect::EndJog { arm, jog, .. } => {
                let over = self.arms[arm.0 as usize].jog.take_if(|one| one.id == jog);
                must(over.is_some(), "a jog that ends was under way")
            }
            Effect::EndUnattended { arm } => {
                self.arms[arm.0 as usize].unattended = None;
                Ok(())
            }
            Effect::EndWork {
                arm,
                requests,
                stop,
                ..
            } => {
                let job = self.arm(arm).job;
                must(
                    !stop || job != Some((LeaseLossPolicy::Continue, JobPhase::Active)),
                    "a job that goes on is not stopped",
                )?;
                // Without a stop motion continues, so none may belong to the former holder.
                must(stop || requests.is_empty(), "what moves is stopped")?;
                self.end_requests(arm, &requests)
            }
            Effect::EndJob { arm, pause, .. } => {
                let job = self.arm(arm).job;
                must(
                    job == Some((LeaseLossPolicy::Pause, JobPhase::Active)) && pause,
                    "a job ends as it is to end",
                )?;
                self.set_job_phase(arm, LeaseLossPolicy::Pause, Some(JobPhase::Paused));
                Ok(())
            }
            Effect::SessionOver(session) => {
                self.sessions[session.0 as usize].joined = false;
                Ok(())
            }
            other => Err(format!("unknown effect {other:?}")),
        }
    }
}
