//! Polling for state watches.
//!
//! A round reads the pose, the index, free places, alarms and the watched pins, each as soon as the
//! one before was answered. So its values belong to one moment, and the process wakes only for a
//! round and its answers. Free places and alarms seldom change while no command finishes, so rounds
//! take turns to read one of them.

use magician_protocol::NoArgs;
use magician_protocol::commands::{
    AlarmsState, GetIoAdc, GetIoDi, GetIoDo, IoAdc, IoDi, IoDo, Pose, QueuedCmdCurrentIndex,
    QueuedCmdLeftSpace,
};
use tokio::time::Instant;

use super::{Driver, ReplyTarget, micros};
use crate::Pin;
use crate::arm::shared::lock;
use crate::connection::{Micros, Request};

/// State reads that precede the pins.
const STATE_READS: usize = 4;
/// Reads that seldom change their answer (left space, alarms): while no command finishes, each
/// round reads one of them in turn, as long as neither gets older than [`MAX_READ_AGE`]. After a
/// command has finished, the round reads both, so that its index is published with the free places
/// and alarms read after it.
const ALTERNATING_READS: [usize; 2] = [2, 3];
const MAX_READ_AGE: Micros = 100_000;
/// Longest time for an answer. No other state is read meanwhile.
const ANSWER_TIMEOUT: Micros = 1_000_000;

/// Progress of the current round.
#[derive(Debug, Default)]
pub(super) struct Polls {
    /// Time of the next round; `None` without watches.
    next: Option<Micros>,
    /// Next read of the round; 0 between rounds.
    turn: usize,
    /// True while a read is unanswered: a round that becomes due is skipped.
    under_way: bool,
    rounds: usize,
    /// Read skipped by this round.
    left_out: Option<usize>,
    /// Index at the last publication; `None` before the first on this line.
    told: Option<u64>,
}

impl Polls {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.next
    }

    /// Discards the round of a line that broke.
    pub(super) fn interrupt(&mut self) {
        *self = Self {
            next: self.next,
            ..Self::default()
        };
    }

    /// Advances to the next read of this round. `ended` is true if a command finished since the
    /// last publication.
    fn advance(&mut self, period: Micros, ended: bool, end: usize) {
        self.turn += 1;
        let spared = !ended && period.saturating_mul(2) <= MAX_READ_AGE;
        if spared && self.turn == ALTERNATING_READS[self.rounds % ALTERNATING_READS.len()] {
            self.left_out = Some(self.turn);
            self.turn += 1;
        }
        if ended && self.turn >= end {
            // A command finished during the round, so the skipped read is made up.
            self.turn = self.left_out.take().unwrap_or(self.turn);
        }
    }
}

impl Driver {
    /// Sends the next state read if it is due, one at a time.
    pub(super) fn poll_state(&mut self, now: Micros) {
        let (period, pins) = {
            let watches = lock(&self.shared.watches);
            let Some(period) = watches.period() else {
                // The next watch must not get values from before.
                (self.polls.next, self.polls.turn, self.polls.told) = (None, 0, None);
                return;
            };
            (micros(period).max(1), watches.pins())
        };
        let due = self.polls.next.unwrap_or(now);
        // A new watch may have a shorter period.
        let soon = now.saturating_add(period);
        self.polls.next = Some(if due > now {
            due.min(soon)
        } else {
            // After a delay the missed rounds are dropped, not made up in a burst.
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
        let deadline: Instant = self.at(now.saturating_add(ANSWER_TIMEOUT));
        self.submit(request, deadline, ReplyTarget::Poll);
    }

    /// Handles the end of a state read; the picture has already seen the answer.
    pub(super) fn polled(&mut self) {
        if !std::mem::take(&mut self.polls.under_way) {
            // The round was discarded with its line.
            return;
        }
        let (period, pins) = {
            let watches = lock(&self.shared.watches);
            (watches.period().map_or(0, micros), watches.pins().len())
        };
        let ended =
            self.polls.told.is_none() || self.polls.told != self.shared.picture().current_index();
        self.polls.advance(period, ended, STATE_READS + pins);
        if self.polls.turn >= STATE_READS + pins {
            (self.polls.turn, self.polls.left_out) = (0, None);
            self.polls.rounds = self.polls.rounds.wrapping_add(1);
            self.polls.told = self.shared.picture().current_index();
            self.publish_status();
        }
    }
}

fn read(turn: usize, pins: &[Pin]) -> Result<Request, magician_protocol::EncodeError> {
    let Some(pin) = turn.checked_sub(STATE_READS).and_then(|at| pins.get(at)) else {
        return match turn {
            1 => Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
            2 => Request::get::<QueuedCmdLeftSpace>(&NoArgs),
            3 => Request::get::<AlarmsState>(&NoArgs),
            // The first read of a round, and of every turn that lost its pin to an ended watch.
            _ => Request::get::<Pose>(&NoArgs),
        };
    };
    let address = Some(pin.address());
    match pin {
        Pin::Input(_) => Request::get::<IoDi>(&GetIoDi { address }),
        Pin::Output(_) => Request::get::<IoDo>(&GetIoDo { address }),
        Pin::Analog(_) => Request::get::<IoAdc>(&GetIoAdc { address }),
        // Unreachable in a published build too: the crates depend on each other by exact version.
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}
