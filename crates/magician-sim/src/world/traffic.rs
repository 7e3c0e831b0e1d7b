//! Events that the belt causes: it carries objects past sensors and off its end.
//!
//! The belt moves linearly, so the edges of an object reach a beam at closed-form times. Only a
//! few microseconds at each edge are searched, because rounding may shift it by one.

use std::time::Duration;

use super::ObjectPose;
use super::belt::Belt;
use super::scene::{Frames, Scene, Support};
use crate::ArmInstant;
use crate::scenario::Scenario;

/// The next event that the belt causes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BeltEvent {
    pub(super) at: ArmInstant,
    /// Object that runs off the end; `None` if an object enters or leaves a sensor.
    pub(super) falls: Option<u16>,
}

/// Span searched after a computed edge: its time is exact except for rounding.
const EDGE: Duration = Duration::from_micros(3);

/// Resolution of the arm's clock.
const INSTANT: Duration = Duration::from_micros(1);

/// Every microsecond from one instant to another.
fn instants(from: ArmInstant, to: ArmInstant) -> impl Iterator<Item = ArmInstant> {
    (from.as_micros()..=to.as_micros()).map(ArmInstant::from_micros)
}

/// Returns the next event of the belt after an instant.
pub(super) fn next(
    scenario: &Scenario,
    scene: &Scene,
    belt: &Belt,
    now: ArmInstant,
) -> Option<BeltEvent> {
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
            .filter(|object| scene.root(*object) == Support::Belt)
    };
    let falls = riding().filter_map(|object| {
        let at = watch.falls(object)?;
        Some(BeltEvent {
            at,
            falls: Some(object),
        })
    });
    let sights = riding().filter_map(|object| {
        let at = watch.sensor_changes(object)?;
        Some(BeltEvent { at, falls: None })
    });
    falls.chain(sights).min_by_key(|traffic| traffic.at)
}

/// Nearest object that a sensor sees, except objects carried by the tool.
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

/// Drops an object, with everything stacked on it, just beyond the end of the belt. Returns what it
/// lands on.
pub(super) fn run_off(
    scenario: &Scenario,
    scene: &mut Scene,
    frames: &Frames,
    object: u16,
) -> Support {
    let solid = scene.solid(object, scenario, frames);
    let Some(conveyor) = scenario.conveyor() else {
        return scene.rest(object);
    };
    let belt = conveyor.frame();
    let along = belt.to(&solid.place);
    // Far enough out that it cannot land on the belt again.
    let clear = solid.footprint().reach(belt.yaw);
    // The object leaves over the closer end.
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

    /// Instant at which the middle of an object on the belt passes an end.
    fn falls(&self, object: u16) -> Option<ArmInstant> {
        // Only the bottom object of a stack runs off; the others fall with it.
        if self.scene.rest(object) != Support::Belt {
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

    /// Next instant at which any sensor starts or stops seeing the object.
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
                // Start a little early: an edge reached just now must not be skipped by rounding.
                let at = self.belt.time_at(travel + shift, self.now - EDGE)?;
                let from = (at - INSTANT).max(self.now + INSTANT);
                instants(from, at + EDGE).find(|at| sees(*at) != sees_now)
            };
            shifts.into_iter().filter_map(edge).min()
        });
        edges.min()
    }
}
