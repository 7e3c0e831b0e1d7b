use std::time::Duration;

use magician::{RawLine, Result};
use tokio::time::{sleep, timeout};

use super::Target;

/// How often an arm is looked at that works by itself.
pub const LINE_LOOK: Duration = Duration::from_millis(10);
/// Longest piece taken from the line at once.
const PIECE: usize = 1024;

/// An arm at the end of a line, real or served, whose clock runs by itself.
pub struct LineTarget(RawLine);

impl LineTarget {
    /// The arm at the end of this line.
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
