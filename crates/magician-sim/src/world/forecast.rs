//! What a path will bring: when the tool touches bodies, and when what it carries passes a sensor.

use std::collections::VecDeque;

use super::samples::{SampleTimes, first};
use super::scene::Frames;
use super::touch::{Contact, Reach};
use super::{Body, TimedPath};
use crate::ArmInstant;

/// Something that a path will bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// The tool is at a body in another way, or clear of it.
    Contact(Body, Option<Contact>),
    /// A sensor, by its place in the scenario, sees another of the carried objects, or none.
    Carried(usize, Option<u16>),
}

/// When what will change, in order of time.
pub(super) type Changes = VecDeque<(ArmInstant, Change)>;

/// Foretells a path.
pub(super) struct Forecast<'a, F> {
    /// The tool in the world, its frames those of any instant.
    pub(super) reach: Reach<'a>,
    /// The frames at an instant of the path.
    pub(super) frames: F,
}

impl<F: Fn(ArmInstant) -> Frames> Forecast<'_, F> {
    fn reach(&self, frames: Frames) -> Reach<'_> {
        Reach {
            frames,
            ..self.reach
        }
    }

    fn reach_at(&self, at: ArmInstant) -> Reach<'_> {
        self.reach((self.frames)(at))
    }

    /// Everything that the path will bring to a tool that is at bodies as told, and carries what
    /// the sensors see as told.
    pub(super) fn changes(
        &self,
        path: &TimedPath<'_>,
        contacts: &[(Body, Contact)],
        seen: &[Option<u16>],
    ) -> Changes {
        let carries = self.reach.scene.held().is_some();
        let highest = self.highest().unwrap_or(f64::NEG_INFINITY);
        if contacts.is_empty() && highest.is_infinite() && !carries {
            return Changes::new();
        }
        let samples = SampleTimes::along(path.from, path.to, |at| (self.frames)(at).tool);
        let views: Vec<View> = (0..=samples.count)
            .map(|nth| samples.at(nth))
            .map(|at| (at, (self.frames)(at)))
            .collect();
        let mut changes = Vec::new();
        let comes_near = |(_, frames): &View| self.reach(*frames).lowest() < highest;
        if !contacts.is_empty() || views.iter().any(comes_near) {
            for body in self.bodies() {
                let before = contacts.iter().find(|(other, _)| *other == body);
                let before = before.map(|(_, contact)| *contact);
                self.contacts(body, before, &views, &mut changes);
            }
        }
        if carries {
            for (sensor, before) in seen.iter().enumerate() {
                self.sights(sensor, *before, &views, &mut changes);
            }
        }
        // Stable: a touch comes before the stall at the same instant.
        changes.sort_by_key(|(at, _)| *at);
        changes.into()
    }

    fn bodies(&self) -> impl Iterator<Item = Body> + use<F> {
        let objects = self.reach.scene.ids().map(Body::Object);
        [Body::Table, Body::Belt].into_iter().chain(objects)
    }

    /// The height of the highest body that there is to touch.
    fn highest(&self) -> Option<f64> {
        self.bodies()
            .filter_map(|body| Some(self.reach.top(body)?.place.z))
            .reduce(f64::max)
    }

    fn contacts(
        &self,
        body: Body,
        before: Option<Contact>,
        views: &[View],
        changes: &mut Vec<(ArmInstant, Change)>,
    ) {
        let Some(((start, frames), rest)) = views.split_first() else {
            return;
        };
        let mut tell = |at, contact| changes.push((at, Change::Contact(body, contact)));
        let touches = |at| self.reach_at(at).depth(body).is_some();
        let (mut contact, mut limit) = self.reach(*frames).at_start(body, before);
        if contact.is_some() != before.is_some() {
            // Something other than a path has brought the tool here, or away.
            tell(*start, contact);
        }
        let mut last = *start;
        for (next, frames) in rest {
            let here = self.reach(*frames);
            // Between two looks the tool can come to a body and press it too hard.
            for _ in 0..2 {
                let then = here.contact(body, contact, limit);
                if then == contact {
                    break;
                }
                let presses = |at| self.reach_at(at).depth(body) > Some(limit);
                last = match (contact, then) {
                    (None, _) => first(last, *next, touches),
                    (_, None) => first(last, *next, |at| !touches(at)),
                    (_, Some(Contact::Stall)) => first(last, *next, presses),
                    _ => first(last, *next, |at| !presses(at)),
                };
                contact = self.reach_at(last).contact(body, contact, limit);
                tell(last, contact);
                if contact.is_none() {
                    limit = self.reach.give();
                }
            }
            last = *next;
        }
    }

    fn sights(
        &self,
        sensor: usize,
        before: Option<u16>,
        views: &[View],
        changes: &mut Vec<(ArmInstant, Change)>,
    ) {
        let sees = |at| carried_before(&self.reach_at(at), sensor);
        let (mut last, mut seen) = (None, before);
        for (next, frames) in views {
            let now = carried_before(&self.reach(*frames), sensor);
            if now != seen {
                let changed = first(last.unwrap_or(*next), *next, |at| sees(at) == now);
                changes.push((changed, Change::Carried(sensor, now)));
                seen = now;
            }
            last = Some(*next);
        }
    }
}

/// The frames at an instant.
type View = (ArmInstant, Frames);

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
