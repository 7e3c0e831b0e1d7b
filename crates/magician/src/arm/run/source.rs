//! Where a run's commands come from: an iterator, which has the next one at once, or a feeder, which may have nothing for now.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use magician_protocol::Set;
use tokio::sync::Notify;
use tokio::time::timeout;

use crate::arm::Arm;
use crate::arm::driver::Message;
use crate::stream::NextOffer;

/// A source that has nothing for now is asked again when the arm has finished something, or after so long.
const MOMENT: Duration = Duration::from_millis(10);

/// Where the commands of a [`Run`](crate::Run) come from. Every iterator is one.
pub trait CommandSource {
    /// The next command, or `None` after the last; pending while there is none for now.
    fn poll_next(&mut self, cx: &mut Context<'_>) -> Poll<Option<Set>>;

    /// How many there are, if that is known.
    fn total(&self) -> Option<u64> {
        None
    }

    /// No more of them is wanted.
    fn close(&mut self) {}
}

impl<I: Iterator<Item = Set>> CommandSource for I {
    fn poll_next(&mut self, _: &mut Context<'_>) -> Poll<Option<Set>> {
        Poll::Ready(self.next())
    }

    fn total(&self) -> Option<u64> {
        match self.size_hint() {
            (least, Some(most)) if least == most => Some(least as u64),
            _ => None,
        }
    }
}

/// What a feeder, the run that it feeds and the connection's task all know.
#[derive(Debug)]
pub(in crate::arm) struct Supply {
    /// Most commands that were pushed and that the arm has not finished.
    ahead: u64,
    state: Mutex<State>,
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<Set>,
    pushed: u64,
    finished: u64,
    /// The feeder has said that it has nothing for now.
    rests: bool,
    /// The clock of an arm in virtual time stands until the feeder tells the next command.
    stands: bool,
    /// The feeder has no more.
    ended: bool,
    /// The run wants no more.
    over: bool,
    taker: Option<Waker>,
}

impl Supply {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes it, and wakes the run.
    fn change(&self, change: impl FnOnce(&mut State)) {
        let taker = {
            let mut state = self.state();
            change(&mut state);
            state.taker.take()
        };
        if let Some(taker) = taker {
            taker.wake();
        }
    }

    /// The arm has finished so many.
    pub(in crate::arm) fn finished(&self, finished: u64) {
        let before = std::mem::replace(&mut self.state().finished, finished);
        if before != finished {
            self.changed.notify_waiters();
        }
    }

    /// Whether the arm's clock stands until the feeder tells more.
    pub(in crate::arm) fn set_stands(&self, stands: bool) {
        self.state().stands = stands;
    }

    pub(super) fn stands(&self) -> bool {
        self.state().stands
    }

    /// When the next command comes to a stream that was offered so many.
    pub(in crate::arm) fn next_offer(&self, offered: u64) -> NextOffer {
        let state = self.state();
        if state.pushed > offered || state.ended {
            NextOffer::AtOnce
        } else if state.pushed >= state.finished.saturating_add(self.ahead) {
            NextOffer::AfterOne
        } else if state.rests {
            NextOffer::Later
        } else {
            NextOffer::AtOnce
        }
    }
}

/// The run's end of a supply.
#[derive(Debug)]
pub(in crate::arm) struct Fed(Arc<Supply>);

impl Fed {
    pub(super) fn supply(&self) -> Arc<Supply> {
        Arc::clone(&self.0)
    }
}

impl CommandSource for Fed {
    fn poll_next(&mut self, cx: &mut Context<'_>) -> Poll<Option<Set>> {
        let mut state = self.0.state();
        match state.waiting.pop_front() {
            Some(command) => Poll::Ready(Some(command)),
            None if state.ended || state.over => Poll::Ready(None),
            None => {
                state.taker = Some(cx.waker().clone());
                Poll::Pending
            }
        }
    }

    fn close(&mut self) {
        let mut state = self.0.state();
        state.over = true;
        state.waiting.clear();
        drop(state);
        self.0.changed.notify_waiters();
    }
}

impl Drop for Fed {
    fn drop(&mut self) {
        self.close();
    }
}

/// Tells commands to a [`Streaming`](crate::Streaming) run, one by one. Dropping it ends the program after those that were told.
#[derive(Debug)]
pub struct Feeder {
    supply: Arc<Supply>,
    arm: Arm,
}

impl Feeder {
    /// Both ends, for so many commands that the arm has not finished; at least one.
    pub(super) fn new(arm: &Arm, ahead: usize) -> (Self, Fed) {
        let supply = Arc::new(Supply {
            ahead: ahead.max(1) as u64,
            state: Mutex::default(),
            changed: Notify::new(),
        });
        let arm = arm.clone();
        let fed = Fed(Arc::clone(&supply));
        (Self { supply, arm }, fed)
    }

    /// How many commands may be pushed now; `None` when the run has ended, or takes no more because one was refused.
    #[must_use]
    pub fn free(&self) -> Option<usize> {
        let state = self.supply.state();
        let most = state.finished.saturating_add(self.supply.ahead);
        let free = usize::try_from(most.saturating_sub(state.pushed)).unwrap_or(usize::MAX);
        (!state.over).then_some(free)
    }

    /// How many commands the arm has finished, as far as was read.
    #[must_use]
    pub fn finished(&self) -> u64 {
        self.supply.state().finished
    }

    /// Waits until a command may be pushed; `false` when none is wanted any more.
    pub async fn has_room(&self) -> bool {
        loop {
            let changed = self.supply.changed.notified();
            tokio::pin!(changed);
            // From here on no change is missed.
            changed.as_mut().enable();
            match self.free() {
                Some(0) => changed.await,
                free => return free.is_some(),
            }
        }
    }

    /// The next command. It is kept where there is no [room](Self::free) for it, and dropped where none is wanted.
    pub fn push(&self, command: Set) {
        self.supply.change(|state| {
            state.rests = false;
            if !state.over {
                state.pushed += 1;
                state.waiting.push_back(command);
            }
        });
    }

    /// Reports that nothing is ready yet, and waits for a moment: until the arm has finished something, or 10 ms. The clock of
    /// an arm in virtual time goes on meanwhile; without this it stands until the next command, or for a second.
    pub async fn rest(&self) {
        let changed = self.supply.changed.notified();
        tokio::pin!(changed);
        changed.as_mut().enable();
        self.supply.change(|state| state.rests = true);
        // A task with so many messages before it is awake, and looks.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
        let _ = timeout(MOMENT, changed).await;
        self.supply.change(|state| state.rests = false);
    }

    /// There are no more.
    pub fn end(&self) {
        self.supply.change(|state| state.ended = true);
    }
}

impl Drop for Feeder {
    fn drop(&mut self) {
        self.end();
    }
}
