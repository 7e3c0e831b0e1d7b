//! Reading for watches of the state.

use magician_protocol::NoArgs;
use magician_protocol::commands::{
    AlarmsState, GetIoAdc, GetIoDi, GetIoDo, IoAdc, IoDi, IoDo, Pose, QueuedCmdCurrentIndex,
    QueuedCmdLeftSpace,
};
use tokio::time::Instant;

use super::{Driver, To, micros};
use crate::arm::shared::held;
use crate::arm::state::Pin;
use crate::connection::{Micros, Request};

/// Reads of the state before the pins.
const READS: usize = 4;
/// How long an answer may take. Nothing else is read for the onlookers meanwhile.
const PATIENCE: Micros = 1_000_000;

/// Whose turn it is to be read.
#[derive(Debug, Default)]
pub(super) struct Polls {
    /// When the next read is due; `None` without watches.
    next: Option<Micros>,
    turn: usize,
    /// One has not been answered: what is due meanwhile is left out.
    under_way: bool,
    /// The answer that is under way is the last of a round.
    completes: bool,
}

impl Polls {
    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        self.next
    }

    /// The line broke, and what was under way with it.
    pub(super) fn interrupt(&mut self) {
        (self.under_way, self.turn) = (false, 0);
    }
}

impl Driver {
    /// Reads what is due for the onlookers, one thing at a time.
    pub(super) fn poll_state(&mut self, now: Micros) {
        let (period, pins) = {
            let watches = held(&self.shared.watches);
            match watches.period() {
                None => {
                    self.polls.next = None;
                    return;
                }
                Some(period) if self.polls.next.is_some_and(|at| at > now) => {
                    // A new watch may want it sooner.
                    let soon = now.saturating_add(micros(period));
                    self.polls.next = self.polls.next.map(|at| at.min(soon));
                    return;
                }
                Some(period) => (period, watches.pins()),
            }
        };
        let reads = READS + pins.len();
        let pause = micros(period / u32::try_from(reads).unwrap_or(u32::MAX)).max(1);
        let due = self.polls.next.unwrap_or(now).saturating_add(pause);
        self.polls.next = Some(if due > now {
            due
        } else {
            now.saturating_add(pause)
        });
        if self.polls.under_way {
            return;
        }
        let turn = self.polls.turn % reads;
        let Ok(request) = read(turn, &pins) else {
            return;
        };
        self.polls.turn = turn + 1;
        self.polls.under_way = true;
        self.polls.completes = turn + 1 == reads;
        let deadline: Instant = self.at(now.saturating_add(PATIENCE));
        self.submit(request, deadline, To::Poll);
    }

    /// A read for the onlookers has ended; what it said was seen as it passed.
    pub(super) fn polled(&mut self) {
        self.polls.under_way = false;
        if std::mem::take(&mut self.polls.completes) {
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
    }
}
