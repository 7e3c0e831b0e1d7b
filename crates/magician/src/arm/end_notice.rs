//! The announced end of a line.

use std::future::pending;
use std::sync::Arc;

use tokio::sync::watch;

/// Notice by the program at the other end of a line that it is about to end, while the line still
/// carries: a station that ends gives it, and a job that runs over the line then stops as if a
/// person had stopped it. Clones share it.
///
/// ```
/// use magician::EndNotice;
///
/// let notice = EndNotice::default();
/// let line = notice.clone();
/// line.set(true);
/// assert!(notice.is_given());
/// ```
#[derive(Clone, Debug)]
pub struct EndNotice(Arc<watch::Sender<bool>>);

impl Default for EndNotice {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(false)))
    }
}

impl EndNotice {
    /// Gives the notice, or takes it back: the program at the other end is there again.
    pub fn set(&self, given: bool) {
        self.0.send_replace(given);
    }

    /// True if the line is about to end, or has ended after that was announced.
    #[must_use]
    pub fn is_given(&self) -> bool {
        *self.0.borrow()
    }

    /// Waits until it is given.
    pub async fn given(&self) {
        let mut notice = self.0.subscribe();
        if notice.wait_for(|given| *given).await.is_err() {
            // The sender lives as long as this does.
            pending::<()>().await;
        }
    }
}
