//! Calls of the controller: motions, grips, the belt, started commands.

use super::WorldState;
use crate::ArmInstant;
use crate::scenario::ToolKind;
use crate::world::event::WorldEventKind;
use crate::world::forecast::{Changes, Forecast, carried_before};
use crate::world::scene::Frames;
use crate::world::traffic;
use crate::world::{Body, Drawing, GripCount, JointState, TimedPath, ToolState};

impl WorldState {
    pub(in crate::world) fn begin(&mut self, path: &TimedPath<'_>) {
        self.now = self.now.max(path.from);
        self.changes = self.forecast(path);
        self.moves = true;
    }

    fn forecast(&self, path: &TimedPath<'_>) -> Changes {
        let frames = |at| self.frames(at, &path.at(at));
        let forecast = Forecast {
            reach: self.reach(frames(path.from)),
            frames,
        };
        forecast.changes(path, &self.contacts, &self.carried)
    }

    pub(in crate::world) fn end(&mut self, path: &TimedPath<'_>) {
        self.now = self.now.max(path.to);
        let end = path.to;
        self.draw(path);
        self.moves = false;
        // Changes due until now are still reported; the rest will not happen.
        self.changes.retain(|(at, _)| *at <= end);
        self.take_if_sucking(end, &path.at(end));
    }

    fn draw(&mut self, path: &TimedPath<'_>) {
        let mut ink = std::mem::take(&mut self.ink);
        ink.follow(&self.scenario, path, |at| self.tip(&path.at(at)));
        self.ink = ink;
    }

    pub(in crate::world) fn drawing(&self) -> &Drawing {
        self.ink.drawing()
    }

    pub(in crate::world) fn clear_drawing(&mut self) {
        self.ink.clear();
    }

    pub(in crate::world) fn drawing_with(&self, now: ArmInstant, path: &TimedPath<'_>) -> Drawing {
        let mut ink = self.ink.clone();
        let at = |at| path.at(at);
        let so_far = TimedPath::new(path.from, path.to.min(now), &at);
        ink.follow(&self.scenario, &so_far, |at| self.tip(&path.at(at)));
        ink.into_drawing()
    }

    pub(in crate::world) fn set_tool(
        &mut self,
        now: ArmInstant,
        tool: ToolState,
        joint_state: &JointState,
    ) {
        self.now = self.now.max(now);
        // Only a mounted laser burns; the pins of another tool may still be driven.
        if self.scenario.tool().kind == ToolKind::Laser && tool.laser != self.tool.laser {
            let tip = self.tip(joint_state);
            let resting = (!self.moves).then(|| tip.xy());
            self.ink.power(now, tool.laser, resting);
        }
        let (before, after) = (self.grips(&self.tool), self.grips(&tool));
        let begins = after && !before && self.scene.held().is_none();
        self.grips.begun += u64::from(begins);
        let frames = self.frames(now, joint_state);
        // Computed before the state changes: a closed gripper has nothing between its fingers.
        let reached_for = begins.then(|| self.reach(frames).within_grasp()).flatten();
        self.tool = tool;
        if let Some(object) = reached_for {
            self.take(now, object, &frames);
        } else if before && !after {
            self.release(now, &frames);
        } else {
            // Nothing was gripped or let go, so contacts and predictions hold.
            return;
        }
        self.settle(now, &frames);
    }

    pub(in crate::world) const fn grip_count(&self) -> GripCount {
        self.grips
    }

    /// True if a tool in this state holds its object.
    fn grips(&self, tool: &ToolState) -> bool {
        match self.scenario.tool().kind {
            ToolKind::Suction => tool.sucking,
            ToolKind::Gripper => tool.closed,
            ToolKind::None | ToolKind::Pen | ToolKind::Laser => false,
        }
    }

    /// At the end of a motion with the suction on, takes the object under the cup.
    fn take_if_sucking(&mut self, now: ArmInstant, joint_state: &JointState) {
        let sucks = self.scenario.tool().kind == ToolKind::Suction && self.tool.sucking;
        if !sucks || self.scene.held().is_some() {
            return;
        }
        let frames = self.frames(now, joint_state);
        if let Some(object) = self.reach(frames).within_grasp() {
            self.take(now, object, &frames);
            self.settle(now, &frames);
        }
    }

    fn take(&mut self, now: ArmInstant, object: u16, frames: &Frames) {
        self.scene.take(object, frames);
        self.grips.taken += 1;
        self.events.push(now, WorldEventKind::Picked(object));
    }

    /// Moves an object by hand. Returns false if there is no object of that name.
    pub(in crate::world) fn place(
        &mut self,
        now: ArmInstant,
        joint_state: &JointState,
        name: &str,
        at: [f64; 3],
    ) -> bool {
        self.now = self.now.max(now);
        let mut objects = self.scenario.objects().iter();
        let object = objects.position(|object| object.name == name);
        let Some(object) = object.and_then(|at| u16::try_from(at).ok()) else {
            return false;
        };
        let frames = self.frames(now, joint_state);
        self.scene.set_down(object, at, &self.scenario, &frames);
        self.settle(now, &frames);
        true
    }

    fn release(&mut self, now: ArmInstant, frames: &Frames) {
        // The tool may have pressed the object into its support by `give`; 1 mm more is tolerance.
        let slack = self.scenario.tool().give + 1.0;
        if let Some((object, rest)) = self.scene.drop_held(&self.scenario, frames, slack) {
            self.events
                .push(now, WorldEventKind::Released(object, rest));
        }
    }

    /// Updates contacts and sensors after a pick or a release, and drops the prediction.
    ///
    /// The touched and the carried bodies have changed. Contacts that exist now are not reported as
    /// new.
    fn settle(&mut self, now: ArmInstant, frames: &Frames) {
        self.changes.clear();
        let reach = self.reach(*frames);
        let bodies = [Body::Table, Body::Belt]
            .into_iter()
            .chain(self.scene.ids().map(Body::Object));
        let contacts = bodies
            .filter_map(|body| Some((body, reach.at_start(body, None).0?)))
            .collect();
        let carried = (0..self.carried.len())
            .map(|sensor| carried_before(&reach, sensor))
            .collect();
        self.contacts = contacts;
        self.carried = carried;
        self.mark_seen(now);
        self.watch_belt(now);
        // A sensor may see something else now, and a TRIG may wait for it.
        self.script.look_again(now);
    }

    pub(in crate::world) fn stepper(
        &mut self,
        now: ArmInstant,
        index: usize,
        pulses_per_second: f64,
    ) {
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

    pub(super) fn watch_belt(&mut self, now: ArmInstant) {
        self.traffic = traffic::next(&self.scenario, &self.scene, &self.belt, now);
    }

    pub(in crate::world) fn index_started(&mut self, now: ArmInstant, index: u64) {
        self.now = self.now.max(now);
        self.script
            .index_started(self.scenario.script(), now, index);
    }
}
