//! The controller's event log, bounded in size.

use std::collections::VecDeque;

use magician_protocol::Row;

use crate::LinkId;
use crate::fidelity::Assumption;
use crate::world::{Press, WorldEvent};

mod words;

/// An event inside the controller. The protocol does not report events.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event {
    /// A command was accepted into the queue and got this index.
    Accepted {
        /// Index in the queue's numbering.
        index: u64,
        /// Command id.
        id: u8,
    },
    /// A queued command started.
    Started {
        /// Index in the queue's numbering.
        index: u64,
        /// Command id.
        id: u8,
    },
    /// A queued command finished: carried out, refused, cut short or replaced.
    Finished {
        /// Index in the queue's numbering.
        index: u64,
        /// Command id.
        id: u8,
    },
    /// Waiting commands were dropped from the queue.
    Dropped {
        /// Number of commands.
        count: usize,
    },
    /// A queued command arrived while the queue was full; it was not stored.
    QueueFull {
        /// Command id.
        id: u8,
    },
    /// A queued command was stored as a line of a program. Nothing will run at its index.
    Stored {
        /// Index in the queue's numbering.
        index: u64,
        /// Command id.
        id: u8,
    },
    /// A program was stored in the flash.
    Downloaded {
        /// Number of stored commands.
        stored: u32,
        /// Number of commands announced by the host.
        announced: u32,
    },
    /// The stored program started or ended.
    Program {
        /// True if it started.
        runs: bool,
    },
    /// An answer or an action relied on this assumption for the first time.
    Assumes {
        /// The assumption.
        assumption: Assumption,
    },
    /// A command was understood but not carried out.
    Refused {
        /// Command id.
        id: u8,
        /// Reason of the refusal.
        reason: Refusal,
    },
    /// An alarm was raised that was not active before.
    AlarmRaised {
        /// Alarm code.
        code: u8,
    },
    /// A pose was out of reach with a tool bias of 0; with the tool actually mounted it may be in
    /// reach.
    ToolUnknown {
        /// Code of the alarm raised.
        code: u8,
    },
    /// The home point is out of reach: homing ends at the default joints (model section 15a).
    HomeOutOfReach,
    /// An alarm is no longer active.
    AlarmCleared {
        /// Alarm code.
        code: u8,
    },
    /// An event in the world, such as the tool picking an object or touching the table.
    World(WorldEvent),
    /// A joint slipped: its true angle now differs from the commanded one.
    Slipped {
        /// Joint, 1 to 4 for J1 to J4.
        joint: u8,
        /// Angle of the slip, deg.
        degrees: f64,
    },
    /// The controller was reset: queue and settings are lost.
    Reset,
    /// The cable was pulled or plugged in again.
    Cable {
        /// True if it is plugged in.
        plugged: bool,
    },
    /// The base key was pressed.
    Key {
        /// Short or long press.
        press: Press,
    },
    /// The unlock key on the forearm was pressed or released.
    Unlocked {
        /// True while the key is held.
        held: bool,
    },
    /// A command was accepted, stored and answered, but is not simulated, or only in part.
    ///
    /// Reported once for each row and power-up, because a drawing may contain a hundred thousand of
    /// them. [`ControllerState::not_simulated`](crate::ControllerState::not_simulated) counts all.
    NotSimulated {
        /// Row of the command.
        row: &'static Row,
    },
    /// A damaged frame was ignored and not answered.
    BadFrame {
        /// Link of the frame.
        link: LinkId,
    },
    /// A frame had an id that a Magician does not know; it was not answered.
    UnknownId {
        /// Link of the frame.
        link: LinkId,
        /// The unknown id.
        id: u8,
    },
    /// A request was dropped because its peer does not read its pending replies.
    Overrun {
        /// Link of the peer.
        link: LinkId,
    },
}

/// Reason why a command was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// The parameter count matches no accepted form (errata E11).
    Parameters,
    /// The motion cannot be planned; an alarm gives the reason.
    Unplannable,
    /// The point-to-point mode is undefined (model section 15a).
    UnknownMode,
    /// The pin, motor or connector does not exist, or the pin lacks the function.
    Pin,
    /// The input does not exist, or the comparison is undefined.
    Trigger,
    /// A motion while the unlock key is held, or a program download while a program runs.
    Busy,
    /// A pose set during a motion, or to impossible angles.
    Pose,
    /// The behaviour of a real arm is unknown, and the profile is strict.
    OnlyAChoice(Assumption),
}

/// The latest events. When full, the oldest is dropped and counted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    events: VecDeque<Event>,
    /// Number of events since power-up.
    pushed: u64,
    lost: u64,
    not_simulated: NotSimulated,
}

/// Counts the commands without a simulation.
#[derive(Clone, Debug, Default)]
struct NotSimulated {
    count: u64,
    /// Bit set of the reported ids.
    told: [u64; 4],
}

impl NotSimulated {
    /// Counts one command and returns true for the first of its id.
    fn count(&mut self, id: u8) -> bool {
        self.count = self.count.saturating_add(1);
        let bit = 1 << (id % 64);
        let Some(told) = self.told.get_mut(usize::from(id / 64)) else {
            // Unreachable: the array has a bit for each of 256 ids.
            return true;
        };
        let new = *told & bit == 0;
        *told |= bit;
        new
    }
}

impl Log {
    // A choice: room for the events of many requests, and a bound for callers that never poll.
    const CAPACITY: usize = 256;

    pub(crate) fn push(&mut self, event: Event) {
        // The newest events explain the present state, so the oldest go first.
        if self.events.len() >= Self::CAPACITY {
            self.events.pop_front();
            self.lost = self.lost.saturating_add(1);
        }
        self.events.push_back(event);
        self.pushed += 1;
    }

    /// Counts a command without a simulation, and logs it if its row is new.
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

    /// Pending events, oldest first, each with its number since power-up.
    pub(crate) fn waiting(&self) -> impl Iterator<Item = (u64, Event)> {
        let first = self.pushed - self.events.len() as u64;
        (first..).zip(self.events.iter().copied())
    }
}
