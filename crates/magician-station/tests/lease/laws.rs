//! Invariants of control, checked after every event.

use magician_protocol::HostInstant;
use magician_station::control::{ArmId, JobPhase, LeaseLossPolicy, RECONNECT_GRACE, SessionId};

use crate::model::{Arm, Event, Model};
use crate::step::{Checked, must};

impl Model {
    pub(crate) fn check(&self, before: &Self, event: Event) -> Checked {
        for (id, arm) in (0..).map(ArmId).zip(&self.arms) {
            let held = self.control.control.holder(id);
            let told = arm.lease.map(|(session, _)| session);
            must(held == told, "the holder is the one who was told so")?;
            self.check_moves(arm)?;
            self.check_lease(id, arm, before, event)?;
            self.check_line(id, arm)?;
        }
        for request in self.requests.values().filter(|one| one.until.is_some()) {
            must(
                request.until > Some(self.now),
                "a request is answered in time",
            )?;
            must(
                self.session(request.session).left.is_none(),
                "who has left is answered",
            )?;
            let holder = self.arm(request.arm).lease.map(|(session, _)| session);
            must(
                !request.asks || request.asked == holder,
                "the present holder is asked",
            )?;
        }
        if let Event::Stop(_, arm) = event {
            self.check_stopped(arm, before)?;
        }
        Ok(())
    }

    /// Motion of an arm belongs to its holder.
    fn check_moves(&self, arm: &Arm) -> Checked {
        let holder = arm.lease.map(|(session, _)| session);
        for running in arm.running.iter().filter(|running| !running.free) {
            must(
                holder == Some(running.session),
                "what is under way belongs to the holder",
            )?;
        }
        for (session, _) in arm.queue.iter().filter(|(_, free)| !free) {
            must(
                holder == Some(*session),
                "what is queued belongs to the holder",
            )?;
        }
        must(
            arm.unattended.is_none() || holder == arm.unattended,
            "what has no end of its own belongs to the holder",
        )?;
        if let Some(jog) = &arm.jog {
            must(holder == Some(jog.session), "a jog belongs to the holder")?;
            must(jog.until > self.now, "a jog ends when it is not kept up")?;
            must(
                self.session(jog.session).left.is_none(),
                "a jog ends with its socket",
            )?;
        }
        Ok(())
    }

    fn check_lease(&self, id: ArmId, arm: &Arm, before: &Self, event: Event) -> Checked {
        if let Some((holder, _)) = arm.lease {
            must(!self.is_silent(holder), "a lease ends with its holder")?;
        }
        let was = before.arm(id).lease;
        if arm.lease == was {
            return Ok(());
        }
        if let Some((holder, _)) = was {
            let good = match event {
                Event::Release(session, at) => (session, at) == (holder, id),
                Event::Take(_, at) | Event::Answer(at, _, true) => at == id,
                Event::Pass => self.may_end(holder, before, id),
                _ => false,
            };
            must(good, "a lease ends for a reason")?;
            let job = before.arm(id).job == Some((LeaseLossPolicy::Pause, JobPhase::Active));
            let runs = matches!(arm.job, Some((_, JobPhase::Active)));
            must(!job || !runs, "the job pauses when its lease ends")?;
            let goes_on = before.arm(id).job == Some((LeaseLossPolicy::Continue, JobPhase::Active));
            must(!goes_on || runs, "a job that is to go on does")?;
        }
        let taker = match event {
            Event::Take(session, at) if at == id => Some(session),
            Event::Answer(at, session, true) if at == id => Some(session),
            _ => None,
        };
        let has = arm.lease.map(|(session, _)| session);
        must(
            taker.is_none() || has == taker,
            "a lease passes in one step",
        )
    }

    /// True if time alone may end a lease: by silence of the holder, or by a question without an
    /// answer.
    fn may_end(&self, holder: SessionId, before: &Self, arm: ArmId) -> bool {
        let known = before.session(holder);
        let silent = match known.left {
            Some(left) => self.now - left >= RECONNECT_GRACE,
            None => {
                !before.works(holder)
                    && self.now - known.heard >= magician_station::control::LEASE_TIMEOUT
            }
        };
        let due = |until: Option<HostInstant>| until.is_some_and(|until| until <= self.now);
        let mut asks = before.requests.values();
        silent || asks.any(|one| one.arm == arm && one.asks && due(one.until))
    }

    /// While a session waits or asks, the lease is not free, and each waiting session knows its
    /// position.
    fn check_line(&self, id: ArmId, arm: &Arm) -> Checked {
        let wants = { self.requests.values() }.any(|one| one.arm == id && one.until.is_some());
        must(
            arm.lease.is_some() || !wants,
            "a lease is not free while somebody wants it",
        )?;
        for (place, request) in (1..).zip(&arm.line) {
            let session = self.requests[request].session;
            must(
                arm.places.get(&session) == Some(&place),
                "who waits was told the place",
            )?;
        }
        Ok(())
    }

    /// After a stop nothing moves, and the lease is kept.
    fn check_stopped(&self, id: ArmId, before: &Self) -> Checked {
        let arm = self.arm(id);
        let runs = matches!(arm.job, Some((_, JobPhase::Active)));
        let is_on = arm.unattended.is_some();
        let moves = is_on || arm.jog.is_some() || !arm.running.is_empty() || !arm.queue.is_empty();
        must(!moves && !runs, "after a stop nothing moves")?;
        must(arm.lease == before.arm(id).lease, "a stop leaves the lease")
    }
}
