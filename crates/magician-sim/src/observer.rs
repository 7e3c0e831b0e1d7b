//! Observers of an arm as its time passes; they change nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use magician_protocol::FrameBuf;

use crate::{ArmInstant, Controller, LinkId};

/// An observer of an arm as its time passes.
///
/// Time may pass in leaps: a second of motion is one call. An observer names the instants that it wants to see, and
/// the arm stops there on its way, which changes nothing about what it does. It also sees the arm after every event,
/// at the instant of the event.
pub trait Observer {
    /// The next instant of the arm's clock that is to be seen, later than the one that was seen last. `None`: nothing
    /// is.
    fn next_sample(&self) -> Option<ArmInstant> {
        None
    }

    /// The arm has come to an instant that was asked for, or something has happened there.
    fn observe(&mut self, arm: &Controller) {
        let _ = arm;
    }

    /// Bytes of a peer have reached the arm, cut anywhere, at an instant of the arm's clock.
    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        let _ = (now, link, bytes);
    }

    /// A peer's line has been silent for so long that a frame which had begun will not be completed.
    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        let _ = (now, link);
    }

    /// The arm has answered a peer.
    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        let _ = (now, link, frame);
    }

    /// A peer is gone.
    fn closed(&mut self, link: LinkId) {
        let _ = link;
    }
}

/// The observer, if there is one.
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

/// An observer that is shared with other code.
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

/// Its state at a panic can still be read.
fn lock<O>(observer: &Mutex<O>) -> MutexGuard<'_, O> {
    observer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Instants that an observer may be shown before others get a turn.
pub(crate) struct SampleBudget(u32);

impl SampleBudget {
    pub(crate) const fn new(samples: u32) -> Self {
        Self(samples)
    }

    /// Whether there is one more.
    fn spend(&mut self) -> bool {
        let left = self.0 > 0;
        self.0 = self.0.saturating_sub(1);
        left
    }
}

/// Lets the arm's time pass up to `to` by way of every instant that the observer is to see. Whether it got there, or
/// budget ran out on the way.
pub(crate) fn advance<O: Observer>(
    arm: &mut Controller,
    observer: &mut O,
    to: ArmInstant,
    budget: &mut SampleBudget,
) -> bool {
    while let Some(look) = observer.next_sample() {
        let event = arm.poll_timeout().unwrap_or(ArmInstant::MAX);
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
