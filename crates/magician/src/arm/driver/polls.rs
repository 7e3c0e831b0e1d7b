//! Reading for watches of the state.

use magician_protocol::NoArgs;
use magician_protocol::commands::{
    AlarmsState, GetIoAdc, GetIoDi, GetIoDo, IoAdc, IoDi, IoDo, Pose, QueuedCmdCurrentIndex,
    QueuedCmdLeftSpace,
};
use tokio::time::Instant;

use super::{Driver, To, micros};
use crate::Pin;
use crate::arm::shared::held;
use crate::connection::{Micros, Request};

/// Reads of the state before the pins.
const READS: usize = 4;
/// Those among them whose answers seldom change: while no command has ended each round reads one of them in turn, as long as neither
/// gets older than this. When one has ended, the round reads both: its index is reported with the alarms and the room after it.
const SELDOM: [usize; 2] = [2, 3];
const OLDEST: Micros = 100_000;
/// How long an answer may take. Nothing else is read for the onlookers meanwhile.
const PATIENCE: Micros = 1_000_000;

/// Whose turn it is to be read. A round reads one thing after the other as soon as the one before was answered: so it is of
/// one moment, and the program wakes for a round and its answers alone.
#[derive(Debug, Default)]
pub(super) struct Polls {
    /// When the next round is due; `None` without watches.
    next: Option<Micros>,
    /// What of a round is read next; 0 between rounds.
    turn: usize,
    /// One has not been answered: a round that is due meanwhile is left out.
    under_way: bool,
    rounds: usize,
    /// What this round has left out.
    left_out: Option<usize>,
    /// The index that was told last; `None` on a line of which nothing was told.
    told: Option<u64>,
}

impl Polls {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.next
    }

    /// The line broke, and what was under way with it.
    pub(super) fn interrupt(&mut self) {
        *self = Self {
            next: self.next,
            ..Self::default()
        };
    }

    /// Goes on to the next read of this round. `ended`: a command has ended since the last round was told.
    fn advance(&mut self, period: Micros, ended: bool, end: usize) {
        self.turn += 1;
        let spared = !ended && period.saturating_mul(2) <= OLDEST;
        if spared && self.turn == SELDOM[self.rounds % SELDOM.len()] {
            self.left_out = Some(self.turn);
            self.turn += 1;
        }
        if ended && self.turn >= end {
            // It has ended since.
            self.turn = self.left_out.take().unwrap_or(self.turn);
        }
    }
}

impl Driver {
    /// Reads what is due for the onlookers, one thing at a time.
    pub(super) fn poll_state(&mut self, now: Micros) {
        let (period, pins) = {
            let watches = held(&self.shared.watches);
            let Some(period) = watches.period() else {
                // What was read long ago is read anew when somebody looks again.
                (self.polls.next, self.polls.turn, self.polls.told) = (None, 0, None);
                return;
            };
            (micros(period).max(1), watches.pins())
        };
        let due = self.polls.next.unwrap_or(now);
        // A new watch may want it sooner.
        let soon = now.saturating_add(period);
        self.polls.next = Some(if due > now {
            due.min(soon)
        } else {
            let next = due.saturating_add(period);
            if next > now { next } else { soon }
        });
        if self.polls.under_way || (self.polls.turn == 0 && due > now) {
            return;
        }
        let Ok(request) = read(self.polls.turn, &pins) else {
            return;
        };
        self.polls.under_way = true;
        let deadline: Instant = self.at(now.saturating_add(PATIENCE));
        self.submit(request, deadline, To::Poll);
    }

    /// A read for the onlookers has ended; what it said was seen as it passed.
    pub(super) fn polled(&mut self) {
        if !std::mem::take(&mut self.polls.under_way) {
            // The round was given up with its line.
            return;
        }
        let (period, pins) = {
            let watches = held(&self.shared.watches);
            (watches.period().map_or(0, micros), watches.pins().len())
        };
        let ended =
            self.polls.told.is_none() || self.polls.told != self.shared.picture().current_index();
        self.polls.advance(period, ended, READS + pins);
        if self.polls.turn >= READS + pins {
            (self.polls.turn, self.polls.left_out) = (0, None);
            self.polls.rounds = self.polls.rounds.wrapping_add(1);
            self.polls.told = self.shared.picture().current_index();
            self.publish_status();
        }
    }
}

fn read(turn: usize, pins: &[Pin]) -> Result<Request, magician_protocol::EncodeError> {
    let Some(pin) = turn.checked_sub(READS).and_then(|at| pins.get(at)) else {
        return match turn {
            1 => Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            2 => Request::get::<QueuedCmdLeftSpace>(&NoArgs),
            3 => Request::get::<AlarmsState>(&NoArgs),
            _ => Request::get::<Pose>(&NoArgs),
        };
    };
    let address = Some(pin.address());
    match pin {
        Pin::Input(_) => Request::get::<IoDi>(&GetIoDi { address }),
        Pin::Output(_) => Request::get::<IoDo>(&GetIoDo { address }),
        Pin::Analog(_) => Request::get::<IoAdc>(&GetIoAdc { address }),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
