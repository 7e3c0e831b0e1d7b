//! Policies: the effect of a signal, an error and a successful end of a verb on the arm. A verb
//! gets an arm only by choosing one.
//!
//! Common to all policies:
//!
//! * **Ctrl-C, SIGTERM, SIGHUP**: the work is dropped. If this connection moves the arm
//!   ([`Arm::moving`]) or runs a motor, or if [`Untracked`] notes something, the arm is stopped:
//!   motion, queue, laser, motors. Changed settings are restored, and the program waits until the
//!   arm stands. A second stop ([`StopRule`]) moves nothing more, but settings are still restored.
//!   A shell keeps its connection and continues, except after SIGTERM and SIGHUP.
//! * **An error**: changed settings are restored. When the connection ends (a shell's ends with the
//!   shell) the driver stops what it started and switches the laser off.
//! * **Success**: motions that were started continue. A laser that this connection lit is switched
//!   off once none of its motions is left. A motor that keeps running is named, with the command
//!   that stops it.
//! * A jog never continues: `set`, `enqueue` and a shell refuse a jog that nothing holds.
//!
//! Each policy says what differs. `policy/tests.rs` lists the policies of every verb and fails for
//! an unlisted verb.
//!
//! [`Arm::moving`]: magician::Arm::moving
//! [`StopRule`]: magician_job::StopRule

use super::Context;
use crate::saved::Access;

/// Policy for [`Context::arm`](super::Context::arm), where a signal drops the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StopPolicy {
    /// Reads and changes nothing: `pose`, `get`, `queue status`, the look of a job before it runs.
    Look,
    /// Like [`Look`](Self::Look), but for a long time, so the driver reconnects a broken line.
    /// `watch`.
    Watch,
    /// Sends commands that are done once they are answered, or whose motion the driver tracks:
    /// `set`, `suction`, `enqueue`.
    Order,
    /// Starts a motion that outlasts the verb and that the driver cannot track: a queue that other
    /// programs filled, or a move without a wait. A signal during a later line of the same shell
    /// stops it. `queue start`, `move --no-wait`.
    HandOver,
    /// Moves, and waits until the arm stands. A signal stops the arm from the beginning, even while
    /// the move is only planned. `move`, `home`, `demo`.
    Move,
    /// Like [`Move`](Self::Move), but controlled by keys; the driver reconnects a broken line.
    /// `jog`, `teach`, `calibrate`.
    Pad,
    /// Lights the laser for longer than the verb. A signal switches it off. `laser on` in a shell;
    /// `set` and `io` where they may burn.
    Light(BurnEnd),
    /// Switches the laser off, before anything else is done: `laser off`.
    Darken,
    /// Stops the arm, before anything else is done, so that a signal has nothing left to stop:
    /// `stop`.
    Stop,
    /// Lets the current command finish and holds the rest, before anything else is done: `stop
    /// --gentle`.
    Hold,
}

/// End of a burn that outlasts its verb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BurnEnd {
    /// Until the connection, a shell's, ends. A signal during a later line switches it off.
    WhileConnected,
    /// Beyond the end of the program, because the user asked for that or no shell keeps the
    /// connection. Only an error or `laser off` switches it off.
    UntilSwitchedOff,
}

/// Policy for [`Context::until_signal`](super::Context::until_signal), where a signal is the
/// regular end of the work: the work is notified and completes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SignalPolicy {
    /// Records until then: `record`.
    Record,
    /// Keeps the laser burning until then. The driver reconnects a broken line, to switch it off.
    /// `laser on`.
    Burn,
}

/// Policy for [`Context::job`](super::Context::job): the job receives the signals, stops by itself
/// (pen up, place kept) and reports whether the arm stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JobPolicy {
    /// The job cannot burn.
    Dark,
    /// The job may burn: the driver reconnects a broken line, to switch the laser off.
    Burning,
}

/// Effects of a policy, as flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rules {
    /// True if the arm counts as moving from the beginning, whatever the driver knows.
    moves: bool,
    /// True if the laser counts as lit from the beginning.
    lights: bool,
    /// True if the driver reconnects a broken line.
    pub(super) reconnects: bool,
    /// State that a successful end leaves.
    pub(super) end: End,
}

/// State that a successful end of the work leaves of what it started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// Everything continues.
    Continues,
    /// The arm stands.
    Standing,
    /// The laser is off.
    LaserOff,
    /// The laser burns on, also after the connection.
    LaserOn,
    /// The arm stands and the laser is off.
    Stopped,
}

const READ_RULES: Rules = Rules {
    moves: false,
    lights: false,
    reconnects: false,
    end: End::Continues,
};

const MOTION_RULES: Rules = Rules {
    moves: true,
    end: End::Standing,
    ..READ_RULES
};

const LASER_RULES: Rules = Rules {
    lights: true,
    ..READ_RULES
};

impl StopPolicy {
    /// Returns `Order` if the verb changes something, otherwise `Look`.
    pub(crate) const fn order_if(changes: bool) -> Self {
        if changes { Self::Order } else { Self::Look }
    }

    /// Returns the policy of a verb that lights the laser directly: until the end of a shell,
    /// otherwise for good.
    pub(crate) fn lights(context: &Context) -> Self {
        Self::Light(if context.in_shell() {
            BurnEnd::WhileConnected
        } else {
            BurnEnd::UntilSwitchedOff
        })
    }

    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Look | Self::Order | Self::Hold => READ_RULES,
            Self::Watch => READ_RULES.reconnecting(),
            Self::HandOver => MOTION_RULES.ending(End::Continues),
            Self::Move => MOTION_RULES,
            Self::Pad => MOTION_RULES.reconnecting(),
            Self::Light(BurnEnd::WhileConnected) => LASER_RULES,
            Self::Light(BurnEnd::UntilSwitchedOff) => LASER_RULES.ending(End::LaserOn),
            Self::Darken => READ_RULES.ending(End::LaserOff),
            Self::Stop => READ_RULES.ending(End::Stopped),
        }
    }

    /// Returns what the verb does about settings that ended programs have left changed.
    pub(super) const fn access(self) -> Access {
        match self {
            Self::Look | Self::Watch => Access::Reads,
            Self::Darken | Self::Stop | Self::Hold => Access::Stops,
            Self::Order | Self::HandOver | Self::Move | Self::Pad | Self::Light(_) => Access::Sets,
        }
    }
}

impl SignalPolicy {
    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Record => READ_RULES,
            Self::Burn => LASER_RULES.ending(End::LaserOff).reconnecting(),
        }
    }
}

impl JobPolicy {
    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Dark => MOTION_RULES,
            Self::Burning => MOTION_RULES.reconnecting(),
        }
    }
}

impl Rules {
    const fn reconnecting(self) -> Self {
        Self {
            reconnects: true,
            ..self
        }
    }

    pub(super) const fn ending(self, end: End) -> Self {
        Self { end, ..self }
    }
}

/// Motion and laser that this program started but the driver cannot track: motions queued by other
/// programs, a laser lit for longer than a verb, a move that is only planned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Untracked {
    motion: bool,
    /// End of the burn of a laser that outlasts its verb; `None` if no such laser is lit.
    pub(super) laser: Option<BurnEnd>,
}

impl Untracked {
    pub(super) fn begin(&mut self, rules: &Rules) {
        self.motion |= rules.moves;
        if rules.lights {
            self.laser = Some(BurnEnd::WhileConnected);
        }
    }

    /// Notes that the work has succeeded.
    pub(super) fn note_success(&mut self, end: End) {
        match end {
            End::Continues => {}
            End::Standing => self.motion = false,
            End::LaserOff => self.laser = None,
            End::LaserOn => self.laser = Some(BurnEnd::UntilSwitchedOff),
            End::Stopped => *self = Self::default(),
        }
    }

    /// True if a signal must stop the arm, whatever the driver knows.
    pub(super) fn needs_stop(self) -> bool {
        self.motion || self.laser == Some(BurnEnd::WhileConnected)
    }
}

#[cfg(test)]
mod tests;
