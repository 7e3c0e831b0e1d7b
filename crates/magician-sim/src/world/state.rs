//! Everything that a world which is not empty knows.

use std::sync::Arc;

use magician_motion::Geometry;
use magician_protocol::Port;

use super::agenda::Agenda;
use super::belt::Belt;
use super::drawing::Drawing;
use super::forecast::{Change, Changes, Forecast, carried_before};
use super::incident::{Incident, Incidents, What};
use super::ink::Ink;
use super::scene::{Frames, Rest, Scene};
use super::touch::{Contact, Reach};
use super::traffic::{self, Traffic};
use super::{Course, Grip, Happening, Place, Posture, Thing};
use crate::Micros;
use crate::scenario::{Action, Scenario, SensorKind, ToolKind};

/// A world that is not empty.
#[derive(Clone, Debug)]
pub(super) struct State {
    scenario: Arc<Scenario>,
    /// The latest instant that the world was told.
    now: Micros,
    agenda: Agenda,
    scene: Scene,
    belt: Belt,
    /// What the belt does next by itself.
    traffic: Option<Traffic>,
    grip: Grip,
    /// What the tool touches.
    contacts: Vec<(Thing, Contact)>,
    /// The carried object that each sensor sees.
    carried: Vec<Option<u16>>,
    /// What the course under way will bring.
    changes: Changes,
    /// For each object a bit for each sensor that has seen it.
    seen_by: Vec<u8>,
    /// The second of two things that happen at once.
    pending: Option<Happening>,
    ink: Ink,
    /// Whether a course is under way.
    moves: bool,
    incidents: Incidents,
}

impl State {
    pub(super) fn new(scenario: Scenario) -> Self {
        let belt = Belt::default();
        let start = frame_of_belt(&scenario, &belt, 0);
        let mut state = Self {
            now: 0,
            agenda: Agenda::new(scenario.script()),
            scene: Scene::new(&scenario, &start),
            belt,
            traffic: None,
            grip: Grip::default(),
            contacts: Vec::new(),
            carried: vec![None; scenario.sensors().len()],
            changes: Changes::new(),
            seen_by: vec![0; scenario.objects().len()],
            pending: None,
            ink: Ink::default(),
            moves: false,
            incidents: Incidents::default(),
            scenario: Arc::new(scenario),
        };
        state.mark_seen(0);
        state
    }

    pub(super) fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(super) fn incident(&mut self) -> Option<Incident> {
        self.incidents.pop()
    }

    pub(super) fn seen_by(&self, object: u16) -> u8 {
        self.seen_by.get(usize::from(object)).copied().unwrap_or(0)
    }

    pub(super) fn belt_travel(&self, now: Micros) -> f64 {
        self.belt.travel(now)
    }
}

/// Frames.
impl State {
    /// The tool's tip on an arm that stands so.
    fn tip(&self, posture: &Posture) -> Place {
        let geometry = Geometry::magician(self.scenario.tool().bias());
        let pose = geometry.forward(&posture.joints);
        Place {
            x: pose.x,
            y: pose.y + posture.rail,
            z: pose.z,
            yaw: pose.r,
        }
    }

    pub(super) fn frames(&self, now: Micros, posture: &Posture) -> Frames {
        Frames {
            belt: frame_of_belt(&self.scenario, &self.belt, now),
            tool: self.tip(posture),
        }
    }

    /// The frames for what the tool has no part in.
    fn frames_of_ground(&self, now: Micros) -> Frames {
        Frames {
            belt: frame_of_belt(&self.scenario, &self.belt, now),
            tool: Place::default(),
        }
    }

    fn reach(&self, frames: Frames) -> Reach<'_> {
        Reach {
            scenario: &self.scenario,
            scene: &self.scene,
            grip: self.grip,
            frames,
        }
    }
}

fn frame_of_belt(scenario: &Scenario, belt: &Belt, now: Micros) -> Place {
    scenario.conveyor().map_or_else(Place::default, |conveyor| {
        conveyor.frame_after(belt.travel(now))
    })
}

/// Inputs and sensors.
impl State {
    pub(super) fn digital(&self, address: u8) -> bool {
        self.agenda.digital(address)
    }

    pub(super) fn analog(&self, address: u8) -> u16 {
        self.agenda.analog(address)
    }

    pub(super) fn override_input(&mut self, action: Action) -> bool {
        self.agenda.override_input(self.now, action)
    }

    pub(super) fn color(&self, now: Micros, port: Port) -> Option<[u8; 3]> {
        let object = self.at_port(now, SensorKind::Color, port)?;
        let object = self.scenario.objects().get(usize::from(object))?;
        Some(object.color.0)
    }

    pub(super) fn infrared(&self, now: Micros, port: Port) -> bool {
        self.at_port(now, SensorKind::Infrared, port).is_some()
    }

    /// The object that the sensor of a connector sees.
    fn at_port(&self, now: Micros, kind: SensorKind, port: Port) -> Option<u16> {
        let sensors = self.scenario.sensors();
        let nth = sensors
            .iter()
            .position(|sensor| sensor.kind == kind && sensor.port == port)?;
        self.carried.get(nth).copied().flatten().or_else(|| {
            let frames = self.frames_of_ground(now);
            traffic::before(&self.scenario, &self.scene, &frames, nth)
        })
    }

    /// Remembers what the sensors see.
    fn mark_seen(&mut self, now: Micros) {
        let frames = self.frames_of_ground(now);
        for nth in 0..self.scenario.sensors().len() {
            let lying = traffic::before(&self.scenario, &self.scene, &frames, nth);
            let carried = self.carried.get(nth).copied().flatten();
            for object in [lying, carried].into_iter().flatten() {
                if let Some(seen_by) = self.seen_by.get_mut(usize::from(object)) {
                    *seen_by |= 1 << nth;
                }
            }
        }
    }
}

/// The arm moves and grips, the belt runs.
impl State {
    pub(super) fn begin(&mut self, course: &Course<'_>) {
        self.now = self.now.max(course.from);
        self.changes = self.forecast(course);
        self.moves = true;
    }

    fn forecast(&self, course: &Course<'_>) -> Changes {
        let frames = |at| self.frames(at, &course.at(at));
        let forecast = Forecast {
            reach: self.reach(frames(course.from)),
            frames,
        };
        forecast.changes(course, &self.contacts, &self.carried)
    }

    pub(super) fn end(&mut self, course: &Course<'_>) {
        self.now = self.now.max(course.to);
        let end = course.to;
        self.draw(course);
        self.moves = false;
        // What was due until now is still told; the rest will not come.
        self.changes.retain(|(at, _)| *at <= end);
        self.take_if_sucking(end, &course.at(end));
    }

    fn draw(&mut self, course: &Course<'_>) {
        let mut ink = std::mem::take(&mut self.ink);
        ink.follow(&self.scenario, course, |at| self.tip(&course.at(at)));
        self.ink = ink;
    }

    pub(super) fn drawing(&self) -> &Drawing {
        self.ink.drawing()
    }

    pub(super) fn drawing_with(&self, now: Micros, course: &Course<'_>) -> Drawing {
        let mut ink = self.ink.clone();
        let at = |at| course.at(at);
        let so_far = Course::new(course.from, course.to.min(now), &at);
        ink.follow(&self.scenario, &so_far, |at| self.tip(&course.at(at)));
        ink.into_drawing()
    }

    pub(super) fn grip(&mut self, now: Micros, grip: Grip, posture: &Posture) {
        self.now = self.now.max(now);
        if self.scenario.tool().kind == ToolKind::Laser && grip.laser != self.grip.laser {
            let tip = self.tip(posture);
            let resting = (!self.moves).then(|| tip.xy());
            self.ink.power(now, grip.laser, resting);
        }
        let (before, after) = (self.grips(&self.grip), self.grips(&grip));
        let frames = self.frames(now, posture);
        let reached_for = (after && !before && self.scene.held().is_none())
            .then(|| self.reach(frames).within_grasp())
            .flatten();
        self.grip = grip;
        if let Some(object) = reached_for {
            self.take(now, object, &frames);
        } else if before && !after {
            self.release(now, &frames);
        } else {
            return;
        }
        self.settle(now, &frames);
    }

    /// Whether a tool in that state holds what it has.
    fn grips(&self, grip: &Grip) -> bool {
        match self.scenario.tool().kind {
            ToolKind::Suction => grip.sucking,
            ToolKind::Gripper => grip.closed,
            ToolKind::None | ToolKind::Pen | ToolKind::Laser => false,
        }
    }

    /// A cup that sucks already takes what it is put on.
    fn take_if_sucking(&mut self, now: Micros, posture: &Posture) {
        let sucks = self.scenario.tool().kind == ToolKind::Suction && self.grip.sucking;
        if !sucks || self.scene.held().is_some() {
            return;
        }
        let frames = self.frames(now, posture);
        if let Some(object) = self.reach(frames).within_grasp() {
            self.take(now, object, &frames);
            self.settle(now, &frames);
        }
    }

    fn take(&mut self, now: Micros, object: u16, frames: &Frames) {
        self.scene.take(object, frames);
        self.incidents.push(now, What::Picked(object));
    }

    fn release(&mut self, now: Micros, frames: &Frames) {
        let slack = self.scenario.tool().give + 1.0;
        if let Some((object, rest)) = self.scene.drop_held(&self.scenario, frames, slack) {
            self.incidents.push(now, What::Released(object, rest));
        }
    }

    /// The tool has taken or let go of something: what it touches and carries is another thing, and so is what was
    /// foretold. What it touches now is no news.
    fn settle(&mut self, now: Micros, frames: &Frames) {
        self.changes.clear();
        let reach = self.reach(*frames);
        let things = [Thing::Table, Thing::Belt]
            .into_iter()
            .chain(self.scene.ids().map(Thing::Object));
        let contacts = things
            .filter_map(|thing| Some((thing, reach.at_start(thing, None).0?)))
            .collect();
        let carried = (0..self.carried.len())
            .map(|sensor| carried_before(&reach, sensor))
            .collect();
        self.contacts = contacts;
        self.carried = carried;
        self.mark_seen(now);
        self.watch_belt(now);
        self.agenda.look_again(now);
    }

    pub(super) fn stepper(&mut self, now: Micros, index: usize, pulses_per_second: f64) {
        self.now = self.now.max(now);
        let Some(conveyor) = self.scenario.conveyor() else {
            return;
        };
        if usize::from(conveyor.stepper) != index || !pulses_per_second.is_finite() {
            return;
        }
        let rate = pulses_per_second * conveyor.mm_per_pulse();
        self.belt.run(now, rate);
        self.watch_belt(now);
    }

    fn watch_belt(&mut self, now: Micros) {
        self.traffic = traffic::next(&self.scenario, &self.scene, &self.belt, now);
    }

    pub(super) fn index_started(&mut self, now: Micros, index: u64) {
        self.now = self.now.max(now);
        self.agenda
            .index_started(self.scenario.script(), now, index);
    }
}

/// What happens by itself.
impl State {
    pub(super) fn next_event(&self) -> Option<Micros> {
        let pending = self.pending.map(|_| self.now);
        let change = self.changes.front().map(|(at, _)| *at);
        let traffic = self.traffic.map(|traffic| traffic.at);
        let agenda = self.agenda.next_event(self.scenario.script());
        [pending, change, traffic, agenda]
            .into_iter()
            .flatten()
            .min()
    }

    pub(super) fn happen(&mut self, now: Micros) -> Option<Happening> {
        self.now = self.now.max(now);
        if let Some(happening) = self.pending.take() {
            return Some(happening);
        }
        loop {
            let at = self.next_event().filter(|at| *at <= now)?;
            let happening = if self
                .changes
                .front()
                .is_some_and(|(change, _)| *change == at)
            {
                self.change()
            } else if self.traffic.is_some_and(|traffic| traffic.at == at) {
                self.belt_event()
            } else {
                self.agenda.happen(self.scenario.script(), now)
            };
            if happening.is_some() {
                return happening;
            }
        }
    }

    fn change(&mut self) -> Option<Happening> {
        let (at, change) = self.changes.pop_front()?;
        match change {
            Change::Contact(thing, contact) => self.touch(at, thing, contact),
            Change::Carried(sensor, object) => {
                if let Some(carried) = self.carried.get_mut(sensor) {
                    *carried = object;
                }
                self.mark_seen(at);
                Some(Happening::Input)
            }
        }
    }

    /// The tool comes to a thing, or to press it, or away from it: what of it the arm feels.
    fn touch(&mut self, at: Micros, thing: Thing, contact: Option<Contact>) -> Option<Happening> {
        let place = self.contacts.iter().position(|(other, _)| *other == thing);
        let before = place.map(|place| self.contacts.swap_remove(place).1);
        self.contacts
            .extend(contact.map(|contact| (thing, contact)));
        let contact = contact?;
        let touches = Happening::Touch {
            thing,
            stalls: false,
        };
        let stalls = Happening::Touch {
            thing,
            stalls: true,
        };
        let first = match (before, contact, thing) {
            (None, Contact::Knock, Thing::Object(object)) => What::Knocked(object),
            (None, ..) => What::Touched(thing),
            (Some(_), Contact::Stall, _) => What::Pressed(thing),
            _ => return None,
        };
        self.incidents.push(at, first);
        if before.is_some() {
            return Some(stalls);
        }
        if contact == Contact::Stall {
            self.incidents.push(at, What::Pressed(thing));
            self.pending = Some(stalls);
        }
        Some(touches)
    }

    /// The belt has brought an object before a sensor, past it, or to its own end.
    fn belt_event(&mut self) -> Option<Happening> {
        let traffic = self.traffic.take()?;
        if let Some(object) = traffic.falls {
            let frames = self.frames_of_ground(traffic.at);
            let rest = traffic::run_off(&self.scenario, &mut self.scene, &frames, object);
            self.incidents
                .push(traffic.at, What::FellOffBelt(object, rest));
        }
        self.mark_seen(traffic.at);
        self.watch_belt(traffic.at);
        Some(Happening::Input)
    }

    pub(super) fn rest(&self, object: u16) -> Rest {
        self.scene.rest(object)
    }
}
