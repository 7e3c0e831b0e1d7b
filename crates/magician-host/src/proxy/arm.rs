//! The proxy's line to the arm: frames in flight, fences, and which reply belongs to which frame.

use magician_protocol::{Ctrl, FrameBuf};

use super::cut::Cutter;
use super::{Client, Settings};
use crate::connection::estimator::Estimator;
use crate::connection::outstanding::{Key, Outstanding, SentFrame};
use crate::connection::transmit::FENCES;
use crate::connection::{Micros, Ticket};

/// Purpose of a frame that was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Request of a client.
    Request,
    /// Stop of a client, which occupies no place in the window.
    Stop,
    /// Fence: its reply proves that older replies can no longer arrive.
    Fence,
    /// Stop of a jog without an owner, or of a client that disconnected.
    Own {
        /// Number of retransmissions left.
        tries: u32,
    },
}

impl Purpose {
    fn in_window(self) -> bool {
        matches!(self, Self::Request | Self::Fence)
    }
}

/// A frame that was sent and is waited for.
#[derive(Debug)]
pub(super) struct Flight {
    pub(super) ticket: Ticket,
    pub(super) purpose: Purpose,
    pub(super) frame: FrameBuf,
    /// Clients that get the reply, each with its own ticket; the first one sent the request.
    pub(super) takers: Vec<(Client, Ticket)>,
    /// The proxy's epoch when the frame was sent. The epoch counts possible changes of the arm.
    pub(super) epoch: u64,
    /// Ordinal among all frames sent.
    pub(super) serial: u64,
    since: Micros,
    timer: Micros,
}

impl Flight {
    /// True if the reply is not overdue.
    pub(super) fn is_in_time(&self, now: Micros) -> bool {
        now < self.timer
    }
}

/// Result of a reply from the arm.
pub(super) struct ReplyMatch {
    /// Frame that the reply answers. `None` if the proxy has given that frame up.
    pub(super) answered: Option<Flight>,
    /// Older frames whose replies it proves lost.
    pub(super) lost: Vec<Flight>,
}

/// Line to the arm. Assigns replies to frames by the rules of [`connection`](crate::connection).
#[derive(Debug)]
pub(super) struct ArmLine {
    pub(super) cutter: Cutter,
    outstanding: Outstanding,
    estimator: Estimator,
    flights: Vec<Flight>,
    /// Overdue frames that only the client that sent the request still waits for.
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

    /// True if a request must wait for the one in flight.
    pub(super) fn is_busy(&self) -> bool {
        self.outstanding.is_full() || self.flights.iter().any(|flight| flight.purpose.in_window())
    }

    /// True if a stop must wait for the one in flight.
    pub(super) fn is_stopping(&self) -> bool {
        let outside = |flight: &Flight| !flight.purpose.in_window();
        self.outstanding.is_choked() || self.flights.iter().any(outside)
    }

    /// True if a reply to an older frame could be taken for the reply to this one.
    pub(super) fn must_wait_for_fence(&self, frame: &FrameBuf) -> bool {
        let waited_for = |ticket| self.flights.iter().any(|flight| flight.ticket == ticket);
        (self.outstanding).has_abandoned(Key::of(&frame.frame()), waited_for)
    }

    /// Fence to send before a frame whose key is still outstanding. `None` while a fence is in
    /// flight, and on an unordered link, where only time helps.
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

    /// Frame in flight with the same request, sent in the same epoch.
    pub(super) fn asking(&mut self, frame: &FrameBuf, epoch: u64) -> Option<&mut Flight> {
        let same = |flight: &&mut Flight| {
            flight.purpose == Purpose::Request && flight.epoch == epoch && flight.frame == *frame
        };
        self.flights.iter_mut().find(same)
    }

    /// Notes that a frame is sent. Returns its serial number.
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
        self.outstanding.sent(SentFrame {
            key: Key::of(&frame.frame()),
            ticket,
            at: now,
            // Not used here: only one request is in flight at a time.
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
            // The same timeout as a connection's, although nothing is retransmitted.
            timer: now.saturating_add(self.estimator.timeout()),
        });
        self.sent
    }

    /// Assigns a reply. `None` if it belongs to no frame sent.
    pub(super) fn claim(&mut self, now: Micros, frame: &FrameBuf) -> Option<ReplyMatch> {
        let copy = self.outstanding.answered(Key::of(&frame.frame()))?;
        // A late reply is still delivered to the client that asked.
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
        // On an ordered line a reply proves all older ones lost (rule 3 of `connection`).
        let gone = |flight: &mut Flight| *ordered && !outstanding.awaits(flight.ticket);
        let lost = late
            .extract_if(.., gone)
            .chain(flights.extract_if(.., gone))
            .collect();
        Some(ReplyMatch { answered, lost })
    }

    /// Frees the line for others; only the client that sent the request still waits for this reply.
    pub(super) fn let_come_late(&mut self, mut flight: Flight) {
        // Clients that joined a read ask for themselves, which ends their wait sooner.
        flight.takers.truncate(1);
        self.late.push(flight);
    }

    /// True if a client waits for a late reply.
    pub(super) fn is_late_for(&self, client: Client) -> bool {
        let takers = self.late.iter().flat_map(|flight| &flight.takers);
        takers.into_iter().any(|(taker, _)| *taker == client)
    }

    /// Removes the late frames that `which` selects.
    pub(super) fn give_up_late(&mut self, mut which: impl FnMut(&Flight) -> bool) -> Vec<Flight> {
        (self.late.extract_if(.., |flight| which(flight))).collect()
    }

    /// Removes late frames whose reply can no longer arrive.
    pub(super) fn too_late(&mut self, now: Micros) -> Vec<Flight> {
        let lifetime = self.lifetime;
        self.give_up_late(|flight| flight.since.saturating_add(lifetime) <= now)
    }

    /// Removes frames whose reply is overdue, which frees the line.
    pub(super) fn overdue(&mut self, now: Micros) -> Vec<Flight> {
        self.outstanding.expire(now, self.lifetime);
        let overdue: Vec<Flight> = (self.flights)
            .extract_if(.., |flight| flight.timer <= now)
            .collect();
        if !overdue.is_empty() {
            // Once per overdue batch: losses in the same moment are one event.
            self.estimator.back_off();
        }
        overdue
    }

    /// Removes all frames in flight, because the line is lost. They stay outstanding, as the arm
    /// may answer them on the next line.
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
