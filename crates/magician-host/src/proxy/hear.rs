//! Input of the proxy: bytes from clients and from the arm.

use std::collections::VecDeque;

use magician_protocol::FrameBuf;

use super::arm::{Flight, Purpose};
use super::cut::{Cutter, Piece};
use super::event::{Chunk, Client, Event, Reason};
use super::member::{MAX_PENDING_REQUESTS, PendingRequest, RequestKind, State};
use super::{Proxy, kind};
use crate::connection::Micros;

/// Input.
impl Proxy {
    /// Processes bytes from a client, split anywhere.
    pub fn receive(&mut self, now: Micros, client: Client, bytes: &[u8]) {
        self.listen(client, |cutter, hear| cutter.push(now, bytes, hear));
    }

    /// Processes bytes from the arm, split anywhere.
    pub fn receive_from_arm(&mut self, now: Micros, bytes: &[u8]) {
        let mut cutter = std::mem::take(&mut self.arm.cutter);
        cutter.push(now, bytes, |piece| self.hear_arm(now, &piece));
        self.arm.cutter = cutter;
    }

    pub(super) fn listen(
        &mut self,
        client: Client,
        listen: impl FnOnce(&mut Cutter, &mut dyn FnMut(Piece<'_>)),
    ) {
        let Some(member) = self.members.get_mut(&client) else {
            return;
        };
        let mut cutter = std::mem::take(&mut member.cutter);
        listen(&mut cutter, &mut |piece| self.hear(client, piece));
        if let Some(member) = self.members.get_mut(&client) {
            member.cutter = cutter;
        }
    }

    fn hear(&mut self, client: Client, piece: Piece<'_>) {
        match piece {
            Piece::Frame(frame) => {
                self.tell(Event::Request { client, frame });
                self.request(client, frame);
            }
            Piece::Foreign(run) => {
                // Noise would disturb other clients, so only a transparent proxy passes it on.
                let passed = self.settings.transparent && self.online;
                for bytes in Chunk::split(run) {
                    let passed = passed && self.push(client, RequestKind::Foreign(bytes));
                    let from = Some(client);
                    self.tell(Event::Foreign {
                        from,
                        bytes,
                        passed,
                    });
                }
            }
        }
    }

    fn request(&mut self, client: Client, frame: FrameBuf) {
        if !self.online {
            return self.dropped(client, frame, Reason::NoLine);
        }
        let stop = kind::stops(&frame.frame());
        // Changes that this client requested before the stop must not happen after it; reads are
        // harmless.
        if stop {
            let overtaken = |slot: &PendingRequest| match &slot.what {
                RequestKind::Request { frame, stop } => !stop && kind::changes(&frame.frame()),
                RequestKind::Foreign(_) => true,
            };
            self.drop_waiting(client, Reason::Stopped, overtaken);
        }
        if !self.push(client, RequestKind::Request { frame, stop }) {
            self.dropped(client, frame, Reason::Full);
        }
    }

    /// Adds an entry to a client's queue. False if the queue is full. Stops have reserved room.
    fn push(&mut self, client: Client, what: RequestKind) -> bool {
        let ticket = self.ticket();
        let Some(member) = self.members.get_mut(&client) else {
            return false;
        };
        let slot = PendingRequest {
            ticket,
            what,
            state: State::Waiting,
        };
        let most = if slot.is_stop() {
            2 * MAX_PENDING_REQUESTS
        } else {
            MAX_PENDING_REQUESTS
        };
        let fits = member.slots.len() < most;
        if fits {
            member.slots.push_back(slot);
        }
        fits
    }

    /// Drops waiting entries of a client.
    pub(super) fn drop_waiting(
        &mut self,
        client: Client,
        reason: Reason,
        which: impl Fn(&PendingRequest) -> bool,
    ) {
        let Some(member) = self.members.get_mut(&client) else {
            return;
        };
        let slots = std::mem::take(&mut member.slots);
        let (gone, kept) = (slots.into_iter()).partition(|slot| slot.waits() && which(slot));
        member.slots = kept;
        let gone: VecDeque<PendingRequest> = gone;
        for slot in gone {
            if let RequestKind::Request { frame, .. } = slot.what {
                self.dropped(client, frame, reason);
            }
        }
    }

    pub(super) fn hear_arm(&mut self, now: Micros, piece: &Piece<'_>) {
        match piece {
            Piece::Frame(frame) => match self.arm.claim(now, frame) {
                Some(claim) => {
                    for flight in claim.lost {
                        self.give_up(&flight);
                    }
                    match claim.answered {
                        Some(flight) => self.answered(now, flight, *frame),
                        None => self.tell(Event::Unclaimed { frame: *frame }),
                    }
                }
                None => self.tell(Event::Unclaimed { frame: *frame }),
            },
            Piece::Foreign(run) => {
                for bytes in Chunk::split(run) {
                    self.tell(Event::Foreign {
                        from: None,
                        bytes,
                        passed: false,
                    });
                }
            }
        }
    }

    fn answered(&mut self, now: Micros, flight: Flight, frame: FrameBuf) {
        for (at, (client, ticket)) in flight.takers.iter().enumerate() {
            let member = self.members.get_mut(client);
            if let Some(slot) = member.and_then(|member| member.slot(*ticket)) {
                let shared = at > 0;
                slot.state = State::Answered { frame, shared };
            }
        }
        // Only a stop sent after the jog ends it.
        let view = flight.frame.frame();
        if kind::ends_jog(&view) && self.jog.is_some_and(|jog| jog.serial < flight.serial) {
            self.jog = None;
        }
        // A reading is shared only if nothing has changed since it was requested.
        let as_it_is = flight.epoch == self.epoch && flight.is_in_time(now);
        let good = as_it_is && !frame.frame().ctrl().error();
        if good && flight.purpose == Purpose::Request && kind::can_be_shared(&view) {
            let had = flight.takers.iter().map(|(client, _)| *client).collect();
            self.readings.keep(now, flight.frame, frame, had);
        }
    }
}
