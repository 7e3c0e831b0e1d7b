//! Values that the driver does not watch, polled by a task.

use std::future::Future;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Duration, MissedTickBehavior, interval};

/// Value that a task polls until this is dropped. A slow reading blocks no reader.
#[derive(Debug)]
pub struct Polled<T> {
    latest: watch::Receiver<Option<T>>,
    task: JoinHandle<()>,
}

impl<T: Clone + Send + Sync + 'static> Polled<T> {
    /// Starts polling; must be called within a runtime. A reading of `None` is skipped.
    pub fn every<F, R>(period: Duration, mut read: F) -> Self
    where
        F: FnMut() -> R + Send + 'static,
        R: Future<Output = Option<T>> + Send,
    {
        let (tell, latest) = watch::channel(None);
        let task = tokio::spawn(async move {
            let mut ticks = interval(period);
            // After a slow reading wait a full period, instead of reading several times in a row.
            ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
            loop {
                ticks.tick().await;
                if let Some(read) = read().await {
                    tell.send_replace(Some(read));
                }
            }
        });
        Self { latest, task }
    }

    /// Waits for the next reading.
    pub async fn next(&mut self) -> T {
        loop {
            // The task is gone with its runtime: no reading will come.
            if self.latest.changed().await.is_err() {
                std::future::pending::<()>().await;
            }
            let read = self.latest.borrow_and_update().clone();
            if let Some(read) = read {
                return read;
            }
        }
    }
}

impl<T> Drop for Polled<T> {
    fn drop(&mut self) {
        self.task.abort();
    }
}
