//! Whether there is a line to the arm.

use std::sync::Arc;

use tokio::time::Instant;

use super::Arm;
use crate::{Error, Result};

/// Whether there is a line to the arm.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Link {
    /// There is.
    Up,
    /// It broke.
    Lost {
        /// When.
        since: std::time::Instant,
        /// What is wrong, in a sentence: how it broke, or that another arm was found in its place.
        why: Arc<str>,
        /// Whether it is looked for again.
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
    /// How the line to the arm stands at present. A line that says nothing is up; the calls over it end by their
    /// deadlines.
    #[must_use]
    pub fn link(&self) -> Link {
        self.inner.shared.link.borrow().clone()
    }

    /// Waits until the line is up again, at once when it is up.
    ///
    /// It is up again when the arm at its end has told that it is the same one and how far its queue has come.
    /// Nothing is sent again by itself: what was under way when the line broke has ended with an error, and it is the
    /// caller's to look at the arm and to go on.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when it is not looked for ([`Options::reconnect`](crate::Options),
    /// or a stream that cannot be opened again), [`ErrorKind::Closed`](crate::ErrorKind::Closed) when the connection
    /// ends meanwhile.
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
