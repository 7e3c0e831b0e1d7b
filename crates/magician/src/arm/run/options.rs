use std::time::Duration;

use crate::QueueIndex;
use crate::preflight::Guards;

/// How [`Arm::run_with`](crate::Arm::run_with) checks and runs commands, and [`Arm::start_with`](crate::Arm::start_with) runs them.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct RunOptions {
    /// What the check of [`Arm::run_with`](crate::Arm::run_with) refuses: all that guards can, at first. What is
    /// [started](crate::Arm::start) is not checked.
    pub guards: Guards,
    /// Sends nothing when a stop came after there were so many ([`Arm::stops`](crate::Arm::stops)): a caller that stopped
    /// the arm while
    /// the commands were still being made or checked meant them too. At first those before the call.
    pub stops: Option<u64>,
    /// Runs commands of an earlier program that still wait in the queue, before these. Off at first.
    pub keep: bool,
    /// Most motion that the arm has in its queue, so that it does not go on for long when this program dies: the arm has
    /// no watchdog. Two commands are in it however long they take. Two seconds at first.
    pub horizon: Duration,
    /// The same while the laser may be lit. One second at first.
    pub laser_horizon: Duration,
    /// Lets an interrupted run go on although the position after its last finished command is unknown. Off by default.
    pub trust_pose: bool,
    /// How long a run waits for an arm that does not answer on a line that is there, until it ends; never less than
    /// [`Options::timeout`](crate::Options::timeout), which is for single calls. Meanwhile
    /// [`Progress::silent`](crate::Progress::silent) tells. What became of a command is found out when the arm answers again,
    /// and nothing is sent twice. Thirty seconds at first.
    pub patience: Duration,
    /// Takes commands from the caller only while those that the arm has not taken last less than this, but for a few, so that
    /// what comes later can still be chosen. Without it, the default, as many are taken as there is room for: some hundred.
    pub lead: Option<Duration>,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            guards: Guards::default(),
            stops: None,
            keep: false,
            horizon: Duration::from_secs(2),
            laser_horizon: Duration::from_secs(1),
            trust_pose: false,
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

/// What a run has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ran {
    /// How many commands the arm took and finished.
    pub commands: u64,
    /// Index of the first.
    pub first: Option<QueueIndex>,
    /// Index of the last.
    pub last: Option<QueueIndex>,
}
