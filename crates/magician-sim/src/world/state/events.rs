//! Events that happen by themselves, each at its instant.

use super::WorldState;
use crate::ArmInstant;
use crate::world::event::WorldEventKind;
use crate::world::forecast::Change;
use crate::world::touch::Contact;
use crate::world::traffic;
use crate::world::{Body, ExternalEvent};

impl WorldState {
    pub(in crate::world) fn next_event(&self) -> Option<ArmInstant> {
        let pending = self.pending.map(|_| self.now);
        let change = self.changes.front().map(|(at, _)| *at);
        let traffic = self.traffic.map(|traffic| traffic.at);
        let script = self.script.next_event(self.scenario.script());
        [pending, change, traffic, script]
            .into_iter()
            .flatten()
            .min()
    }

    pub(in crate::world) fn poll_external(&mut self, now: ArmInstant) -> Option<ExternalEvent> {
        self.now = self.now.max(now);
        // The stall that belongs to the touch reported last.
        if let Some(event) = self.pending.take() {
            return Some(event);
        }
        loop {
            let at = self.next_event().filter(|at| *at <= now)?;
            // Order within one instant: contacts and carried objects, the belt, the script.
            let event = if self
                .changes
                .front()
                .is_some_and(|(change, _)| *change == at)
            {
                self.change()
            } else if self.traffic.is_some_and(|traffic| traffic.at == at) {
                self.belt_event()
            } else {
                self.script.happen(self.scenario.script(), now)
            };
            if event.is_some() {
                return event;
            }
        }
    }

    fn change(&mut self) -> Option<ExternalEvent> {
        let (at, change) = self.changes.pop_front()?;
        match change {
            Change::Contact(body, contact) => self.touch(at, body, contact),
            Change::Carried(sensor, object) => {
                if let Some(carried) = self.carried.get_mut(sensor) {
                    *carried = object;
                }
                self.mark_seen(at);
                Some(ExternalEvent::Input)
            }
        }
    }

    /// Applies a change of contact and returns the event that the arm feels.
    fn touch(
        &mut self,
        at: ArmInstant,
        body: Body,
        contact: Option<Contact>,
    ) -> Option<ExternalEvent> {
        let place = self.contacts.iter().position(|(other, _)| *other == body);
        let before = place.map(|place| self.contacts.swap_remove(place).1);
        self.contacts.extend(contact.map(|contact| (body, contact)));
        let contact = contact?;
        let touches = ExternalEvent::Touch {
            body,
            stalls: false,
        };
        let stalls = ExternalEvent::Touch { body, stalls: true };
        let first = match (before, contact, body) {
            (None, Contact::Knock, Body::Object(object)) => WorldEventKind::Knocked(object),
            (None, ..) => WorldEventKind::Touched(body),
            (Some(_), Contact::Stall, _) => WorldEventKind::Pressed(body),
            // A stall that eases to a touch, or a contact that continues, is no event.
            _ => return None,
        };
        self.events.push(at, first);
        // The touch was reported when the contact began.
        if before.is_some() {
            return Some(stalls);
        }
        if contact == Contact::Stall {
            self.events.push(at, WorldEventKind::Pressed(body));
            self.pending = Some(stalls);
        }
        Some(touches)
    }

    /// Applies the next event of the belt: an object enters or leaves a sensor, or runs off the
    /// end.
    fn belt_event(&mut self) -> Option<ExternalEvent> {
        let traffic = self.traffic.take()?;
        if let Some(object) = traffic.falls {
            let frames = self.frames_of_ground(traffic.at);
            let rest = traffic::run_off(&self.scenario, &mut self.scene, &frames, object);
            self.events
                .push(traffic.at, WorldEventKind::FellOffBelt(object, rest));
        }
        self.mark_seen(traffic.at);
        self.watch_belt(traffic.at);
        Some(ExternalEvent::Input)
    }
}
