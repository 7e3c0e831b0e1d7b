use magician_protocol::{Ctrl, FrameBuf};

use super::cut::Cutter;
use super::{Client, Settings};
use crate::connection::estimator::Estimator;
use crate::connection::outstanding::{Copy, Key, Outstanding};
use crate::connection::transmit::FENCES;
use crate::connection::{Micros, Ticket};

/// Why a frame went out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// A client asked.
    Request,
    /// A client asked for a stop, which takes no place in the window.
    Stop,
    /// Its answer proves that older answers will not come any more.
    Fence,
    /// The end of a jog without an owner, or the stop of a client that disconnected.
    Own {
        /// How often it may still go out.
        tries: u32,
    },
}

impl Purpose {
    fn in_window(self) -> bool {
        matches!(self, Self::Request | Self::Fence)
    }
}

/// A frame that went out and is waited for.
#[derive(Debug)]
pub(super) struct Flight {
    pub(super) ticket: Ticket,
    pub(super) purpose: Purpose,
    pub(super) frame: FrameBuf,
    /// The clients that get the reply, and for which of their requests; the first one asked.
    pub(super) takers: Vec<(Client, Ticket)>,
    /// How often something that may have changed the arm had gone out by then.
    pub(super) epoch: u64,
    /// Its number among all that went out.
    pub(super) serial: u64,
    since: Micros,
    timer: Micros,
}

impl Flight {
    /// Whether it has not taken longer than answers take.
    pub(super) fn is_in_time(&self, now: Micros) -> bool {
        now < self.timer
    }
}

/// What an answer of the arm comes to.
pub(super) struct Claim {
    /// What it answers, if a client waits for it.
    pub(super) answered: Option<Flight>,
    /// What it proves unanswered.
    pub(super) lost: Vec<Flight>,
}

/// The line to the arm: which answer belongs to which frame, by the rules of
/// [`connection`](crate::connection).
#[derive(Debug)]
pub(super) struct ArmLine {
    pub(super) cutter: Cutter,
    outstanding: Outstanding,
    estimator: Estimator,
    flights: Vec<Flight>,
    /// Those that nothing waits for but the client that asked.
    late: Vec<Flight>,
    ordered: bool,
    lifetime: Micros,
    next_fence: usize,
    sent: u64,
}

impl ArmLine {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            cutter: Cutter::default(),
            outstanding: Outstanding::new(settings.line.ordered),
            estimator: Estimator::new(&settings.line),
            flights: Vec::new(),
            late: Vec::new(),
            ordered: settings.line.ordered,
            lifetime: settings.line.lifetime,
            next_fence: 0,
            sent: 0,
        }
    }

    /// Whether a request has to wait for the one in flight.
    pub(super) fn is_busy(&self) -> bool {
        self.outstanding.is_full() || self.flights.iter().any(|flight| flight.purpose.in_window())
    }

    /// Whether a stop has to wait for the one in flight.
    pub(super) fn is_stopping(&self) -> bool {
        let outside = |flight: &Flight| !flight.purpose.in_window();
        self.outstanding.is_choked() || self.flights.iter().any(outside)
    }

    /// Whether an answer to an older frame could be taken for the answer to this one.
    pub(super) fn is_haunted(&self, frame: &FrameBuf) -> bool {
        let waited_for = |ticket| self.flights.iter().any(|flight| flight.ticket == ticket);
        (self.outstanding).haunted(Key::of(&frame.frame()), waited_for)
    }

    /// A frame to go out before one that is haunted: `None` while one is in flight, and where time
    /// alone will tell.
    pub(super) fn fence(&mut self) -> Option<FrameBuf> {
        let fenced = (self.flights.iter()).any(|flight| flight.purpose == Purpose::Fence);
        if fenced || !self.ordered {
            return None;
        }
        let turn = FENCES.get(self.next_fence % FENCES.len());
        self.next_fence = (self.next_fence + 1) % FENCES.len();
        let clean = FENCES.iter().find(|row| {
            let ctrl = Ctrl::GET;
            !self.outstanding.contains(Key { id: row.id, ctrl })
        });
        let row = clean.or(turn)?;
        FrameBuf::new(row.id, Ctrl::GET, &[]).ok()
    }

    /// The flight that asks this, among those that went out in an epoch.
    pub(super) fn asking(&mut self, frame: &FrameBuf, epoch: u64) -> Option<&mut Flight> {
        let same = |flight: &&mut Flight| {
            flight.purpose == Purpose::Request && flight.epoch == epoch && flight.frame == *frame
        };
        self.flights.iter_mut().find(same)
    }

    /// A frame goes out; its serial number.
    pub(super) fn send(
        &mut self,
        now: Micros,
        ticket: Ticket,
        purpose: Purpose,
        frame: FrameBuf,
        taker: Option<Client>,
        epoch: u64,
    ) -> u64 {
        self.sent = self.sent.saturating_add(1);
        self.outstanding.sent(Copy {
            key: Key::of(&frame.frame()),
            ticket,
            at: now,
            // One at a time: nothing is counted by it here.
            order: 0,
        });
        self.flights.push(Flight {
            ticket,
            purpose,
            frame,
            takers: taker.map(|client| (client, ticket)).into_iter().collect(),
            epoch,
            serial: self.sent,
            since: now,
            timer: now.saturating_add(self.estimator.timeout()),
        });
        self.sent
    }

    /// A frame came; `None` when nothing that was sent can be meant.
    pub(super) fn claim(&mut self, now: Micros, frame: &FrameBuf) -> Option<Claim> {
        let copy = self.outstanding.answered(Key::of(&frame.frame()))?;
        let Self { flights, late, .. } = self;
        let meant = |flight: &mut Flight| flight.ticket == copy.ticket;
        let in_time = flights.extract_if(.., meant).next();
        let answered = in_time.or_else(|| late.extract_if(.., meant).next());
        if let Some(flight) = &answered {
            self.estimator.sample(now.saturating_sub(flight.since));
        }
        let Self {
            flights,
            late,
            outstanding,
            ordered,
            ..
        } = self;
        let gone = |flight: &mut Flight| *ordered && !outstanding.awaits(flight.ticket);
        let lost = late
            .extract_if(.., gone)
            .chain(flights.extract_if(.., gone))
            .collect();
        Some(Claim { answered, lost })
    }

    /// Only the first client still waits for this reply.
    pub(super) fn let_come_late(&mut self, mut flight: Flight) {
        flight.takers.truncate(1);
        self.late.push(flight);
    }

    /// Whether a client waits for an answer that comes late.
    pub(super) fn is_late_for(&self, client: Client) -> bool {
        let takers = self.late.iter().flat_map(|flight| &flight.takers);
        takers.into_iter().any(|(taker, _)| *taker == client)
    }

    /// Those that come late and are not waited for after all.
    pub(super) fn give_up_late(&mut self, mut which: impl FnMut(&Flight) -> bool) -> Vec<Flight> {
        (self.late.extract_if(.., |flight| which(flight))).collect()
    }

    /// Replies that come too late for any client.
    pub(super) fn too_late(&mut self, now: Micros) -> Vec<Flight> {
        let lifetime = self.lifetime;
        self.give_up_late(|flight| flight.since.saturating_add(lifetime) <= now)
    }

    /// What the line has been kept free for too long.
    pub(super) fn overdue(&mut self, now: Micros) -> Vec<Flight> {
        self.outstanding.expire(now, self.lifetime);
        let overdue: Vec<Flight> = (self.flights)
            .extract_if(.., |flight| flight.timer <= now)
            .collect();
        if !overdue.is_empty() {
            self.estimator.back_off();
        }
        overdue
    }

    /// The line is gone: nothing in flight is waited for. What went out stays outstanding, for the
    /// arm may answer it on the next line.
    pub(super) fn lost(&mut self) -> Vec<Flight> {
        let mut lost = std::mem::take(&mut self.late);
        lost.append(&mut self.flights);
        lost
    }

    pub(super) fn poll_timeout(&self) -> Option<Micros> {
        let timers = self.flights.iter().map(|flight| flight.timer);
        let expiry = self.outstanding.next_expiry(self.lifetime);
        let late = (self.late.iter()).map(|flight| flight.since.saturating_add(self.lifetime));
        let others = expiry.into_iter().chain(self.cutter.poll_timeout());
        timers.chain(late).chain(others).min()
    }
}
