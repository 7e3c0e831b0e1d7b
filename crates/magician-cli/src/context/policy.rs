//! What an interruption, an error and the good end of a verb do to the arm. A verb gets an arm only by choosing one of these.
//!
//! What holds for all of them:
//!
//! * **Ctrl-C, SIGTERM, SIGHUP**: the work is dropped. If the arm moves because of this connection ([`Arm::moving`]), a motor runs
//!   because of it, or because of what is noted in [`UnderWay`], it is stopped: motion, queue, laser, motors; changed settings are
//!   restored, and the program waits until the arm stands. A second stop ([`StopRule`]) moves nothing more; settings are restored
//!   all the same. A shell keeps its connection and goes on, but for SIGTERM and SIGHUP.
//! * **An error**: changed settings are restored. When the connection ends (a shell's ends with the shell) it stops what it has set going
//!   and switches the laser off.
//! * **The good end**: what was set going goes on. A laser that this connection lit is switched off once nothing of it moves. A
//!   motor that runs on is named, with what stops it.
//! * A jog never goes on: `set`, `enqueue` and a shell refuse one that nothing holds.
//!
//! The policies say what differs. `policy/tests.rs` lists every verb with its own, and fails for one that
//! is not in the list.
//!
//! [`Arm::moving`]: magician::Arm::moving
//! [`StopRule`]: magician_job::StopRule

use super::Context;
use crate::saved::Access;

/// For [`Context::arm`](super::Context::arm): a signal drops the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StopPolicy {
    /// Reads, and changes nothing: `pose`, `get`, `queue status`, what a job looks at before it runs.
    Look,
    /// As [`Look`](Self::Look), for as long as a person looks: a line that breaks is waited for. `watch`.
    Watch,
    /// Orders what is done once it is answered, or what the connection counts itself until it is done: `set`, `suction`,
    /// `enqueue`.
    Order,
    /// Starts a motion that goes on after the verb and that the connection cannot track: a queue that other programs have
    /// filled, a move without a wait. A signal to a later line of the same shell stops it. `queue start`, `move
    /// --no-wait`.
    HandOver,
    /// Moves, and waits until the arm stands. A signal stops it from the beginning, also where the move is only planned yet.
    /// `move`, `home`, `demo`.
    Move,
    /// As [`Move`](Self::Move), by a person at keys: a line that breaks is waited for. `jog`, `teach`, `calibrate`.
    Pad,
    /// Lights the laser for longer than the verb. A signal puts it out. `laser on` in a shell, `set` and `io` where they burn.
    Light(Burns),
    /// Puts the laser out, before anything else is done: `laser off`.
    Darken,
    /// Stops the arm, before anything else is done: nothing is left that a signal could stop. `stop`.
    Stop,
    /// Lets the command under way finish and holds the rest, before anything else is done: `stop --gentle`.
    Hold,
}

/// How long a laser burns that was lit for longer than the verb.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Burns {
    /// To the end of the connection, which is a shell's. A signal to a later line puts it out.
    WhileConnected,
    /// For good: a person asked for that, or only the verb has a connection that could end. Only an error or `laser off`
    /// puts it out.
    ForGood,
}

/// For [`Context::until_told`](super::Context::until_told): a signal is the proper end of the work, which is told and comes to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ToldPolicy {
    /// Reads until then: `record`.
    Record,
    /// Has the laser burn until then. A line that breaks is waited for, to put it out. `laser on`.
    Burn,
}

/// For [`Context::job`](super::Context::job): the job hears the signals, stops by itself (pen up, place kept) and says whether the arm
/// stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JobPolicy {
    /// Burns nothing.
    Dark,
    /// A line that breaks is waited for, to put the laser out.
    Burning,
}

/// What a policy comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rules {
    /// Whether the arm counts as moving from the beginning, whatever the connection knows.
    moves: bool,
    /// Whether the laser counts as lit from the beginning.
    lights: bool,
    /// Whether a line that breaks is waited for.
    pub(super) reconnects: bool,
    /// What the good end leaves.
    pub(super) end: End,
}

/// What the good end of the work leaves of what was set going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// All of it.
    AsBegun,
    /// The arm stands.
    Stands,
    /// The laser is out.
    Dark,
    /// The laser burns, also after the connection.
    Burns,
    /// The arm stands and the laser is out.
    Stopped,
}

const LOOKS: Rules = Rules {
    moves: false,
    lights: false,
    reconnects: false,
    end: End::AsBegun,
};

const MOVES: Rules = Rules {
    moves: true,
    end: End::Stands,
    ..LOOKS
};

const LIGHTS: Rules = Rules {
    lights: true,
    ..LOOKS
};

impl StopPolicy {
    /// That of a verb which only then changes something.
    pub(crate) const fn order_if(changes: bool) -> Self {
        if changes { Self::Order } else { Self::Look }
    }

    /// That of a verb which lights the laser by a command of its own: to the end of a shell, else for good.
    pub(crate) fn lights(context: &Context) -> Self {
        Self::Light(if context.in_shell() {
            Burns::WhileConnected
        } else {
            Burns::ForGood
        })
    }

    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Look | Self::Order | Self::Hold => LOOKS,
            Self::Watch => LOOKS.reconnecting(),
            Self::HandOver => MOVES.ending(End::AsBegun),
            Self::Move => MOVES,
            Self::Pad => MOVES.reconnecting(),
            Self::Light(Burns::WhileConnected) => LIGHTS,
            Self::Light(Burns::ForGood) => LIGHTS.ending(End::Burns),
            Self::Darken => LOOKS.ending(End::Dark),
            Self::Stop => LOOKS.ending(End::Stopped),
        }
    }

    /// What comes of the settings that ended programs have left changed.
    pub(super) const fn access(self) -> Access {
        match self {
            Self::Look | Self::Watch => Access::Reads,
            Self::Darken | Self::Stop | Self::Hold => Access::Stops,
            Self::Order | Self::HandOver | Self::Move | Self::Pad | Self::Light(_) => Access::Sets,
        }
    }
}

impl ToldPolicy {
    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Record => LOOKS,
            Self::Burn => LIGHTS.ending(End::Dark).reconnecting(),
        }
    }
}

impl JobPolicy {
    pub(super) const fn rules(self) -> Rules {
        match self {
            Self::Dark => MOVES,
            Self::Burning => MOVES.reconnecting(),
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

/// What was set going over a connection that the connection cannot know of: what earlier programs queued, a laser, a move that is
/// only planned yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct UnderWay {
    motion: bool,
    /// How long the laser burns that was lit for longer than a verb.
    pub(super) laser: Option<Burns>,
}

impl UnderWay {
    pub(super) fn begins(&mut self, rules: &Rules) {
        self.motion |= rules.moves;
        if rules.lights {
            self.laser = Some(Burns::WhileConnected);
        }
    }

    /// The work has come to its good end.
    pub(super) fn ends(&mut self, end: End) {
        match end {
            End::AsBegun => {}
            End::Stands => self.motion = false,
            End::Dark => self.laser = None,
            End::Burns => self.laser = Some(Burns::ForGood),
            End::Stopped => *self = Self::default(),
        }
    }

    /// Whether a signal stops the arm, whatever the connection knows.
    pub(super) fn needs_stop(self) -> bool {
        self.motion || self.laser == Some(Burns::WhileConnected)
    }
}

#[cfg(test)]
mod tests;
