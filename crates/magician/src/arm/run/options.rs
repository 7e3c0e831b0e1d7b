//! Options and result of a run.

use std::time::Duration;

use crate::QueueIndex;
use crate::preflight::Guards;

/// Options of [`Arm::run_with`](crate::Arm::run_with) and
/// [`Arm::start_with`](crate::Arm::start_with).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct RunOptions {
    /// Guards of the check in [`Arm::run_with`](crate::Arm::run_with); by default all that need no
    /// setup. [Started](crate::Arm::start) commands are not checked.
    pub guards: Guards,
    /// Stop count ([`Arm::stops`](crate::Arm::stops)) after which nothing is sent; by default the
    /// count at the call.
    ///
    /// For a caller that computes or checks commands before it runs them: with the count from
    /// before, a stop in between prevents the run.
    pub stops: Option<u64>,
    /// True if waiting commands of an earlier program run first; false by default.
    pub keep: bool,
    /// Longest motion held in the arm's queue. The arm has no watchdog, so this motion continues if
    /// this process dies. Two seconds by default. Two commands are queued regardless of their
    /// duration.
    pub horizon: Duration,
    /// Same limit while the laser may be lit; one second by default.
    pub laser_horizon: Duration,
    /// True if an interrupted run may continue without a known position after its last finished
    /// command; false by default.
    pub trust_pose: bool,
    /// Time for which a run waits for a silent arm on an open line; thirty seconds by default, and
    /// at least [`Options::timeout`](crate::Options::timeout), which is for single calls.
    ///
    /// [`Progress::silent`](crate::Progress::silent) reports the silence. When the arm answers
    /// again, the run finds out what became of its commands; nothing is sent twice.
    pub patience: Duration,
    /// Longest duration of the commands ahead of the arm. Beyond it no command is taken from the
    /// source, so that later commands can still be chosen.
    ///
    /// `None` (default) takes as many commands as there is room for, about a hundred. A few
    /// commands are taken regardless.
    pub lead: Option<Duration>,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            guards: Guards::default(),
            stops: None,
            keep: false,
            // Choice: covers a pause of the host, and is little motion if it dies.
            horizon: Duration::from_secs(2),
            // Choice: shorter, because a laser that burns on unattended is worse than a motion.
            laser_horizon: Duration::from_secs(1),
            trust_pose: false,
            // Choice: a network or an adapter that recovers within half a minute does not ruin a
            // long job.
            patience: Duration::from_secs(30),
            lead: None,
        }
    }
}

impl RunOptions {
    /// Sets [`guards`](Self::guards).
    #[must_use]
    pub fn guards(mut self, guards: Guards) -> Self {
        self.guards = guards;
        self
    }

    /// Sets [`stops`](Self::stops).
    #[must_use]
    pub fn unless_stopped_since(mut self, stops: u64) -> Self {
        self.stops = Some(stops);
        self
    }

    /// Sets [`keep`](Self::keep).
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.keep = keep;
        self
    }

    /// Sets [`horizon`](Self::horizon).
    #[must_use]
    pub fn horizon(mut self, horizon: Duration) -> Self {
        self.horizon = horizon;
        self
    }

    /// Sets [`laser_horizon`](Self::laser_horizon).
    #[must_use]
    pub fn laser_horizon(mut self, horizon: Duration) -> Self {
        self.laser_horizon = horizon;
        self
    }

    /// Sets [`trust_pose`](Self::trust_pose).
    #[must_use]
    pub fn trust_pose(mut self, trust: bool) -> Self {
        self.trust_pose = trust;
        self
    }

    /// Sets [`patience`](Self::patience).
    #[must_use]
    pub fn patience(mut self, patience: Duration) -> Self {
        self.patience = patience;
        self
    }

    /// Sets [`lead`](Self::lead).
    #[must_use]
    pub fn lead(mut self, lead: impl Into<Option<Duration>>) -> Self {
        self.lead = lead.into();
        self
    }
}

/// Result of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RunSummary {
    /// Number of commands that the arm accepted and finished.
    pub commands: u64,
    /// Index of the first command.
    pub first: Option<QueueIndex>,
    /// Index of the last command.
    pub last: Option<QueueIndex>,
}
