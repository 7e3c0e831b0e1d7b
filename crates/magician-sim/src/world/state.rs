//! State of a world with contents.

use std::sync::Arc;

use magician_motion::Geometry;
use magician_protocol::Port;

use super::belt::Belt;
use super::event::{WorldEvent, WorldEvents};
use super::forecast::Changes;
use super::ink::Ink;
use super::scene::{Frames, Scene, Support};
use super::script::ScriptPlayer;
use super::touch::{Contact, Reach};
use super::traffic::{self, BeltEvent};
use super::{Body, ExternalEvent, GripCount, JointState, ObjectPose, ToolState};
use crate::ArmInstant;
use crate::scenario::{Action, Scenario, SensorKind};

mod arm;
mod events;

/// State of a world with contents.
#[derive(Clone, Debug)]
pub(super) struct WorldState {
    scenario: Arc<Scenario>,
    /// Latest instant known.
    now: ArmInstant,
    script: ScriptPlayer,
    scene: Scene,
    belt: Belt,
    /// Next event that the belt causes.
    traffic: Option<BeltEvent>,
    tool: ToolState,
    grips: GripCount,
    /// Bodies that the tool touches.
    contacts: Vec<(Body, Contact)>,
    /// Carried object that each sensor sees.
    carried: Vec<Option<u16>>,
    /// Predicted changes of the running path.
    changes: Changes,
    /// For each object one bit for each sensor that has seen it.
    seen_by: Vec<u8>,
    /// Second of two events at the same instant, reported after the first.
    pending: Option<ExternalEvent>,
    ink: Ink,
    /// True while a path is under way.
    moves: bool,
    events: WorldEvents,
}

impl WorldState {
    pub(super) fn new(scenario: Scenario) -> Self {
        let belt = Belt::default();
        let start = frame_of_belt(&scenario, &belt, ArmInstant::ZERO);
        let mut state = Self {
            now: ArmInstant::ZERO,
            script: ScriptPlayer::new(scenario.script()),
            scene: Scene::new(&scenario, &start),
            belt,
            traffic: None,
            tool: ToolState::default(),
            grips: GripCount::default(),
            contacts: Vec::new(),
            carried: vec![None; scenario.sensors().len()],
            changes: Changes::new(),
            seen_by: vec![0; scenario.objects().len()],
            pending: None,
            ink: Ink::default(),
            moves: false,
            events: WorldEvents::default(),
            scenario: Arc::new(scenario),
        };
        state.mark_seen(ArmInstant::ZERO);
        state
    }

    pub(super) fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    pub(super) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(super) fn rest(&self, object: u16) -> Support {
        self.scene.rest(object)
    }

    pub(super) fn event(&mut self) -> Option<WorldEvent> {
        self.events.pop()
    }

    pub(super) fn seen_by(&self, object: u16) -> u8 {
        self.seen_by.get(usize::from(object)).copied().unwrap_or(0)
    }

    pub(super) fn belt_travel(&self, now: ArmInstant) -> f64 {
        self.belt.travel(now)
    }
}

/// Frames of reference.
impl WorldState {
    /// Position of the tool's tip for an arm in this state.
    fn tip(&self, joint_state: &JointState) -> ObjectPose {
        let geometry = Geometry::magician(self.scenario.tool().bias());
        let pose = geometry.forward(&joint_state.joints);
        // The rail runs along Y of the arm's base.
        ObjectPose {
            x: pose.x,
            y: pose.y + joint_state.rail,
            z: pose.z,
            yaw: pose.r,
        }
    }

    pub(super) fn frames(&self, now: ArmInstant, joint_state: &JointState) -> Frames {
        Frames {
            belt: frame_of_belt(&self.scenario, &self.belt, now),
            tool: self.tip(joint_state),
        }
    }

    /// Frames for queries that do not involve the tool.
    fn frames_of_ground(&self, now: ArmInstant) -> Frames {
        Frames {
            belt: frame_of_belt(&self.scenario, &self.belt, now),
            tool: ObjectPose::default(),
        }
    }

    fn reach(&self, frames: Frames) -> Reach<'_> {
        Reach {
            scenario: &self.scenario,
            scene: &self.scene,
            tool: self.tool,
            frames,
        }
    }
}

fn frame_of_belt(scenario: &Scenario, belt: &Belt, now: ArmInstant) -> ObjectPose {
    scenario
        .conveyor()
        .map_or_else(ObjectPose::default, |conveyor| {
            conveyor.frame_after(belt.travel(now))
        })
}

/// Inputs and sensors.
impl WorldState {
    pub(super) fn digital(&self, address: u8) -> Option<bool> {
        self.script.digital(address)
    }

    pub(super) fn analog(&self, address: u8) -> Option<u16> {
        self.script.analog(address)
    }

    pub(super) fn will_change(&self, address: u8) -> bool {
        self.script.will_change(self.scenario.script(), address)
    }

    pub(super) fn override_input(&mut self, action: Action) -> bool {
        self.script.override_input(self.now, action)
    }

    pub(super) fn color(&self, now: ArmInstant, port: Port) -> Option<[u8; 3]> {
        let object = self.at_port(now, SensorKind::Color, port)?;
        let object = self.scenario.objects().get(usize::from(object))?;
        Some(object.color.0)
    }

    pub(super) fn infrared(&self, now: ArmInstant, port: Port) -> bool {
        self.at_port(now, SensorKind::Infrared, port).is_some()
    }

    /// Object that the sensor of a connector sees.
    fn at_port(&self, now: ArmInstant, kind: SensorKind, port: Port) -> Option<u16> {
        let sensors = self.scenario.sensors();
        let nth = sensors
            .iter()
            .position(|sensor| sensor.kind == kind && sensor.port == port)?;
        // A carried object comes from the prediction, anything else from the positions now.
        self.carried.get(nth).copied().flatten().or_else(|| {
            let frames = self.frames_of_ground(now);
            traffic::before(&self.scenario, &self.scene, &frames, nth)
        })
    }

    /// Records which objects the sensors see.
    fn mark_seen(&mut self, now: ArmInstant) {
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
