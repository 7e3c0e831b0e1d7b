//! What the belt does by itself: it carries objects before the sensors, past them, and off its end.

use std::time::Duration;

use super::ObjectPose;
use super::belt::Belt;
use super::scene::{Frames, Rest, Scene};
use crate::ArmInstant;
use crate::scenario::Scenario;

/// What the belt does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Traffic {
    pub(super) at: ArmInstant,
    /// The object that it runs off its end; else one comes before a sensor or past it.
    pub(super) falls: Option<u16>,
}

/// How many microseconds are looked at for the one at which a sensor sees something else: where an
/// edge is reached is exact but for rounding.
const EDGE: Duration = Duration::from_micros(3);

/// From one instant to the next.
const INSTANT: Duration = Duration::from_micros(1);

/// Every instant from one to another.
fn instants(from: ArmInstant, to: ArmInstant) -> impl Iterator<Item = ArmInstant> {
    (from.as_micros()..=to.as_micros()).map(ArmInstant::from_micros)
}

/// What the belt does next after an instant.
pub(super) fn next(
    scenario: &Scenario,
    scene: &Scene,
    belt: &Belt,
    now: ArmInstant,
) -> Option<Traffic> {
    if !belt.runs() {
        return None;
    }
    let watch = Watch {
        scenario,
        scene,
        belt,
        now,
    };
    let riding = || {
        scene
            .ids()
            .filter(|object| scene.root(*object) == Rest::Belt)
    };
    let falls = riding().filter_map(|object| {
        let at = watch.falls(object)?;
        Some(Traffic {
            at,
            falls: Some(object),
        })
    });
    let sights = riding().filter_map(|object| {
        let at = watch.sensor_changes(object)?;
        Some(Traffic { at, falls: None })
    });
    falls.chain(sights).min_by_key(|traffic| traffic.at)
}

/// The object, not carried by the tool, that a sensor sees: the nearest.
pub(super) fn before(
    scenario: &Scenario,
    scene: &Scene,
    frames: &Frames,
    sensor: usize,
) -> Option<u16> {
    let beam = &scenario.sensors().get(sensor)?.beam;
    let lying = scene.ids().filter(|object| !scene.is_carried(*object));
    lying
        .filter_map(|object| Some((object, scene.solid(object, scenario, frames).meets(beam)?)))
        .min_by(|(_, one), (_, other)| one.total_cmp(other))
        .map(|(object, _)| object)
}

/// The belt has run an object off its end: it falls beside the end, what stands on it with it.
pub(super) fn run_off(
    scenario: &Scenario,
    scene: &mut Scene,
    frames: &Frames,
    object: u16,
) -> Rest {
    let solid = scene.solid(object, scenario, frames);
    let Some(conveyor) = scenario.conveyor() else {
        return scene.rest(object);
    };
    let belt = conveyor.frame();
    let along = belt.to(&solid.place);
    let clear = solid.footprint().reach(belt.yaw);
    // It leaves over the end that it is nearer to.
    let x = if along.x > conveyor.length / 2.0 {
        conveyor.length + clear
    } else {
        -clear
    };
    let from = belt.then(&ObjectPose { x, ..along });
    scene.fall(object, from, 0.0, scenario, frames)
}

struct Watch<'a> {
    scenario: &'a Scenario,
    scene: &'a Scene,
    belt: &'a Belt,
    now: ArmInstant,
}

impl Watch<'_> {
    fn frames(&self, at: ArmInstant) -> Frames {
        let belt = self.scenario.conveyor();
        Frames {
            belt: belt.map_or_else(ObjectPose::default, |belt| {
                belt.frame_after(self.belt.travel(at))
            }),
            tool: ObjectPose::default(),
        }
    }

    /// When the middle of an object on the belt is beyond its end.
    fn falls(&self, object: u16) -> Option<ArmInstant> {
        if self.scene.rest(object) != Rest::Belt {
            return None;
        }
        let belt = self.scenario.conveyor()?;
        let along = |at| {
            belt.frame()
                .to(&self.scene.place(object, &self.frames(at)))
                .x
        };
        let (travel, here) = (self.belt.travel(self.now), along(self.now));
        let off = |at| !(0.0..=belt.length).contains(&along(at));
        let end = |edge: f64| self.belt.time_at(travel + edge - here, self.now);
        let at = [end(0.0), end(belt.length)].into_iter().flatten().max()?;
        instants(at, at + EDGE).find(|at| off(*at))
    }

    /// When the first sensor sees the object come or go.
    fn sensor_changes(&self, object: u16) -> Option<ArmInstant> {
        let belt = self.scenario.conveyor()?;
        let solid = self
            .scene
            .solid(object, self.scenario, &self.frames(self.now));
        let travel = self.belt.travel(self.now);
        let edges = self.scenario.sensors().iter().filter_map(|sensor| {
            let shifts = solid.meets_shifted(&sensor.beam, belt.direction)?;
            let sees = |at| {
                let there = self.scene.solid(object, self.scenario, &self.frames(at));
                there.meets(&sensor.beam).is_some()
            };
            let sees_now = sees(self.now);
            let edge = |shift: f64| {
                let at = self.belt.time_at(travel + shift, self.now - EDGE)?;
                let from = (at - INSTANT).max(self.now + INSTANT);
                instants(from, at + EDGE).find(|at| sees(*at) != sees_now)
            };
            shifts.into_iter().filter_map(edge).min()
        });
        edges.min()
    }
}
