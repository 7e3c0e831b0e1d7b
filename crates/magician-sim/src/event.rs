//! Events of the controller: a bounded log.

use std::collections::VecDeque;

use magician_protocol::Row;

use crate::LinkId;
use crate::fidelity::Assumption;
use crate::world::{Press, WorldEvent};

mod words;

/// Something that happened inside the controller. None of it goes over the wire.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event {
    /// A queued command was taken and given this index.
    Accepted {
        /// Its index in the queue's numbering.
        index: u64,
        /// Its id.
        id: u8,
    },
    /// A queued command came to its turn.
    Started {
        /// Its index.
        index: u64,
        /// Its id.
        id: u8,
    },
    /// A queued command has ended: carried out, refused, cut short or replaced.
    Finished {
        /// Its index.
        index: u64,
        /// Its id.
        id: u8,
    },
    /// Commands that waited were dropped from the queue.
    Dropped {
        /// How many.
        count: usize,
    },
    /// A queued command came when the queue was full; nothing was stored.
    QueueFull {
        /// Its id.
        id: u8,
    },
    /// A queued command was stored as a line of the program and given this index, at which nothing will run.
    Stored {
        /// Its index in the queue's numbering.
        index: u64,
        /// Its id.
        id: u8,
    },
    /// A program has been stored in the flash.
    Downloaded {
        /// Its commands.
        stored: u32,
        /// How many it was said to have.
        announced: u32,
    },
    /// The program in the flash begins or ends.
    Program {
        /// Whether it runs from now on.
        runs: bool,
    },
    /// What the arm does rests on this from now on; told once.
    Assumes {
        /// What.
        assumption: Assumption,
    },
    /// A command was understood and not carried out.
    Refused {
        /// Its id.
        id: u8,
        /// Why.
        reason: Refusal,
    },
    /// An alarm was raised that did not stand before.
    AlarmRaised {
        /// Its code.
        code: u8,
    },
    /// A pose was out of reach for an arm whose tool bias is 0: it may be in reach of the tool that is really on it.
    ToolUnknown {
        /// The alarm.
        code: u8,
    },
    /// The home point is out of reach: homing ends at the joints at which it ends when none is set.
    HomeOutOfReach,
    /// An alarm no longer stands.
    AlarmCleared {
        /// Its code.
        code: u8,
    },
    /// Something has happened in the world: the tool has taken an object, or touches the table.
    World(WorldEvent),
    /// A joint has slipped: it stands elsewhere than commanded.
    Slipped {
        /// J1 to J4 as 1 to 4.
        joint: u8,
        /// By how much, deg.
        degrees: f64,
    },
    /// The controller has reset: what was queued and set is gone.
    Reset,
    /// The cable was pulled, or plugged in again.
    Cable {
        /// Whether it is in.
        plugged: bool,
    },
    /// The base key was pressed.
    Key {
        /// How.
        press: Press,
    },
    /// The unlock key on the forearm was pressed or released.
    Unlocked {
        /// Whether it is held.
        held: bool,
    },
    /// A command was accepted, stored and answered, but this simulation does not act on it, or only in part. Told once
    /// a row and power-up: a drawing is a hundred thousand of them. [`ControllerState::not_simulated`](crate::ControllerState::not_simulated)
    /// counts them all.
    NotSimulated {
        /// The command's row.
        row: &'static Row,
    },
    /// Bytes that looked like a frame were damaged; they had no effect and no answer.
    BadFrame {
        /// Where they came from.
        link: LinkId,
    },
    /// A frame with an id that the Magician does not have; it had no answer.
    UnknownId {
        /// Where it came from.
        link: LinkId,
        /// The id.
        id: u8,
    },
    /// A request was dropped because its peer has not taken the replies that wait for it.
    Overrun {
        /// The peer's link.
        link: LinkId,
    },
}

/// Why a command was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// Its parameter count fits no accepted form (errata E11).
    Parameters,
    /// Its motion cannot be planned; an alarm says why.
    Unplannable,
    /// Its point-to-point mode has no meaning (model section 15a).
    UnknownMode,
    /// A pin, motor or connector that there is not, or a function that the pin does not have.
    Pin,
    /// It waits for an input that there is not, or compares it in a way that has no meaning.
    Trigger,
    /// It moves the arm while a hand does, or stores a program while one runs.
    Busy,
    /// It sets the pose while the arm moves, or to angles that make no sense.
    Pose,
    /// What the real arm would do is not known, and the profile is strict.
    OnlyAChoice(Assumption),
}

/// The latest events; when it is full the oldest goes and is counted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    events: VecDeque<Event>,
    /// How many there have been.
    pushed: u64,
    lost: u64,
    not_simulated: NotSimulated,
}

/// The commands that this simulation did not act on.
#[derive(Clone, Debug, Default)]
struct NotSimulated {
    count: u64,
    /// A bit for each id that has been told.
    told: [u64; 4],
}

impl NotSimulated {
    /// Counts one; whether it is the first of its id.
    fn count(&mut self, id: u8) -> bool {
        self.count = self.count.saturating_add(1);
        let bit = 1 << (id % 64);
        let Some(told) = self.told.get_mut(usize::from(id / 64)) else {
            return true;
        };
        let new = *told & bit == 0;
        *told |= bit;
        new
    }
}

impl Log {
    const CAPACITY: usize = 256;

    pub(crate) fn push(&mut self, event: Event) {
        if self.events.len() >= Self::CAPACITY {
            self.events.pop_front();
            self.lost = self.lost.saturating_add(1);
        }
        self.events.push_back(event);
        self.pushed += 1;
    }

    /// Counts a command that this simulation does not act on, and tells it if its row is new.
    pub(crate) fn not_simulated(&mut self, row: &'static Row) {
        if self.not_simulated.count(row.id) {
            self.push(Event::NotSimulated { row });
        }
    }

    pub(crate) fn count_not_simulated(&self) -> u64 {
        self.not_simulated.count
    }

    pub(crate) fn pop(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }

    /// The events that wait, oldest first, each with its number since power-up.
    pub(crate) fn waiting(&self) -> impl Iterator<Item = (u64, Event)> {
        let first = self.pushed - self.events.len() as u64;
        (first..).zip(self.events.iter().copied())
    }
}
