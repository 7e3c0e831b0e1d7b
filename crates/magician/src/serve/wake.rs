//! Wakers of several arms in one future. When woken, it polls only the arms for which something
//! happened: with hundreds of arms, polling each would cost more than serving the one.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Wake, Waker};

/// Waker of the future that holds all arms.
#[derive(Clone)]
pub(super) struct WakeSet(Arc<Mutex<Waker>>);

impl WakeSet {
    pub(super) fn new() -> Self {
        Self(Arc::new(Mutex::new(Waker::noop().clone())))
    }

    /// Sets the waker of the future, at each poll.
    pub(super) fn listen(&self, waker: &Waker) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.clone_from(waker);
    }

    fn wake(&self) {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Cloned, so that the lock is not held while foreign code runs.
        let waker = known.clone();
        drop(known);
        waker.wake();
    }
}

/// Waker of one arm, which remembers that it was called.
pub(super) struct WakeFlag {
    flagged: AtomicBool,
    wake_set: WakeSet,
}

impl WakeFlag {
    /// Creates a flag that is already set: the first poll is due.
    pub(super) fn new(wake_set: WakeSet) -> Arc<Self> {
        let flagged = AtomicBool::new(true);
        Arc::new(Self { flagged, wake_set })
    }

    /// True if it was set since the last call.
    pub(super) fn answer(&self) -> bool {
        self.flagged.swap(false, Ordering::AcqRel)
    }
}

impl Wake for WakeFlag {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        // Only the first call since the last poll wakes the future; the others change nothing.
        if !self.flagged.swap(true, Ordering::AcqRel) {
            self.wake_set.wake();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bell_wakes_the_house_once_until_it_is_answered() {
        let wake_set = WakeSet::new();
        let outer = WakeFlag::new(WakeSet::new());
        wake_set.listen(&Waker::from(Arc::clone(&outer)));
        let bells = [WakeFlag::new(wake_set.clone()), WakeFlag::new(wake_set)];
        assert!(bells.iter().all(|bell| bell.answer()) && outer.answer());

        for _ in 0..2 {
            Waker::from(Arc::clone(&bells[1])).wake();
        }
        assert!(outer.answer());
        assert_eq!(bells.each_ref().map(|bell| bell.answer()), [false, true]);
        assert_eq!(bells.each_ref().map(|bell| bell.answer()), [false, false]);

        bells[1].wake_by_ref();
        assert!(outer.answer(), "it rings again");
    }
}
