//! The world without a controller: paths are closures, and time goes from event to event.

mod contact;
mod conveyor;
mod drawing;
mod example;
mod fuzz;
mod grasp;
mod plane;
mod script;

use magician_motion::{Geometry, Pose};
use magician_protocol::Port;

use super::{Drawing, ExternalEvent, JointState, ToolState, WorldView};
use crate::ArmInstant;
use crate::Micros;
use crate::scenario::Scenario;

const SECOND: Micros = 1_000_000;

fn world(text: &str) -> World {
    match Scenario::from_toml(text) {
        Ok(scenario) => World(super::World::from_scenario(&scenario)),
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// The world, with the arm's clock in microseconds.
#[derive(Clone, Default)]
struct World(super::World);

/// A path as a function of microseconds.
struct TimedPath<'a> {
    from: Micros,
    to: Micros,
    at: &'a dyn Fn(Micros) -> JointState,
}

impl<'a> TimedPath<'a> {
    fn new(from: Micros, to: Micros, at: &'a dyn Fn(Micros) -> JointState) -> Self {
        Self { from, to, at }
    }

    fn with<T>(&self, told: impl FnOnce(&super::TimedPath<'_>) -> T) -> T {
        let [from, to] = [self.from, self.to].map(ArmInstant::from_micros);
        let at = |now: ArmInstant| (self.at)(now.as_micros());
        told(&super::TimedPath::new(from, to, &at))
    }
}

impl World {
    fn begin(&mut self, path: &TimedPath<'_>) {
        path.with(|path| self.0.begin(path));
    }

    fn end(&mut self, path: &TimedPath<'_>) {
        path.with(|path| self.0.end(path));
    }

    fn drawing_at(&self, now: Micros, path: Option<&TimedPath<'_>>) -> Drawing {
        let now = ArmInstant::from_micros(now);
        match path {
            Some(path) => path.with(|path| self.0.drawing_at(now, Some(path))),
            None => self.0.drawing_at(now, None),
        }
    }

    fn look(&self, now: Micros, at: &JointState) -> WorldView<'_> {
        self.0.look(ArmInstant::from_micros(now), at)
    }

    fn next_event(&self) -> Option<Micros> {
        self.0.next_event().map(ArmInstant::as_micros)
    }

    fn poll_external(&mut self, now: Micros) -> Option<ExternalEvent> {
        self.0.poll_external(ArmInstant::from_micros(now))
    }

    fn set_tool(&mut self, now: Micros, tool: ToolState, at: &JointState) {
        self.0.set_tool(ArmInstant::from_micros(now), tool, at);
    }

    fn stepper(&mut self, now: Micros, index: usize, pulses_per_second: f64) {
        let now = ArmInstant::from_micros(now);
        self.0.stepper(now, index, pulses_per_second);
    }

    fn index_started(&mut self, now: Micros, index: u64) {
        self.0.index_started(ArmInstant::from_micros(now), index);
    }

    fn digital(&self, now: Micros, address: u8) -> Option<bool> {
        self.0.digital(ArmInstant::from_micros(now), address)
    }

    fn analog(&self, now: Micros, address: u8) -> Option<u16> {
        self.0.analog(ArmInstant::from_micros(now), address)
    }

    fn color(&self, now: Micros, port: Port) -> [u8; 3] {
        self.0.color(ArmInstant::from_micros(now), port)
    }

    fn infrared(&self, now: Micros, port: Port) -> bool {
        self.0.infrared(ArmInstant::from_micros(now), port)
    }
}

impl std::ops::Deref for World {
    type Target = super::World;

    fn deref(&self) -> &super::World {
        &self.0
    }
}

impl std::ops::DerefMut for World {
    fn deref_mut(&mut self) -> &mut super::World {
        &mut self.0
    }
}

/// An arm without a controller: it moves in straight lines as called, and records events.
struct Arm {
    world: World,
    geometry: Geometry,
    now: Micros,
    at: Pose,
    tool: ToolState,
    happened: Vec<(Micros, ExternalEvent)>,
}

impl Arm {
    fn new(text: &str, at: [f64; 4]) -> Self {
        let world = world(text);
        let tool = world.scenario().expect("not empty").tool().bias();
        Self {
            world,
            geometry: Geometry::magician(tool),
            now: 0,
            at: at.into(),
            tool: ToolState::default(),
            happened: Vec::new(),
        }
    }

    fn joint_state(&self, pose: &Pose) -> JointState {
        joint_state(&self.geometry, pose)
    }

    /// Advances time to an instant.
    fn wait_until(&mut self, to: Micros) {
        let mut told = 0;
        while let Some(at) = self.world.next_event().filter(|at| *at <= to) {
            self.now = self.now.max(at);
            while let Some(event) = self.world.poll_external(self.now) {
                self.happened.push((self.now, event));
                told += 1;
                assert!(told < 10_000, "{:?}", self.happened.last());
            }
        }
        self.now = to;
    }

    /// Moves to a pose at constant speed, and stays there.
    fn go(&mut self, to: [f64; 4], lasting: Micros) {
        self.go_until(to, lasting, lasting);
    }

    /// Starts towards a pose, but stops abruptly `stopped` microseconds after the start.
    fn go_until(&mut self, to: [f64; 4], lasting: Micros, stopped: Micros) {
        let way = Way {
            geometry: self.geometry,
            from: self.at,
            to: to.into(),
            start: self.now,
            lasting,
        };
        let at = |now| way.joint_state(now);
        self.world
            .begin(&TimedPath::new(way.start, way.start + lasting, &at));
        let end = way.start + stopped;
        self.wait_until(end);
        self.world.end(&TimedPath::new(way.start, end, &at));
        self.wait_until(end);
        self.at = way.pose(end);
    }

    fn set_tool(&mut self, tool: ToolState) {
        self.tool = tool;
        self.world
            .set_tool(self.now, tool, &self.joint_state(&self.at));
        self.wait_until(self.now);
    }

    fn suck(&mut self, sucking: bool) {
        self.set_tool(ToolState {
            sucking,
            ..self.tool
        });
    }

    fn close(&mut self, closed: bool) {
        self.set_tool(ToolState {
            closed,
            ..self.tool
        });
    }

    fn laser(&mut self, laser: f64) {
        self.set_tool(ToolState { laser, ..self.tool });
    }

    fn look(&self) -> WorldView<'_> {
        self.world.look(self.now, &self.joint_state(&self.at))
    }

    /// Touches and stalls, with their times.
    fn touches(&self) -> Vec<(Micros, ExternalEvent)> {
        let touch = |event: &ExternalEvent| matches!(event, ExternalEvent::Touch { .. });
        self.happened
            .iter()
            .filter(|(_, event)| touch(event))
            .copied()
            .collect()
    }
}

/// A straight path at constant speed.
struct Way {
    geometry: Geometry,
    from: Pose,
    to: Pose,
    start: Micros,
    lasting: Micros,
}

impl Way {
    fn pose(&self, now: Micros) -> Pose {
        let share = (now - self.start) as f64 / self.lasting as f64;
        let (from, to) = (self.from.to_array(), self.to.to_array());
        Pose::from(std::array::from_fn(|axis| {
            from[axis] + (to[axis] - from[axis]) * share
        }))
    }

    fn joint_state(&self, now: Micros) -> JointState {
        joint_state(&self.geometry, &self.pose(now))
    }
}

fn joint_state(geometry: &Geometry, pose: &Pose) -> JointState {
    JointState {
        joints: geometry.inverse(pose).expect("within reach"),
        rail: 0.0,
    }
}

fn near(one: f64, other: f64) -> bool {
    (one - other).abs() < 1e-6
}
