//! Fair queueing between senders: one busy sender delays the others by a bounded number of turns.
//!
//! A station runs on one thread. A sender that pipelines requests or keeps its socket full would
//! hold that thread, and a stop of another client would wait. So everything that a sender can
//! trigger back to back (bytes, pipelined requests, messages of a socket) first takes a turn
//! (`FairTurns`).
//!
//! Turns are given round robin by sender, not by connection: opening more connections gains
//! nothing. The task that hands out turns yields after each one, so everything else that is ready,
//! the arms included, runs in between, and new input is polled. A sender that is alone waits only
//! until that task runs.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

#[cfg(feature = "http")]
use tokio::sync::oneshot;
#[cfg(feature = "http")]
use tokio::task::yield_now;

/// Round-robin queue: one item of each sender per round, oldest first within a sender.
#[derive(Debug)]
struct FairQueue<K, T> {
    /// Senders with items, in the order of their next turn.
    round: VecDeque<K>,
    items: BTreeMap<K, VecDeque<T>>,
}

impl<K, T> Default for FairQueue<K, T> {
    fn default() -> Self {
        Self {
            round: VecDeque::new(),
            items: BTreeMap::new(),
        }
    }
}

impl<K: Clone + Ord, T> FairQueue<K, T> {
    fn push(&mut self, sender: K, item: T) {
        let items = self.items.entry(sender.clone()).or_default();
        if items.is_empty() {
            self.round.push_back(sender);
        }
        items.push_back(item);
    }

    fn pop(&mut self) -> Option<T> {
        let sender = self.round.pop_front()?;
        let items = self.items.get_mut(&sender)?;
        let item = items.pop_front();
        if items.is_empty() {
            // A sender without items keeps no entry, so memory follows the number of waiting
            // senders.
            drop(self.items.remove(&sender));
        } else {
            self.round.push_back(sender);
        }
        item
    }
}

/// Shared fair queue, served by one task as long as it holds items. Clones share the queue.
///
/// A separate task serves the queue, never a waiting task: a waiting task can stay unpolled for a
/// long time and would delay the others.
#[derive(Debug)]
pub(crate) struct FairLine<K, T>(Arc<Mutex<Line<K, T>>>);

#[derive(Debug)]
struct Line<K, T> {
    is_served: bool,
    waiting: FairQueue<K, T>,
}

impl<K, T> Clone for FairLine<K, T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<K, T> Default for FairLine<K, T> {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(Line {
            is_served: false,
            waiting: FairQueue::default(),
        })))
    }
}

impl<K: Clone + Ord, T> FairLine<K, T> {
    /// Adds an item. Returns true if no task serves the queue: then the caller must serve it until
    /// [`pop`](Self::pop) returns `None`.
    pub(crate) fn push(&self, sender: K, item: T) -> bool {
        let mut line = self.lock();
        line.waiting.push(sender, item);
        !std::mem::replace(&mut line.is_served, true)
    }

    /// Takes the next item. `None` if the queue is empty, which ends the serving.
    pub(crate) fn pop(&self) -> Option<T> {
        let mut line = self.lock();
        let next = line.waiting.pop();
        // Cleared under the lock, so that a concurrent push starts the next server.
        line.is_served = next.is_some();
        next
    }

    fn lock(&self) -> MutexGuard<'_, Line<K, T>> {
        // After a panic elsewhere the queue is still consistent: it holds whole values.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Source of turns for senders. Clones share the turns.
#[cfg(feature = "http")]
#[derive(Clone, Debug)]
pub(crate) struct FairTurns<K>(FairLine<K, oneshot::Sender<()>>);

#[cfg(feature = "http")]
impl<K> Default for FairTurns<K> {
    fn default() -> Self {
        Self(FairLine::default())
    }
}

#[cfg(feature = "http")]
impl<K: Clone + Ord + Send + 'static> FairTurns<K> {
    /// Waits for the turn of this sender. All tasks that were ready at the previous turn have run
    /// by then.
    pub(crate) async fn turn(&self, sender: K) {
        let (call, called) = oneshot::channel();
        if self.0.push(sender, call) {
            let line = self.0.clone();
            tokio::spawn(async move {
                while let Some(next) = line.pop() {
                    // A caller that was dropped takes no turn, so it costs no yield.
                    if next.send(()).is_ok() {
                        yield_now().await;
                    }
                }
            });
        }
        // Fails only when the runtime shuts down; then there is nothing left to wait for.
        let _ = called.await;
    }
}

#[cfg(all(test, feature = "http"))]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::task::Poll;

    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use tokio::runtime::Builder;
    use tokio::task::JoinSet;

    use super::*;

    /// Current-thread runtime, as used by a station.
    fn run<T>(future: impl Future<Output = T>) -> T {
        Builder::new_current_thread()
            .build()
            .unwrap()
            .block_on(future)
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn sender_waits_for_one_item_of_each_other_sender(
            others in vec(1..6_u8, 0..200), more in vec(1..6_u8, 0..200),
        ) {
            let mut queue = FairQueue::default();
            others.iter().for_each(|sender| queue.push(*sender, false));
            queue.push(0, true);
            more.iter().for_each(|sender| queue.push(*sender, false));
            let turns = std::iter::from_fn(|| queue.pop()).position(|own| own);
            prop_assert!(turns.unwrap() <= 5, "{turns:?}");
        }

        #[test]
        fn items_are_popped_once_in_sender_order(
            pushed in vec((0..5_u8, any::<bool>()), 0..200),
        ) {
            let mut queue = FairQueue::default();
            let mut taken = Vec::new();
            for (number, (sender, take)) in pushed.iter().enumerate() {
                queue.push(*sender, (*sender, number));
                taken.extend(take.then(|| queue.pop()).flatten());
            }
            taken.extend(std::iter::from_fn(|| queue.pop()));
            prop_assert_eq!(taken.len(), pushed.len());
            for sender in 0..5 {
                let numbers = taken.iter().filter(|(of, _)| *of == sender);
                prop_assert!(numbers.is_sorted());
            }
        }

        /// Senders that never pause, each with several connections, and a newcomer at any time.
        #[test]
        fn newcomer_is_served_within_one_turn_of_each_busy_sender(
            connections in vec(1..20_u8, 1..8), begun in 0..200_usize,
        ) {
            let senders = connections.len();
            let waited = run(async move {
                let (turns, served) = (FairTurns::default(), Arc::new(AtomicUsize::new(0)));
                let mut busy = JoinSet::new();
                for (sender, connections) in connections.into_iter().enumerate() {
                    for _ in 0..connections {
                        let (turns, served) = (turns.clone(), Arc::clone(&served));
                        busy.spawn(async move {
                            loop {
                                turns.turn(sender).await;
                                served.fetch_add(1, Ordering::Relaxed);
                            }
                        });
                    }
                }
                while served.load(Ordering::Relaxed) < begun {
                    yield_now().await;
                }
                let before = served.load(Ordering::Relaxed);
                turns.turn(usize::MAX).await;
                served.load(Ordering::Relaxed) - before
            });
            // The sender being served, and one turn of each other sender.
            prop_assert!(waited <= senders + 1, "{waited} turns of {senders} senders");
        }

        /// Tasks that take no turns are not delayed by them.
        #[test]
        fn task_with_many_steps_takes_one_turn_per_step(hops in 1..40_usize, connections in 1..200_u16) {
            let served = run(async move {
                let (turns, served) = (FairTurns::default(), Arc::new(AtomicUsize::new(0)));
                let mut busy = JoinSet::new();
                for _ in 0..connections {
                    let (turns, served) = (turns.clone(), Arc::clone(&served));
                    busy.spawn(async move {
                        loop {
                            turns.turn(0).await;
                            served.fetch_add(1, Ordering::Relaxed);
                        }
                    });
                }
                yield_now().await;
                let before = served.load(Ordering::Relaxed);
                for _ in 0..hops {
                    yield_now().await;
                }
                served.load(Ordering::Relaxed) - before
            });
            prop_assert!(served <= hops + 1, "{served} turns in {hops} steps");
        }
    }

    #[test]
    fn abandoned_turn_blocks_no_other_sender() {
        run(async {
            let turns = FairTurns::default();
            let mut idle = Box::pin(turns.turn(0));
            let mut gone = Box::pin(turns.turn(1));
            for turn in [&mut idle, &mut gone] {
                let polled = std::future::poll_fn(|cx| Poll::Ready(turn.as_mut().poll(cx)));
                assert!(polled.await.is_pending());
            }
            drop(gone);
            // The first sender was called by now but is never polled, so it does not notice.
            for _ in 0..10 {
                turns.turn(2).await;
            }
            idle.await;
        });
    }
}
