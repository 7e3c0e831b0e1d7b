//! Commands that this connection has put into the queue recently, for estimates of how long the
//! queue will run.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::{QueuedCmdIndex, Set};

/// Largest number of commands remembered: more than any queue holds.
const MAX_REMEMBERED_COMMANDS: usize = 512;

/// Kind of a queued command, as far as it matters to the time it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QueuedPace {
    /// Moves the arm.
    Motion,
    /// Moves the arm and the rail, or the rail alone.
    Rail,
    /// Homes the arm; runs even while an alarm holds the queue.
    Home,
    /// Waits for this long.
    Pause(Duration),
    /// Runs a motor beside the arm for this long.
    Motor(Duration),
    /// Waits for an input, without a time limit.
    Trigger,
    /// Takes no time.
    Moment,
}

impl QueuedPace {
    fn of(command: &Set) -> Self {
        match command {
            Set::WaitCmd(wait) => Self::Pause(Duration::from_millis(wait.timeout.into())),
            Set::EMotorS(motor) => {
                let seconds = f64::from(motor.distance) / f64::from(motor.speed).abs();
                // A speed of 0 gives infinity, which counts as no time: such a motor does not turn.
                Self::Motor(Duration::try_from_secs_f64(seconds).unwrap_or_default())
            }
            Set::HomeCmd(_) => Self::Home,
            Set::TrigCmd(_) => Self::Trigger,
            Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_) => Self::Rail,
            other if other.row().effect.moves_arm() => Self::Motion,
            _ => Self::Moment,
        }
    }
}

/// Origin of a queued command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A single call, whose commands run together with later ones.
    Caller,
    /// A run, or a caller that no longer exists. The next caller must not start the commands that
    /// these left in a stopped queue.
    Run,
}

/// Commands that this connection has put into the queue recently.
#[derive(Clone, Debug, Default)]
pub struct OwnCommands {
    commands: VecDeque<(u64, QueuedPace, Origin)>,
    /// True if the queue is empty, so that nothing runs before the next accepted command.
    empty: bool,
    /// Index up to which nothing waits any more.
    base: u64,
}

impl OwnCommands {
    pub(super) fn accepted(&mut self, index: u64, command: &Set, origin: Origin) {
        if self.commands.len() >= MAX_REMEMBERED_COMMANDS {
            self.commands.pop_front();
        }
        self.commands
            .push_back((index, QueuedPace::of(command), origin));
        if std::mem::take(&mut self.empty) {
            self.base = index.saturating_sub(1);
        }
    }

    pub(super) fn queue_is_empty(&mut self) {
        self.empty = true;
    }

    /// Drops all commands.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Number of unfinished commands that may run together with later ones. If the queue is
    /// `running`, all unfinished commands count, else only those of [`Origin::Caller`].
    #[must_use]
    pub fn waiting(&self, current: u64, running: bool) -> u64 {
        let waiting = self.commands.iter();
        let waiting = waiting.filter(|(index, ..)| *index > current);
        waiting
            .filter(|(.., origin)| running || *origin == Origin::Caller)
            .count() as u64
    }

    /// True if the command homes the arm.
    #[must_use]
    pub fn homes(&self, command: QueuedCmdIndex) -> bool {
        let mut latest = self.commands.iter().rev();
        latest.any(|(index, pace, _)| *index == command.0 && *pace == QueuedPace::Home)
    }

    /// Command that runs after this current index. `None` if it may belong to another program.
    #[must_use]
    pub fn running(&self, current: u64) -> Option<QueuedPace> {
        let mut commands = self.commands.iter();
        let (index, pace, _) = commands.find(|(index, ..)| *index > current)?;
        // A Clear drops indices that the current index never reaches. `base` accounts for them.
        let before = current.max(self.base);
        // Indices in between belong to another program, whose command runs first.
        (before.checked_add(1) == Some(*index)).then_some(*pace)
    }
}
