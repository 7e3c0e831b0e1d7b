//! The lease of an arm: acquiring, waiting, asking, taking, and its end.
//!
//! At most one session holds the lease of an arm. A lease passes in one step, so that no third
//! session can acquire it in between. However a lease ends, what the holder had in progress is
//! ended first: only a lease that was given back lets queued motion continue.

use std::collections::BTreeSet;
use std::time::Duration;

use magician_protocol::HostInstant;

use super::claims::LeaseRequest;
use super::{
    ArmId, Control, Effect, JogEnd, LeaseEnd, LeaseId, Refusal, RequestId, SessionId, WorkEnd,
};

/// Lease timeout: the holder sent nothing for this long. Short enough that others need not wait
/// long for a dead client, long enough to survive a pause of a wireless network; a choice.
pub const LEASE_TIMEOUT: Duration = Duration::from_secs(5);
/// Time that a session without a socket may take to come back. Covers reloading a page.
pub const RECONNECT_GRACE: Duration = Duration::from_secs(5);
/// Time that a holder has to answer a request for the lease. Silence grants it.
pub const ASK_TIMEOUT: Duration = Duration::from_secs(20);

/// Holder of a lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LeaseHolder {
    pub(super) session: SessionId,
    pub(super) id: LeaseId,
}

impl Control {
    /// Requests the lease of an arm for a session. Waits at most `wait` if it is not free.
    pub fn acquire(
        &mut self,
        now: HostInstant,
        session: SessionId,
        arm: ArmId,
        request: RequestId,
        wait: Duration,
    ) {
        // The holder may renew even while the station ends: it still has to end its run.
        if self.is_ending && self.holder(arm) != Some(session) {
            return self.deny(arm, vec![request]);
        }
        #[cfg(feature = "class")]
        if !self.admits(now, session, arm, request) {
            return;
        }
        match self.arm(arm).lease {
            // No session is passed over: sessions wait at a free arm only if they are not allowed
            // to hold it.
            None => self.grant(now, arm, session, Some(request)),
            // Acquiring twice is harmless and returns the same lease.
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
                self.claims.push_request(LeaseRequest {
                    arm,
                    session,
                    request,
                    is_ask: false,
                    // A client without a timeout must not stay in the queue for ever.
                    until: now + wait.min(super::MAX_LEASE_WAIT),
                });
                let place = self.claims.waiting_requests(arm).count();
                self.effects.push_back(Effect::Place {
                    session,
                    arm,
                    place,
                });
            }
        }
    }

    /// Returns the arm of a lease, if the session still holds it.
    ///
    /// # Errors
    /// [`Refusal::Lease`] if the lease has ended or belongs to another session.
    pub fn renew(&self, session: SessionId, lease: LeaseId) -> Result<ArmId, Refusal> {
        let arm = self.arm_ids().find(|arm| {
            let holder = self.arm(*arm).lease;
            holder == Some(LeaseHolder { session, id: lease })
        });
        arm.ok_or(Refusal::Lease(None))
    }

    /// Gives a lease back. No effect if it has ended or belongs to another session.
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

    /// Asks the holder for the lease. Grants it if the arm has no holder.
    pub fn ask(&mut self, now: HostInstant, session: SessionId, arm: ArmId, request: RequestId) {
        let holder = self.arm(arm).lease.map(|held| held.session);
        // Without another holder there is no session to ask.
        let Some(holder) = holder.filter(|holder| *holder != session) else {
            return self.acquire(now, session, arm, request, Duration::ZERO);
        };
        if self.is_ending {
            return self.deny(arm, vec![request]);
        }
        #[cfg(feature = "class")]
        if !self.admits(now, session, arm, request) {
            return;
        }
        let asks_already =
            { self.claims.asking_requests_mut(arm) }.any(|ask| ask.session == session);
        self.claims.push_request(LeaseRequest {
            arm,
            session,
            request,
            is_ask: true,
            until: now + ASK_TIMEOUT,
        });
        // The holder is asked once per session, not once per request: it answers a session, not
        // a request.
        if !asks_already {
            self.effects.push_back(Effect::Asked {
                arm,
                holder,
                session,
                request,
            });
        }
    }

    /// Answers a session that asked for the lease.
    ///
    /// # Errors
    /// [`Refusal::Lease`] if `session` is not the holder; [`Refusal::Unknown`] if `asker` has not
    /// asked.
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
        let of = |ask: &LeaseRequest| ask.arm == arm && ask.is_ask && ask.session == asker;
        let ask = self.claims.take_first(of).ok_or(Refusal::Unknown)?;
        if grant {
            self.grant_to_asker(now, arm, asker, ask.request);
        } else {
            self.deny(arm, vec![ask.request]);
        }
        // Further requests of the same session get the same answer.
        self.deny_requests(arm, of);
        Ok(())
    }

    /// Takes the lease from its holder. The caller must have checked that the session may do so.
    pub fn take(&mut self, now: HostInstant, session: SessionId, arm: ArmId, request: RequestId) {
        match self.holder(arm) {
            Some(holder) if holder != session && !self.is_ending => {
                self.pass(now, arm, session, Some(request))
            }
            // The arm is free or the session holds it already, so there is no lease to take away.
            _ => self.acquire(now, session, arm, request, Duration::ZERO),
        }
    }

    /// Passes the lease to a session that asked for it, if it may still hold it.
    pub(super) fn grant_to_asker(
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

    /// Passes the lease in one step: at no instant can a third session acquire it.
    pub(super) fn pass(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        to: SessionId,
        request: Option<RequestId>,
    ) {
        if self.holder(arm) != Some(to) {
            // Work of the former holder ends before the new one is granted the lease.
            self.finish_lease(now, arm, LeaseEnd::Passed, Some(to));
        }
        self.grant(now, arm, to, request);
    }

    /// Ends a lease and grants it to the next request.
    pub(super) fn end_lease(&mut self, now: HostInstant, arm: ArmId, end: LeaseEnd) {
        #[cfg(feature = "class")]
        {
            if let Some(holder) = self.holder(arm) {
                // Before the next grant, which may start another turn.
                self.note_turn_lease_ended(now, arm, holder, end);
            }
            self.deny_unadmitted(now, arm);
        }
        // Waiting requests come first, then the requests that asked the former holder.
        let next = self.claims.requests(arm).next().copied();
        // Requests that asked are answered now, because the holder that they asked is gone.
        let ended =
            |other: &LeaseRequest| other.arm == arm && (other.is_ask || Some(*other) == next);
        let asked = self.claims.take(ended);
        self.finish_lease(now, arm, end, next.map(|next| next.session));
        match next {
            Some(next) => self.grant(now, arm, next.session, Some(next.request)),
            None => self.effects.push_back(Effect::Holder { arm, holder: None }),
        }
        let others = asked.into_iter().filter(|asked| Some(*asked) != next);
        self.deny(arm, others.map(|asked| asked.request).collect());
        #[cfg(feature = "class")]
        {
            // Not after silence: the silent page still has its socket, and would get the lease
            // back.
            if end == LeaseEnd::Gone {
                self.hand_to_other_page(now, arm);
            }
            self.advance(now);
        }
    }

    /// Ends what the holder has in progress.
    fn finish_lease(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        end: LeaseEnd,
        next: Option<SessionId>,
    ) {
        let holder = self.arm_mut(arm).lease.take();
        // A jog needs a holder in any case, so it ends even when the lease is given back.
        self.end_jog_of(arm, JogEnd::Lease, |_| true);
        if std::mem::take(&mut self.arm_mut(arm).guided) {
            self.effects.push_back(Effect::EndGuide { arm });
        }
        let mut stops = false;
        if end == LeaseEnd::Released {
            // Given back on purpose: what is queued continues to its end.
            self.arm_mut(arm).queued = false;
        } else if let Some(holder) = holder {
            let (requests, stop) = self.end_work_of(now, arm, holder.session);
            let why = WorkEnd::Lease(next);
            // The stop switches motors and the laser off as well.
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
            // Motors and the laser have no end of their own, so they end even when the lease is
            // given back.
            self.effects.push_back(Effect::EndUnattended { arm });
        }
        #[cfg(feature = "class")]
        if self.finishes_job(arm, end) {
            return;
        }
        self.end_job(arm);
    }

    /// Grants the free lease to a session. `request` is `None` if it gets the lease by its turn.
    pub(super) fn grant(
        &mut self,
        now: HostInstant,
        arm: ArmId,
        session: SessionId,
        request: Option<RequestId>,
    ) {
        if self.is_ending {
            // A turn may come up while the station ends.
            self.deny(arm, request.into_iter().collect());
            return self.effects.push_back(Effect::Holder { arm, holder: None });
        }
        let id = LeaseId(self.next_id());
        // Acquiring counts as a message, however long the session waited silently.
        self.note_message(now, session);
        self.arm_mut(arm).lease = Some(LeaseHolder { session, id });
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
        // All other requests of the session for this arm are answered with the same lease.
        let also = |other: &LeaseRequest| other.arm == arm && other.session == session;
        for LeaseRequest { request, .. } in self.claims.take(also) {
            self.effects.push_back(Effect::Granted {
                request,
                arm,
                lease,
            });
        }
        #[cfg(feature = "class")]
        self.note_turn_granted(now, arm, session);
        // Questions concern the lease, not its holder.
        self.ask_again(now, arm);
        self.notify_places(arm);
    }

    /// Repeats the questions of waiting sessions to the new holder, who gets the full time to
    /// answer.
    fn ask_again(&mut self, now: HostInstant, arm: ArmId) {
        let Some(holder) = self.holder(arm) else {
            return;
        };
        let mut told = BTreeSet::new();
        let asked = self.claims.asking_requests_mut(arm).filter_map(|ask| {
            ask.until = now + ASK_TIMEOUT;
            told.insert(ask.session).then_some(Effect::Asked {
                arm,
                holder,
                session: ask.session,
                request: ask.request,
            })
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

    /// Denies all requests of a session for an arm, and sends the others their new places.
    pub(super) fn deny_session(&mut self, arm: ArmId, session: SessionId) {
        let of = |request: &LeaseRequest| request.arm == arm && request.session == session;
        self.deny_requests(arm, of);
        self.notify_places(arm);
    }

    /// Denies all requests that match. Returns true if there were any.
    pub(super) fn deny_requests(
        &mut self,
        arm: ArmId,
        which: impl Fn(&LeaseRequest) -> bool,
    ) -> bool {
        let taken = self.claims.take(which);
        let requests: Vec<_> = taken.iter().map(|taken| taken.request).collect();
        self.deny(arm, requests);
        !taken.is_empty()
    }

    pub(super) fn notify_places(&mut self, arm: ArmId) {
        let places = (1..)
            .zip(self.claims.waiting_requests(arm))
            .map(|(place, waits)| Effect::Place {
                session: waits.session,
                arm,
                place,
            });
        let places: Vec<_> = places.collect();
        self.effects.extend(places);
    }
}
