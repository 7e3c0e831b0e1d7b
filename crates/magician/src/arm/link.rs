//! State of the line to the arm.

use std::sync::Arc;

use tokio::time::Instant;

use super::Arm;
use crate::{Error, Result};

/// State of the line to the arm.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Link {
    /// The line is open.
    Up,
    /// The line broke.
    Lost {
        /// Time of the loss.
        since: std::time::Instant,
        /// Cause as a sentence: how it broke, or that another arm was found in its place.
        why: Arc<str>,
        /// True if it is being reconnected.
        sought: bool,
    },
    /// The connection has ended.
    Closed,
}

impl Link {
    pub(super) fn lost(since: Instant, why: String, sought: bool) -> Self {
        Self::Lost {
            since: since.into_std(),
            why: why.into(),
            sought,
        }
    }
}

impl Arm {
    /// Returns the state of the line. A silent line counts as up; calls over it end by their
    /// deadlines.
    #[must_use]
    pub fn link(&self) -> Link {
        self.inner.shared.link.borrow().clone()
    }

    /// Waits until the line is up; returns immediately if it is.
    ///
    /// The line is up again once the arm was identified and has reported how far its queue has
    /// come. Nothing is retransmitted: requests in flight at the break have ended with an error,
    /// and the caller has to check the state of the arm before it continues.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if it is not reconnected
    /// ([`Options::reconnect`](crate::Options) is off, or the stream cannot be reopened),
    /// [`ErrorKind::Closed`](crate::ErrorKind::Closed) if the connection ends meanwhile.
    pub async fn reconnected(&self) -> Result<()> {
        let mut link = self.inner.shared.link.subscribe();
        let over = |link: &Link| !matches!(link, Link::Lost { sought: true, .. });
        let link = link.wait_for(over).await.map_err(|_| Error::closed())?;
        match &*link {
            Link::Up => Ok(()),
            Link::Lost { why, .. } => Err(Error::new(crate::ErrorCode::LineLost, &**why)),
            Link::Closed => Err(Error::closed()),
        }
    }
}
