//! Sources of commands for a run: an iterator, which always has the next one ready, or a feeder,
//! which may have nothing for now.

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

/// Interval at which a waiting source is polled again, unless the arm has finished a command
/// before. Choice.
const SOURCE_POLL_INTERVAL: Duration = Duration::from_millis(10);

/// Source of commands for a [`Run`](crate::Run). Every iterator implements it.
pub trait CommandSource {
    /// Returns the next command, or `None` after the last; pending if none is ready.
    fn poll_next(&mut self, cx: &mut Context<'_>) -> Poll<Option<Set>>;

    /// Returns the number of commands; `None` if unknown.
    fn total(&self) -> Option<u64> {
        None
    }

    /// Called when the run takes no more commands.
    fn close(&mut self) {}
}

impl<I: Iterator<Item = Set>> CommandSource for I {
    fn poll_next(&mut self, _: &mut Context<'_>) -> Poll<Option<Set>> {
        Poll::Ready(self.next())
    }

    fn total(&self) -> Option<u64> {
        match self.size_hint() {
            (least, Some(most)) if least == most => Some(least as u64),
            // An iterator that does not know its length exactly could mislead a progress bar.
            _ => None,
        }
    }
}

/// State shared by a feeder, its run and the connection's task.
#[derive(Debug)]
pub(in crate::arm) struct Supply {
    /// Largest number of pushed commands that are not yet finished.
    ahead: u64,
    state: Mutex<State>,
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<Set>,
    pushed: u64,
    finished: u64,
    /// True while the feeder reports that nothing is ready.
    feeder_idle: bool,
    /// True while the clock of an arm in virtual time waits for the next command.
    clock_waiting: bool,
    /// True after the last command.
    ended: bool,
    /// True if the run takes no more.
    closed: bool,
    taker: Option<Waker>,
}

impl Supply {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state, and wakes the run.
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

    /// Notes the number of finished commands.
    pub(in crate::arm) fn finished(&self, finished: u64) {
        let before = std::mem::replace(&mut self.state().finished, finished);
        if before != finished {
            self.changed.notify_waiters();
        }
    }

    /// Stores whether the arm's clock waits for the feeder.
    pub(in crate::arm) fn set_clock_waiting(&self, waiting: bool) {
        self.state().clock_waiting = waiting;
    }

    pub(super) fn clock_waiting(&self) -> bool {
        self.state().clock_waiting
    }

    /// Returns when a stream that was offered `offered` commands may expect the next.
    pub(in crate::arm) fn next_offer(&self, offered: u64) -> NextOffer {
        let state = self.state();
        if state.pushed > offered || state.ended {
            NextOffer::AtOnce
        // The feeder is at its limit, so a command has to finish first.
        } else if state.pushed >= state.finished.saturating_add(self.ahead) {
            NextOffer::AfterOne
        } else if state.feeder_idle {
            NextOffer::Later
        } else {
            NextOffer::AtOnce
        }
    }
}

/// Run's end of a supply.
#[derive(Debug)]
pub(in crate::arm) struct RunSupply(Arc<Supply>);

impl RunSupply {
    pub(super) fn supply(&self) -> Arc<Supply> {
        Arc::clone(&self.0)
    }
}

impl CommandSource for RunSupply {
    fn poll_next(&mut self, cx: &mut Context<'_>) -> Poll<Option<Set>> {
        let mut state = self.0.state();
        match state.waiting.pop_front() {
            Some(command) => Poll::Ready(Some(command)),
            None if state.ended || state.closed => Poll::Ready(None),
            None => {
                state.taker = Some(cx.waker().clone());
                Poll::Pending
            }
        }
    }

    fn close(&mut self) {
        let mut state = self.0.state();
        state.closed = true;
        state.waiting.clear();
        drop(state);
        self.0.changed.notify_waiters();
    }
}

impl Drop for RunSupply {
    fn drop(&mut self) {
        self.close();
    }
}

/// Sender of commands to a [`Streaming`](crate::Streaming) run. Dropping it ends the program after
/// the pushed commands.
#[derive(Debug)]
pub struct Feeder {
    supply: Arc<Supply>,
    arm: Arm,
}

impl Feeder {
    /// Creates both ends, for up to `ahead` unfinished commands; at least one.
    pub(super) fn new(arm: &Arm, ahead: usize) -> (Self, RunSupply) {
        let supply = Arc::new(Supply {
            ahead: ahead.max(1) as u64,
            state: Mutex::default(),
            changed: Notify::new(),
        });
        let arm = arm.clone();
        let fed = RunSupply(Arc::clone(&supply));
        (Self { supply, arm }, fed)
    }

    /// Returns how many commands may be pushed now; `None` if the run has ended or takes no more
    /// because a command was refused.
    #[must_use]
    pub fn free(&self) -> Option<usize> {
        let state = self.supply.state();
        let most = state.finished.saturating_add(self.supply.ahead);
        let free = usize::try_from(most.saturating_sub(state.pushed)).unwrap_or(usize::MAX);
        (!state.closed).then_some(free)
    }

    /// Returns the number of finished commands, at the last reading.
    #[must_use]
    pub fn finished(&self) -> u64 {
        self.supply.state().finished
    }

    /// Waits until a command may be pushed; `false` if the run takes no more.
    pub async fn has_room(&self) -> bool {
        loop {
            let changed = self.supply.changed.notified();
            tokio::pin!(changed);
            // Registered before the check, so that no change is missed.
            changed.as_mut().enable();
            match self.free() {
                Some(0) => changed.await,
                free => return free.is_some(),
            }
        }
    }

    /// Pushes the next command. Without [room](Self::free) the command is buffered; after the end
    /// of the run it is dropped.
    pub fn push(&self, command: Set) {
        self.supply.change(|state| {
            state.feeder_idle = false;
            if !state.closed {
                state.pushed += 1;
                state.waiting.push_back(command);
            }
        });
    }

    /// Reports that nothing is ready yet, and waits until the arm has finished a command, at most
    /// 10 ms.
    ///
    /// The clock of an arm in virtual time continues during this call. Without this call the clock
    /// waits up to a second for the next command.
    pub async fn rest(&self) {
        let changed = self.supply.changed.notified();
        tokio::pin!(changed);
        changed.as_mut().enable();
        self.supply.change(|state| state.feeder_idle = true);
        // With a full inbox the task is awake anyway, and asks the supply.
        let _ = self.arm.inner.messages.try_send(Message::Wake);
        // Either way the caller decides again; there is no outcome to report.
        let _ = timeout(SOURCE_POLL_INTERVAL, changed).await;
        self.supply.change(|state| state.feeder_idle = false);
    }

    /// Ends the program after the pushed commands.
    pub fn end(&self) {
        self.supply.change(|state| state.ended = true);
    }
}

impl Drop for Feeder {
    fn drop(&mut self) {
        self.end();
    }
}
