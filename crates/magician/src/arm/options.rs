use std::time::Duration;

/// How a connection behaves.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Every single call to the arm ends after this time at the latest. Waiting for a motion has
    /// deadlines of its own.
    pub timeout: Duration,
    /// Most requests in flight, 1 to 8. More than 1 is for arms of which it is known that they take
    /// requests back to back; `magician doctor` can measure it.
    pub window: usize,
    /// Whether to make sure at the start that an arm answers.
    pub probe: bool,
    /// Whether a line that breaks is looked for again until the connection ends: the same port, and the same arm at
    /// it. Its serial number (and its clock) are read once for that, soon after the start, if it was probed; an arm
    /// that says none, or was not asked yet, cannot be told from another. A stream that was handed over with
    /// [`Arm::over`](crate::Arm::over) cannot be opened again, [`Arm::over_with`](crate::Arm::over_with) can.
    pub reconnect: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            timeout: Duration::from_secs(3),
            window: 1,
            probe: true,
            reconnect: true,
        }
    }
}

impl Options {
    /// Sets [`timeout`](Self::timeout).
    #[must_use]
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Sets [`window`](Self::window).
    #[must_use]
    pub fn window(mut self, window: usize) -> Self {
        self.window = window;
        self
    }

    /// Sets [`probe`](Self::probe).
    #[must_use]
    pub fn probe(mut self, probe: bool) -> Self {
        self.probe = probe;
        self
    }
    /// Sets [`reconnect`](Self::reconnect).
    #[must_use]
    pub fn reconnect(mut self, reconnect: bool) -> Self {
        self.reconnect = reconnect;
        self
    }
}
