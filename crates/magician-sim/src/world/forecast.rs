//! What a course will bring: when the tool touches things, and when what it carries passes a sensor.

use std::collections::VecDeque;

use super::looks::{Looks, first};
use super::scene::Frames;
use super::touch::{Contact, Reach};
use super::{Course, Thing};
use crate::Micros;

/// Something that a course will bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// The tool is at a thing in another way, or clear of it.
    Contact(Thing, Option<Contact>),
    /// A sensor, by its place in the scenario, sees another of the carried objects, or none.
    Carried(usize, Option<u16>),
}

/// When what will change, in order of time.
pub(super) type Changes = VecDeque<(Micros, Change)>;

/// Foretells courses.
pub(super) struct Forecast<'a, F> {
    /// The tool in the world, its frames those of any instant.
    pub(super) reach: Reach<'a>,
    /// The frames at an instant of the course.
    pub(super) frames: F,
}

impl<F: Fn(Micros) -> Frames> Forecast<'_, F> {
    fn reach(&self, at: Micros) -> Reach<'_> {
        Reach {
            frames: (self.frames)(at),
            ..self.reach
        }
    }

    /// Everything that the course will bring to a tool that is at things as told.
    pub(super) fn changes(
        &self,
        course: &Course<'_>,
        contacts: &[(Thing, Contact)],
        seen: &[Option<u16>],
    ) -> Changes {
        let looks = Looks::along(course.from, course.to, |at| (self.frames)(at).tool);
        let mut changes = Vec::new();
        if !contacts.is_empty() || self.comes_near(looks) {
            for thing in self.things() {
                let before = contacts.iter().find(|(other, _)| *other == thing);
                self.contacts(
                    thing,
                    before.map(|(_, contact)| *contact),
                    looks,
                    &mut changes,
                );
            }
        }
        if self.reach.scene.held().is_some() {
            for (sensor, before) in seen.iter().enumerate() {
                self.sights(sensor, *before, looks, &mut changes);
            }
        }
        // Stable: a touch comes before the stall at the same instant.
        changes.sort_by_key(|(at, _)| *at);
        changes.into()
    }

    fn things(&self) -> impl Iterator<Item = Thing> + use<F> {
        let objects = self.reach.scene.ids().map(Thing::Object);
        [Thing::Table, Thing::Belt].into_iter().chain(objects)
    }

    /// Whether the tool comes down to the height of anything.
    fn comes_near(&self, looks: Looks) -> bool {
        let scenario = self.reach.scenario;
        let table = scenario.table().map(|table| table.height);
        let belt = scenario.conveyor().map(|belt| belt.height);
        let objects = self.reach.scene.ids().map(Thing::Object);
        let frames = (self.frames)(looks.from);
        let tops = objects.filter_map(|thing| match thing {
            Thing::Object(object) if !self.reach.scene.is_carried(object) => {
                Some(self.reach.scene.solid(object, scenario, &frames).height())
            }
            _ => None,
        });
        let Some(highest) = table.into_iter().chain(belt).chain(tops).reduce(f64::max) else {
            return false;
        };
        (0..=looks.count).any(|nth| self.reach(looks.at(nth)).lowest() < highest)
    }

    fn contacts(
        &self,
        thing: Thing,
        before: Option<Contact>,
        looks: Looks,
        changes: &mut Vec<(Micros, Change)>,
    ) {
        let mut tell = |at, contact| changes.push((at, Change::Contact(thing, contact)));
        let touches = |at| self.reach(at).depth(thing).is_some();
        let (mut contact, mut limit) = self.reach(looks.from).at_start(thing, before);
        if contact.is_some() != before.is_some() {
            // Something other than a course has brought the tool here, or away.
            tell(looks.from, contact);
        }
        let mut last = looks.from;
        for nth in 1..=looks.count {
            let next = looks.at(nth);
            // Between two looks the tool can come to a thing and press it too hard.
            for _ in 0..2 {
                let then = self.reach(next).contact(thing, contact, limit);
                if then == contact {
                    break;
                }
                let presses = |at| self.reach(at).depth(thing) > Some(limit);
                last = match (contact, then) {
                    (None, _) => first(last, next, touches),
                    (_, None) => first(last, next, |at| !touches(at)),
                    (_, Some(Contact::Stall)) => first(last, next, presses),
                    _ => first(last, next, |at| !presses(at)),
                };
                contact = self.reach(last).contact(thing, contact, limit);
                tell(last, contact);
                if contact.is_none() {
                    limit = self.reach.give();
                }
            }
            last = next;
        }
    }

    fn sights(
        &self,
        sensor: usize,
        before: Option<u16>,
        looks: Looks,
        changes: &mut Vec<(Micros, Change)>,
    ) {
        let sees = |at| carried_before(&self.reach(at), sensor);
        let (mut last, mut seen) = (looks.from, before);
        for nth in 0..=looks.count {
            let next = looks.at(nth);
            let now = sees(next);
            if now != seen {
                let changed = first(last, next, |at| sees(at) == now);
                changes.push((changed, Change::Carried(sensor, now)));
                seen = now;
            }
            last = next;
        }
    }
}

/// The carried object that a sensor sees.
pub(super) fn carried_before(reach: &Reach<'_>, sensor: usize) -> Option<u16> {
    let sensor = reach.scenario.sensors().get(sensor)?;
    let mut carried = reach
        .scene
        .ids()
        .filter(|object| reach.scene.is_carried(*object));
    carried.find(|object| {
        let solid = reach.scene.solid(*object, reach.scenario, &reach.frames);
        solid.meets(&sensor.beam).is_some()
    })
}
