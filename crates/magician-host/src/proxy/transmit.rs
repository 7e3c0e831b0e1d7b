//! Output of the proxy: replies to clients, and frames to the arm in turn.

use magician_protocol::FrameBuf;

use super::arm::Purpose;
use super::event::{Chunk, Client, Event};
use super::member::{PendingRequest, RequestKind, State};
use super::{Jog, Proxy, kind};
use crate::connection::{Micros, Ticket};

/// Output.
impl Proxy {
    /// Returns the next reply to a client. `None` if no reply is ready.
    pub fn poll_transmit(&mut self, client: Client) -> Option<FrameBuf> {
        // A later request was answered, so an earlier late reply is lost; waiting would reorder
        // replies.
        if let Some(answered) = self.members.get(&client)?.answered_last() {
            self.give_up_late(client, |flight| flight.ticket < answered);
        }
        let (frame, shared) = self.members.get_mut(&client)?.reply()?;
        self.tell(Event::Reply {
            client,
            frame,
            shared,
        });
        Some(frame)
    }

    /// Returns the next bytes for the arm. `None` if nothing may be sent at present.
    pub fn poll_transmit_to_arm(&mut self, now: Micros) -> Option<Chunk> {
        if !self.online {
            return None;
        }
        if let Some(frame) = self.transmit_stop(now) {
            return Some(Chunk::from(&frame));
        }
        self.share(now);
        // While a stop waits for the previous one, nothing else is sent.
        let stopping = !self.own.is_empty() || self.oldest_stop().is_some();
        if stopping || self.arm.is_busy() {
            return None;
        }
        self.transmit_in_turn(now)
    }

    fn transmit_stop(&mut self, now: Micros) -> Option<FrameBuf> {
        if self.arm.is_stopping() {
            return None;
        }
        let own = self.own.front().map(|(frame, _)| *frame);
        let asked = self.oldest_stop();
        let frame = own.or(asked.map(|(_, _, frame)| frame))?;
        if self.arm.must_wait_for_fence(&frame)
            && let Some(fence) = self.transmit_fence(now)
        {
            return Some(fence);
        }
        if let Some((frame, tries)) = self.own.pop_front() {
            let tries = tries.saturating_sub(1);
            self.tell(Event::Own { frame });
            let ticket = self.ticket();
            self.send(now, ticket, Purpose::Own { tries }, frame, None);
            return Some(frame);
        }
        let (client, ticket, frame) = asked?;
        self.mark_asked(client, ticket);
        self.send(now, ticket, Purpose::Stop, frame, Some(client));
        Some(frame)
    }

    /// Stop that has waited longest.
    fn oldest_stop(&self) -> Option<(Client, Ticket, FrameBuf)> {
        let slots = self.members.iter().flat_map(|(client, member)| {
            let waiting = member.slots.iter().filter(|slot| slot.waits());
            waiting.map(|slot| (*client, slot))
        });
        let stops = slots.filter_map(|(client, slot)| match slot.what {
            RequestKind::Request { frame, stop: true } => Some((client, slot.ticket, frame)),
            _ => None,
        });
        // Tickets are given in the order of arrival, over all clients.
        stops.min_by_key(|(_, ticket, _)| *ticket)
    }

    fn transmit_fence(&mut self, now: Micros) -> Option<FrameBuf> {
        let frame = self.arm.fence()?;
        self.tell(Event::Own { frame });
        let ticket = self.ticket();
        self.send(now, ticket, Purpose::Fence, frame, None);
        Some(frame)
    }

    /// Answers requests from shared replies, or joins them to equal requests in flight.
    fn share(&mut self, now: Micros) {
        if self.settings.max_reply_age == 0 {
            return;
        }
        for (client, member) in &mut self.members {
            // Only a reply to a later request on the line proves a late reply lost, so the next
            // read of this client must go to the arm.
            if self.arm.is_late_for(*client) {
                continue;
            }
            // In the client's order: requests behind a waiting one wait too.
            while let Some(slot) = member.slots.iter_mut().find(|slot| slot.waits()) {
                let RequestKind::Request { frame, stop: false } = &slot.what else {
                    break;
                };
                if !kind::can_be_shared(&frame.frame()) {
                    break;
                }
                if let Some(reply) =
                    (self.readings).take(now, self.settings.max_reply_age, *client, frame)
                {
                    slot.state = State::Answered {
                        frame: reply,
                        shared: true,
                    };
                    continue;
                }
                match self.arm.asking(frame, self.epoch) {
                    Some(flight) if flight.takers.iter().all(|(taker, _)| taker != client) => {
                        flight.takers.push((*client, slot.ticket));
                        slot.state = State::Asked;
                    }
                    _ => break,
                }
            }
        }
    }

    /// Sends the next request of the client whose turn it is, or the fence that it needs first.
    fn transmit_in_turn(&mut self, now: Micros) -> Option<Chunk> {
        for client in self.in_turn() {
            let slot = self.members.get(&client).and_then(|member| member.next());
            let Some(PendingRequest { ticket, what, .. }) = slot else {
                continue;
            };
            let ticket = *ticket;
            match *what {
                // Another client may be able to send while this key is outstanding.
                RequestKind::Request { frame, .. } if self.arm.must_wait_for_fence(&frame) => {
                    if let Some(fence) = self.transmit_fence(now) {
                        return Some(Chunk::from(&fence));
                    }
                }
                RequestKind::Request { frame, .. } => {
                    self.turn = Some(client);
                    self.mark_asked(client, ticket);
                    self.send(now, ticket, Purpose::Request, frame, Some(client));
                    return Some(Chunk::from(&frame));
                }
                RequestKind::Foreign(bytes) => {
                    self.turn = Some(client);
                    if let Some(member) = self.members.get_mut(&client) {
                        member.remove(ticket);
                    }
                    // Unknown bytes may be anything, even half of a command.
                    self.changed();
                    return Some(bytes);
                }
            }
        }
        None
    }

    /// All clients, beginning with the one after the last turn.
    fn in_turn(&self) -> Vec<Client> {
        let after = |client: &&Client| self.turn.is_none_or(|last| **client > last);
        let (first, rest): (Vec<&Client>, Vec<&Client>) = self.members.keys().partition(after);
        first.into_iter().chain(rest).copied().collect()
    }

    fn mark_asked(&mut self, client: Client, ticket: Ticket) {
        let member = self.members.get_mut(&client);
        if let Some(slot) = member.and_then(|member| member.slot(ticket)) {
            slot.state = State::Asked;
        }
    }

    /// Sends a frame to the arm.
    fn send(
        &mut self,
        now: Micros,
        ticket: Ticket,
        purpose: Purpose,
        frame: FrameBuf,
        client: Option<Client>,
    ) {
        if kind::changes(&frame.frame()) {
            self.changed();
        }
        let serial = (self.arm).send(now, ticket, purpose, frame, client, self.epoch);
        if let (Some(client), Some(end)) = (client, kind::end_of_jog(&frame.frame())) {
            self.jog = Some(Jog {
                client,
                end,
                serial,
            });
        }
    }
}
