//! How motions begin and end, and what that does to the other parts: limits, outputs, tools, queue,
//! world.

use magician_motion::MotionError;
use magician_protocol::commands::{HomeCmd, JogCmd};
use magician_protocol::{AlarmSet, Writable};

use super::Device;
use super::effect::{Completion, ExecMode};
use super::motion::plan::{NoPlan, assumption_of_end};
use super::motion::{Ended, JogPlan, MotionKind, PathLine, PathPoint, Segment, Stage, Start};
use super::queue::Busy;
use crate::event::{Event, Refusal};
use crate::fidelity::Assumption;

impl Device {
    /// Begins a motion from where the arm stands. What moved before must have ended.
    pub(super) fn begin(&mut self, start: Start) -> Completion {
        let (kind, lasting) = (start.kind, start.duration());
        (self.motion).begin(self.now, self.firmware.model.law, start);
        self.watch_limits();
        if lasting > 0 {
            self.motion.show_path(self.now, &mut self.world);
            return Completion::Moving;
        }
        self.switch_outputs();
        if kind == MotionKind::Move {
            self.record.assume(Assumption::ShortMove);
        }
        self.end_motion();
        if self.motion.is_moving() {
            Completion::Moving
        } else {
            Completion::Done
        }
    }

    /// Something is due in the motion: an output, the drop of a limit alarm, its end.
    pub(super) fn motion_event(&mut self) {
        self.switch_outputs();
        if self.motion.is_over(self.now) {
            self.end_motion();
        } else {
            self.drop_limit_alarms();
            self.watch_limits();
        }
    }

    fn switch_outputs(&mut self) {
        while let Some(output) = self.motion.take_output(self.now) {
            self.switch(output);
        }
    }

    fn watch_limits(&mut self) {
        // A limit alarm that stands holds the queue.
        let standing = if self.alarms.latched() {
            self.alarms.standing()
        } else {
            AlarmSet::default()
        };
        (self.motion).watch_limits(self.now, &self.firmware.model.limits, standing);
    }

    fn end_motion(&mut self) {
        let Some(Ended { kind, alarm, speed }) = self.motion.end() else {
            return;
        };
        self.rest_here();
        if let Some(code) = alarm {
            self.record.assume(assumption_of_end(code));
            self.record.assume(Assumption::SoftLimits);
            self.raise(code);
            if self.queues.active().busy() == Some(Busy::Moving) {
                // Ended before its target, its command counts as finished all the same.
                self.record.assume(Assumption::RefusedFinishes);
            }
        }
        if self.follow_up(kind, speed) == Completion::Done {
            self.finish_moving();
        }
    }

    /// What a motion that came to its end with such a speed leads to.
    fn follow_up(&mut self, kind: MotionKind, speed: f64) -> Completion {
        match kind {
            MotionKind::Search(stage) => return self.search_on(stage),
            MotionKind::Segment(_) => {
                self.motion.set_junction_speed(speed);
                if speed == 0.0 {
                    // At rest the laser is off.
                    self.io.tools.burn(0.0);
                }
            }
            MotionKind::JogStop { then, .. } | MotionKind::RailJog { then } => {
                if let Some(jogged) = then {
                    let plan = self.view().jog_from_rest(jogged);
                    self.jog(plan);
                }
            }
            MotionKind::Move | MotionKind::Brake | MotionKind::Jog(_) => {}
        }
        Completion::Done
    }

    /// Ends what moves on the spot, without a ramp and without what would follow it: a command of
    /// the queue that it belongs to has finished, and the laser of a path is off.
    pub(super) fn halt(&mut self) {
        if self.rest_here() {
            self.io.tools.burn(0.0);
            self.finish_moving();
        }
    }

    /// Takes the motion away, at its end or before: the arm rests where it is. Whether there was
    /// one.
    fn rest_here(&mut self) -> bool {
        let moved = self.motion.rest(self.now, &mut self.world);
        if moved {
            self.drop_limit_alarms();
        }
        moved
    }

    /// Brakes what moves; a motion that brakes already goes on doing so.
    pub(super) fn brake(&mut self) {
        if let Some(start) = self.view().plan_brake() {
            // Its command finishes when the arm stands; the laser of a path is off at once.
            self.rest_here();
            self.io.tools.burn(0.0);
            let _: Completion = self.begin(start);
        }
    }

    /// Whatever happens on the way, the command has finished: the queue does not wait for a jog.
    pub(super) fn jog(&mut self, plan: JogPlan) {
        match plan {
            JogPlan::Unchanged => {}
            JogPlan::Begin(start) => {
                self.halt();
                let _: Completion = self.begin(start);
            }
            JogPlan::Continue(start) => {
                self.rest_here();
                let _: Completion = self.begin(start);
            }
            JogPlan::Then(kind) => self.motion.set_kind(kind),
            JogPlan::Refused(error) => self.unplannable(JogCmd::ROW.id, &error),
        }
    }
}

/// Homing.
impl Device {
    /// Begins homing. Until J1 is set the arm is not homed, even if it was before.
    pub(super) fn home(&mut self) -> Completion {
        self.halt();
        self.motion.set_homed(false);
        // A base that stands at its switch already has nothing to seek.
        self.search_on(Stage::Seek)
    }

    fn search_on(&mut self, stage: Stage) -> Completion {
        let Some(stage) = self.view().stage_after(stage) else {
            let geometry = self.view().geometry();
            let switch = self.firmware.model.homing.switch;
            self.motion.set_base(self.now, &geometry, switch);
            self.drop_limit_alarms();
            return self.go_home();
        };
        let planned = self.view().plan_search(stage);
        if planned.is_ok() && self.store.settings.motion.has_rail() {
            self.motion.find_rail(self.now);
        }
        self.begin_homing(planned)
    }

    /// A home point out of reach is passed over for the joints at which homing ends when none is
    /// set: the vendor's own demonstration sets such a point and goes on (model section 15a).
    fn go_home(&mut self) -> Completion {
        let id = HomeCmd::ROW.id;
        let planned = match self.view().plan_home_point() {
            Err(NoPlan::Arm(MotionError::Unreachable(_) | MotionError::Limit { .. }))
                if self.store.settings.home.is_some() =>
            {
                if !self.record.allows(id, Assumption::HomeOutOfReach) {
                    self.record.refuse(id, Refusal::Unplannable);
                    return Completion::Done;
                }
                self.record.event(Event::HomeOutOfReach);
                self.view().plan_home_joints()
            }
            planned => planned,
        };
        self.begin_homing(planned)
    }

    fn begin_homing(&mut self, planned: Result<Start, NoPlan>) -> Completion {
        match planned {
            Ok(start) => self.begin(start),
            Err(error) => {
                self.unplannable(HomeCmd::ROW.id, &error);
                Completion::Done
            }
        }
    }
}

/// Continuous paths: what waits in the queue decides how fast a segment may end.
impl Device {
    /// Begins a segment.
    pub(super) fn begin_segment(
        &mut self,
        id: u8,
        point: PathPoint,
        power: f32,
        mode: ExecMode,
    ) -> Completion {
        let view = self.view();
        let look_ahead = match view.look_ahead() {
            Ok(look_ahead) => look_ahead,
            Err(error) => {
                self.unplannable(id, &error.into());
                return Completion::Done;
            }
        };
        let queued = mode == ExecMode::Queued;
        let entry = if queued {
            self.motion.junction_speed()
        } else {
            0.0
        };
        let (from, planner) = (view.arm(), view.planner_given_rates());
        let way = PathLine::from(&planner, [from.pose.x, from.pose.y, from.pose.z], point);
        if way.is_empty() {
            // In the queue the speed of the segment before it goes on into the one after it.
            self.halt();
            return Completion::Done;
        }
        let segment = Segment::new(way, look_ahead, queued);
        let queue = self.queues.active_mut();
        if entry == 0.0 {
            // Whatever was known was known of a path that has ended.
            queue.forget_ways();
        }
        if queued {
            queue.resolve_ways(way.to(), |from, point| {
                PathLine::from(&planner, from, point)
            });
        }
        let speeds = [entry, self.exit_speed(&segment)];
        let planned = self.view().plan_segment(&planner, &from, segment, speeds);
        let impossible = match &planned {
            Ok(start) => start.alarm.is_some(),
            Err(_) => true,
        };
        if impossible && self.firmware.profile.motion.cp_drop_silently {
            self.halt();
            return Completion::Done;
        }
        match planned {
            Ok(start) => {
                self.halt();
                self.motion.set_junction_speed(0.0);
                self.io.tools.burn(f64::from(power));
                self.update_tools();
                self.begin(start)
            }
            Err(error) => {
                self.unplannable(id, &error);
                Completion::Done
            }
        }
    }

    /// The segment under way is planned anew if what is known now lets it end faster, or makes it
    /// end slower.
    pub(super) fn replan_segment(&mut self) {
        let Some(segment) = self.motion.segment() else {
            return;
        };
        // With a speed of 0 the next one would not begin.
        let exit = match self.view().look_ahead() {
            Ok(_) => self.exit_speed(&segment),
            Err(_) => 0.0,
        };
        if let Some(start) = self.view().replan_segment(exit) {
            self.rest_here();
            let _: Completion = self.begin(start);
        }
    }

    /// The speed at which a segment may end: none if the queue will not take the next one at once.
    fn exit_speed(&self, segment: &Segment) -> f64 {
        if !segment.is_queued() || !self.goes_on() {
            return 0.0;
        }
        segment.exit_speed(self.queues.active().ways())
    }

    /// A command has been queued: if it is a segment on the heels of another, its way is known at
    /// once.
    pub(super) fn path_grows(&mut self) {
        let view = self.view();
        let from = match self.queues.active().way_before_last() {
            Some(way) => way.map(|way| way.to()),
            None => self.motion.queued_segment_end(&view.geometry()),
        };
        let Some(from) = from else {
            return;
        };
        let planner = view.planner_given_rates();
        let queue = self.queues.active_mut();
        if queue.resolve_last(|point| PathLine::from(&planner, from, point)) {
            self.replan_segment();
        }
    }

    /// No segment has followed at once: whatever speed was left is lost, and the laser is off.
    pub(super) fn finish_path(&mut self) {
        if self.motion.junction_speed() != 0.0 {
            self.motion.set_junction_speed(0.0);
            if !self.motion.is_moving() {
                self.io.tools.burn(0.0);
                self.update_tools();
            }
        }
    }
}
