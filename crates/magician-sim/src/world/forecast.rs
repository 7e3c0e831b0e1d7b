//! Prediction of a path: when the tool touches bodies, and when a carried object passes a sensor.
//!
//! A path is predicted once, when it begins: it is sampled about every millimetre, and every change
//! between two samples is bisected to its microsecond. So the arm can be advanced in one step from
//! event to event.

use std::collections::VecDeque;

use super::samples::{SampleTimes, first};
use super::scene::Frames;
use super::touch::{Contact, Reach};
use super::{Body, TimedPath};
use crate::ArmInstant;

/// A change that a path will bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Change {
    /// The contact of the tool with a body changes; `None` if the tool comes clear of the body.
    Contact(Body, Option<Contact>),
    /// A sensor, by index, sees another carried object; `None` if it sees none any more.
    Carried(usize, Option<u16>),
}

/// Changes with their instants, in order of time.
pub(super) type Changes = VecDeque<(ArmInstant, Change)>;

/// Predicts the changes along a path.
pub(super) struct Forecast<'a, F> {
    /// The tool in the world; its frames are replaced for each instant.
    pub(super) reach: Reach<'a>,
    /// Frames at an instant of the path.
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

    /// Returns all changes along the path, given the present contacts and the carried object that
    /// each sensor sees.
    pub(super) fn changes(
        &self,
        path: &TimedPath<'_>,
        contacts: &[(Body, Contact)],
        seen: &[Option<u16>],
    ) -> Changes {
        let carries = self.reach.scene.held().is_some();
        let highest = self.highest().unwrap_or(f64::NEG_INFINITY);
        // An empty world costs nothing: no body to touch, nothing carried.
        if contacts.is_empty() && highest.is_infinite() && !carries {
            return Changes::new();
        }
        // All bodies and sensors share a set of samples, because frames are the expensive part.
        let samples = SampleTimes::along(path.from, path.to, |at| (self.frames)(at).tool);
        let views: Vec<View> = (0..=samples.count)
            .map(|nth| samples.at(nth))
            .map(|at| (at, (self.frames)(at)))
            .collect();
        let mut changes = Vec::new();
        // Most paths stay above all bodies, and need no search for contacts.
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
        // The sort is stable: a touch comes before the stall at the same instant.
        changes.sort_by_key(|(at, _)| *at);
        changes.into()
    }

    fn bodies(&self) -> impl Iterator<Item = Body> + use<F> {
        let objects = self.reach.scene.ids().map(Body::Object);
        [Body::Table, Body::Belt].into_iter().chain(objects)
    }

    /// Height of the highest body that can be touched.
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
            // The tool was brought here, or away, by something other than a path.
            tell(*start, contact);
        }
        let mut last = *start;
        for (next, frames) in rest {
            let here = self.reach(*frames);
            // Between two samples the tool may both reach a body and press it too hard.
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
                // Clear of the body: the next contact starts with the full travel again.
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

/// Frames at an instant.
type View = (ArmInstant, Frames);

/// Carried object that a sensor sees.
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
