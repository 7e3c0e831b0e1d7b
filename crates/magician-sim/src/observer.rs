//! Observers that watch an arm while its time passes, and change nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician_protocol::FrameBuf;

use crate::{ArmInstant, Controller, LinkId};

/// Watches an arm while its time passes.
///
/// One call may advance the arm by a second of motion or more. An observer asks for the instants
/// that it wants to see; the arm stops at each of them, which does not change its behaviour. While
/// an instant is requested, the observer also sees the arm after every event before that instant.
pub trait Observer {
    /// Next instant of the arm's clock to observe, later than the last one. `None` if there is
    /// none.
    fn next_sample(&self) -> Option<ArmInstant> {
        None
    }

    /// Called at each requested instant and, while an instant is requested, after each event. A
    /// [`Runner`](crate::Runner) also calls it after each request and each inter-byte timeout.
    fn observe(&mut self, arm: &Controller) {
        let _ = arm;
    }

    /// Called with the bytes of a peer as they reach the arm. The cuts between calls are arbitrary.
    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        let _ = (now, link, bytes);
    }

    /// Called when a peer has been silent for the inter-byte timeout: a partial frame is abandoned.
    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        let _ = (now, link);
    }

    /// Called when the arm has answered a peer.
    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        let _ = (now, link, frame);
    }

    /// Called when a peer is gone.
    fn closed(&mut self, link: LinkId) {
        let _ = link;
    }
}

/// Forwards to the observer, if there is one.
impl<O: Observer> Observer for Option<O> {
    fn next_sample(&self) -> Option<ArmInstant> {
        self.as_ref()?.next_sample()
    }

    fn observe(&mut self, arm: &Controller) {
        self.iter_mut().for_each(|it| it.observe(arm));
    }

    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        self.iter_mut()
            .for_each(|it| it.request_bytes(now, link, bytes));
    }

    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        self.iter_mut().for_each(|it| it.silence(now, link));
    }

    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        self.iter_mut().for_each(|it| it.reply(now, link, frame));
    }

    fn closed(&mut self, link: LinkId) {
        self.iter_mut().for_each(|it| it.closed(link));
    }
}

impl<O: Observer + ?Sized> Observer for Box<O> {
    fn next_sample(&self) -> Option<ArmInstant> {
        (**self).next_sample()
    }

    fn observe(&mut self, arm: &Controller) {
        (**self).observe(arm);
    }

    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        (**self).request_bytes(now, link, bytes);
    }

    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        (**self).silence(now, link);
    }

    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        (**self).reply(now, link, frame);
    }

    fn closed(&mut self, link: LinkId) {
        (**self).closed(link);
    }
}

/// Forwards to an observer shared with other code.
impl<O: Observer> Observer for Arc<Mutex<O>> {
    fn next_sample(&self) -> Option<ArmInstant> {
        lock(self).next_sample()
    }

    fn observe(&mut self, arm: &Controller) {
        lock(self).observe(arm);
    }

    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        lock(self).request_bytes(now, link, bytes);
    }

    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        lock(self).silence(now, link);
    }

    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        lock(self).reply(now, link, frame);
    }

    fn closed(&mut self, link: LinkId) {
        lock(self).closed(link);
    }
}

/// Locks an observer. Its state after a panic can still be read.
fn lock<O>(observer: &Mutex<O>) -> MutexGuard<'_, O> {
    observer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Number of instants that an observer may see in one call, so that peers are served in between.
pub(crate) struct SampleBudget(u32);

impl SampleBudget {
    pub(crate) const fn new(samples: u32) -> Self {
        Self(samples)
    }

    /// Consumes one instant; false if none is left.
    fn spend(&mut self) -> bool {
        let left = self.0 > 0;
        self.0 = self.0.saturating_sub(1);
        left
    }
}

/// Advances the arm to `to`, stopping at every instant that the observer asks for.
///
/// Returns false if the budget ran out before.
pub(crate) fn advance<O: Observer>(
    arm: &mut Controller,
    observer: &mut O,
    to: ArmInstant,
    budget: &mut SampleBudget,
) -> bool {
    while let Some(look) = observer.next_sample() {
        let event = arm.poll_timeout().unwrap_or(ArmInstant::MAX);
        // Never backwards: the requested instant may have passed, and an event may be overdue.
        let at = look.min(event).max(arm.now());
        if at > to {
            break;
        }
        if !budget.spend() {
            return false;
        }
        arm.advance(at);
        observer.observe(arm);
    }
    arm.advance(to);
    true
}
