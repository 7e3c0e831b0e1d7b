//! Announced end of a line.

use std::future::pending;
use std::sync::Arc;

use tokio::sync::watch;

/// Notice from the program at the other end that the line is about to end, while it is still up.
///
/// A station gives it when it shuts down. A job over the line then stops as if a person had stopped
/// it. Clones share the notice.
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
    /// Gives the notice, or withdraws it when the program at the other end is back.
    pub fn set(&self, given: bool) {
        self.0.send_replace(given);
    }

    /// True if the line is about to end, or has ended as announced.
    #[must_use]
    pub fn is_given(&self) -> bool {
        *self.0.borrow()
    }

    /// Waits until the notice is given.
    pub async fn given(&self) {
        let mut notice = self.0.subscribe();
        if notice.wait_for(|given| *given).await.is_err() {
            // Unreachable: `self` holds the sender.
            pending::<()>().await;
        }
    }
}
