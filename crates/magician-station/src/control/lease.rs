//! The lease of an arm: its holder, those who wait for it, those who ask for it, and how it passes.

use std::time::Duration;

use magician_protocol::HostInstant;

use super::{
    ArmId, Control, Effect, JogEnd, LeaseEnd, LeaseId, Refusal, RequestId, SessionId, WorkEnd,
};

/// A lease ends when its holder has not said anything for so long.
pub const TTL: Duration = Duration::from_secs(5);
/// A session whose socket has ended may come back for so long.
pub const GRACE: Duration = Duration::from_secs(5);
/// A holder who does not answer a question for so long has granted it.
pub const ASK: Duration = Duration::from_secs(20);

/// Who has a lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Held {
    pub(super) session: SessionId,
    pub(super) id: LeaseId,
}

/// A session that waits for its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Waiter {
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    until: HostInstant,
}

/// A session that asks the holder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Ask {
    pub(super) session: SessionId,
    pub(super) request: RequestId,
    until: HostInstant,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Lease {
    holder: Option<Held>,
    waiting: Vec<Waiter>,
    asking: Vec<Ask>,
}

impl Lease {
    pub(super) fn holder(&self) -> Option<Held> {
        self.holder
    }

    /// The sessions that wait, and those that ask: whether they ask.
    pub(super) fn waiting(&self) -> impl Iterator<Item = (SessionId, bool)> + '_ {
        let waiting = self.waiting.iter().map(|waiter| (waiter.session, false));
        waiting.chain(self.asking.iter().map(|ask| (ask.session, true)))
    }

    /// Changes the instants at which somebody has waited or asked for long enough.
    pub(super) fn each_instant(&mut self, mut change: impl FnMut(&mut HostInstant)) {
        let waiting = self.waiting.iter_mut().map(|waiter| &mut waiter.until);
        let asking = self.asking.iter_mut().map(|ask| &mut ask.until);
        waiting.chain(asking).for_each(&mut change);
    }

    /// Gives the lease another number.
    pub(super) fn renumber(&mut self, id: LeaseId) {
        if let Some(held) = &mut self.holder {
            held.id = id;
        }
    }

    /// When somebody has waited or asked for long enough.
    pub(super) fn next_question(&self) -> Option<HostInstant> {
        let waiting = self.waiting.iter().map(|waiter| waiter.until);
        let asking = self.asking.iter().map(|ask| ask.until);
        waiting.chain(asking).min()
    }

    /// Takes away what a session waits and asks for.
    pub(super) fn forget(&mut self, session: SessionId) -> Vec<RequestId> {
        let waiting = {
            self.waiting
                .extract_if(.., |waiter| waiter.session == session)
        }
        .map(|waiter| waiter.request);
        let asking =
            { self.asking.extract_if(.., |ask| ask.session == session) }.map(|ask| ask.request);
        waiting.chain(asking).collect()
    }

    /// Takes away what all sessions wait and ask for.
    pub(super) fn forget_all(&mut self) -> Vec<RequestId> {
        let waiting = self.waiting.drain(..).map(|waiter| waiter.request);
        let asking = self.asking.drain(..).map(|ask| ask.request);
        waiting.chain(asking).collect()
    }

    /// Takes away those who have waited as long as they wanted to.
    pub(super) fn waited_enough(&mut self, now: HostInstant) -> Vec<RequestId> {
        let over = self.waiting.extract_if(.., |waiter| waiter.until <= now);
        over.map(|waiter| waiter.request).collect()
    }

    /// The first question that was not answered in time.
    pub(super) fn unanswered(&mut self, now: HostInstant) -> Option<Ask> {
        let at = self.asking.iter().position(|ask| ask.until <= now)?;
        Some(self.asking.remove(at))
    }
}

impl Control {
    /// A session wants the lease, and waits for it so long at most.
    pub fn acquire(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        wait: Duration,
    ) {
        if self.closed && self.holder(arm) != Some(session) {
            return self.deny(arm, vec![request]);
        }
        #[cfg(feature = "class")]
        if !self.admits(now, session, arm, request) {
            return;
        }
        match self.arm(arm).lease.holder {
            None => self.grant(now, arm, session, Some(request)),
            Some(held) if held.session == session => {
                let lease = held.id;
                self.effects.push_back(Effect::Granted {
                    request,
                    arm,
                    lease,
                });
            }
            Some(held) if wait.is_zero() => self.effects.push_back(Effect::Denied {
                request,
                holder: Some(held.session),
            }),
            Some(_) => {
                let until = now + wait.min(super::LONGEST_WAIT);
                self.arm_mut(arm).lease.waiting.push(Waiter {
                    session,
                    request,
                    until,
                });
                let place = self.arm(arm).lease.waiting.len();
                self.effects.push_back(Effect::Place {
                    session,
                    arm,
                    place,
                });
            }
        }
    }

    /// The arm whose lease this is, if it is the session's and has not ended.
    ///
    /// # Errors
    /// [`Refusal::Lease`] when it is another session's or has ended.
    pub fn renew(&self, session: SessionId, lease: LeaseId) -> Result<ArmId, Refusal> {
        let arm = self.arm_ids().find(|arm| {
            let holder = self.arm(*arm).lease.holder;
            holder == Some(Held { session, id: lease })
        });
        arm.ok_or(Refusal::Lease(None))
    }

    /// The holder gives it back. Nothing happens when it has ended, or is another session's.
    pub fn release(&mut self, now: HostInstant, session: SessionId, lease: LeaseId) {
        if let Ok(arm) = self.renew(session, lease) {
            self.end_lease(now, arm, LeaseEnd::Released);
        }
    }

    /// Gives back all leases of a session.
    pub fn release_all(&mut self, now: HostInstant, session: SessionId) {
        let held: Vec<_> = self.held_by(session).collect();
        for arm in held {
            self.end_lease(now, arm, LeaseEnd::Released);
        }
    }

    /// A session asks the holder for the lease. Without one it is granted.
    pub fn ask(&mut self, now: HostInstant, session: SessionId, arm: ArmId, request: RequestId) {
        let holder = self.arm(arm).lease.holder.map(|held| held.session);
        let Some(holder) = holder.filter(|holder| *holder != session) else {
            return self.acquire(now, session, arm, request, Duration::ZERO);
        };
        if self.closed {
            return self.deny(arm, vec![request]);
        }
        #[cfg(feature = "class")]
        if !self.admits(now, session, arm, request) {
            return;
        }
        let until = now + ASK;
        self.arm_mut(arm).lease.asking.push(Ask {
            session,
            request,
            until,
        });
        self.effects.push_back(Effect::Asked {
            arm,
            holder,
            session,
            request,
        });
    }

    /// The holder answers the session that asks.
    ///
    /// # Errors
    /// [`Refusal::Lease`] from a session without the lease, [`Refusal::Unknown`] when that session does not ask.
    pub fn answer(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        asker: SessionId,
        grant: bool,
    ) -> Result<(), Refusal> {
        let holder = self.holder(arm);
        if holder != Some(session) {
            return Err(Refusal::Lease(holder));
        }
        let asking = &mut self.arm_mut(arm).lease.asking;
        let at = asking.iter().position(|ask| ask.session == asker);
        let ask = asking.remove(at.ok_or(Refusal::Unknown)?);
        if grant {
            self.grant_ask(now, arm, asker, ask.request);
        } else {
            self.deny(arm, vec![ask.request]);
        }
        Ok(())
    }

    /// A session takes the lease away. The caller has made sure that it may.
    pub fn take(&mut self, now: HostInstant, session: SessionId, arm: ArmId, request: RequestId) {
        match self.holder(arm) {
            Some(holder) if holder != session && !self.closed => {
                self.pass(now, arm, session, Some(request))
            }
            _ => self.acquire(now, session, arm, request, Duration::ZERO),
        }
    }

    /// The lease passes to a session that asks, if it may still have it.
    pub(super) fn grant_ask(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        to: SessionId,
        request: RequestId,
    ) {
        #[cfg(feature = "class")]
        if !self.may_hold(now, to, arm) {
            return self.deny(arm, vec![request]);
        }
        self.pass(now, arm, to, Some(request));
    }

    /// The lease passes in one step: at no instant it is free for a third session.
    pub(super) fn pass(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        to: SessionId,
        request: Option<RequestId>,
    ) {
        if self.holder(arm) != Some(to) {
            self.finish_lease(now, arm, LeaseEnd::Passed, Some(to));
        }
        self.grant(now, arm, to, request);
    }

    /// The lease ends, and the next one who waits gets it.
    pub(super) fn end_lease(&mut self, now: HostInstant, arm: ArmId, end: LeaseEnd) {
        #[cfg(feature = "class")]
        {
            if let Some(holder) = self.holder(arm) {
                self.turn_lease_ended(now, arm, holder, end);
            }
            self.deny_unadmitted(now, arm);
        }
        let lease = &mut self.arm_mut(arm).lease;
        // Those who wait come first, then those who asked a holder that is gone.
        let waiting = lease
            .waiting
            .first()
            .map(|waiter| (waiter.session, waiter.request));
        lease.waiting.drain(..waiting.iter().len());
        let mut asks = std::mem::take(&mut lease.asking).into_iter();
        let next = waiting.or_else(|| asks.next().map(|ask| (ask.session, ask.request)));
        self.finish_lease(now, arm, end, next.map(|(session, _)| session));
        match next {
            Some((session, request)) => self.grant(now, arm, session, Some(request)),
            None => self.effects.push_back(Effect::Holder { arm, holder: None }),
        }
        self.deny(arm, asks.map(|ask| ask.request).collect());
        #[cfg(feature = "class")]
        {
            if end == LeaseEnd::Gone {
                self.hand_to_other_page(now, arm);
            }
            self.advance(now);
        }
    }

    /// Ends what the holder has under way.
    fn finish_lease(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        end: LeaseEnd,
        next: Option<SessionId>,
    ) {
        let holder = self.arm_mut(arm).lease.holder.take();
        self.end_jog_of(arm, JogEnd::Lease, |_| true);
        if std::mem::take(&mut self.arm_mut(arm).guided) {
            self.effects.push_back(Effect::EndGuide { arm });
        }
        let mut stops = false;
        if end == LeaseEnd::Released {
            // What was begun goes on to its end.
            self.arm_mut(arm).queued = false;
        } else if let Some(holder) = holder {
            let (requests, stop) = self.end_work_of(now, arm, holder.session);
            let why = WorkEnd::Lease(next);
            stops = stop;
            if stop || !requests.is_empty() {
                self.effects.push_back(Effect::EndWork {
                    arm,
                    requests,
                    stop,
                    why,
                });
            }
        }
        if holder.is_some() && !stops {
            // A motor has no end to go on to.
            self.effects.push_back(Effect::EndMotors { arm });
        }
        #[cfg(feature = "class")]
        if self.finishes_job(arm, end) {
            return;
        }
        self.end_job(arm);
    }

    /// Gives the free lease to a session, which has asked for it or whose turn it is.
    pub(super) fn grant(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        session: SessionId,
        request: Option<RequestId>,
    ) {
        if self.closed {
            // A turn of a class may come up as the station ends.
            self.deny(arm, request.into_iter().collect());
            return self.effects.push_back(Effect::Holder { arm, holder: None });
        }
        let id = LeaseId(self.next_id());
        // It begins with a word, however long its session has waited.
        self.heard(now, session);
        self.arm_mut(arm).lease.holder = Some(Held { session, id });
        let lease = id;
        if let Some(request) = request {
            self.effects.push_back(Effect::Granted {
                request,
                arm,
                lease,
            });
        }
        #[cfg(feature = "class")]
        if request.is_none() {
            self.effects.push_back(Effect::TurnLease {
                arm,
                session,
                lease,
            });
        }
        let holder = Some(session);
        self.effects.push_back(Effect::Holder { arm, holder });
        // What it waits and asks for besides is answered with it.
        let also = self.arm_mut(arm).lease.forget(session);
        for request in also {
            self.effects.push_back(Effect::Granted {
                request,
                arm,
                lease,
            });
        }
        #[cfg(feature = "class")]
        self.turn_granted(now, arm, session);
        self.ask_again(now, arm);
        self.tell_places(arm);
    }

    /// Those who asked the holder before ask the new one, who has as long to answer.
    fn ask_again(&mut self, now: HostInstant, arm: ArmId) {
        let lease = &mut self.arm_mut(arm).lease;
        let Some(Held {
            session: holder, ..
        }) = lease.holder
        else {
            return;
        };
        let asked = lease.asking.iter_mut().map(|ask| {
            ask.until = now + ASK;
            Effect::Asked {
                arm,
                holder,
                session: ask.session,
                request: ask.request,
            }
        });
        let asked: Vec<_> = asked.collect();
        self.effects.extend(asked);
    }

    pub(super) fn deny(&mut self, arm: ArmId, requests: Vec<RequestId>) {
        let holder = self.holder(arm);
        for request in requests {
            self.effects.push_back(Effect::Denied { request, holder });
        }
    }

    pub(super) fn tell_places(&mut self, arm: ArmId) {
        let waiting = self.arm(arm).lease.waiting.iter();
        let places: Vec<_> = { waiting.enumerate() }
            .map(|(at, waiter)| Effect::Place {
                session: waiter.session,
                arm,
                place: at + 1,
            })
            .collect();
        self.effects.extend(places);
    }
}
