//! Arm at the end of a line.

use std::time::Duration;

use magician::{RawLine, Result};
use tokio::time::{sleep, timeout};

use super::Target;

/// Polling interval of an arm that cannot be stepped. Choice: half a period of the controller.
pub const LINE_LOOK: Duration = Duration::from_millis(10);
/// Most bytes read at once.
const PIECE: usize = 1024;

/// Arm at the end of a line, real or served, whose clock runs freely.
pub struct LineTarget(RawLine);

impl LineTarget {
    /// Creates a target for the arm at the end of this line.
    #[must_use]
    pub fn new(line: RawLine) -> Self {
        Self(line)
    }
}

impl Target for LineTarget {
    async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.0.send(bytes).await
    }

    async fn receive(&mut self, within: Duration) -> Result<Vec<u8>> {
        let mut piece = [0; PIECE];
        match timeout(within, self.0.receive(&mut piece)).await {
            Ok(came) => Ok(piece.get(..came?).unwrap_or_default().to_vec()),
            // Silence is a result here, not an error.
            Err(_) => Ok(Vec::new()),
        }
    }

    async fn pass(&mut self, span: Duration) -> Result<()> {
        sleep(span).await;
        Ok(())
    }

    async fn go_on(&mut self, at_most: Duration) -> Result<()> {
        sleep(LINE_LOOK.min(at_most)).await;
        Ok(())
    }
}
