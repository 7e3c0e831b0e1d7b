//! Start and end of motions, and their effect on limits, outputs, tools, queue and world.
//!
//! Every motion passes through [`begin`](Device::begin) and [`end_motion`](Device::end_motion),
//! whatever started it. A motion that is taken away early goes through [`halt`](Device::halt). What
//! follows an end depends on the [`MotionKind`]: homing searches on, a path keeps its speed for the
//! next segment, a stopped jog may be followed by another.

use magician_motion::MotionError;
use magician_protocol::commands::{HomeCmd, JogCmd};
use magician_protocol::{AlarmSet, Writable};

use super::Device;
use super::effect::{Completion, ExecMode};
use super::motion::plan::{PlanError, assumption_of_end};
use super::motion::{
    HomingStage, JogPlan, MotionEnd, MotionKind, PathLine, PathPoint, PlannedMotion, Segment,
};
use super::queue::Activity;
use crate::event::{Event, Refusal};
use crate::fidelity::Assumption;

impl Device {
    /// Starts a motion from where the arm stands. The previous motion must have ended.
    pub(super) fn begin(&mut self, start: PlannedMotion) -> Completion {
        let (kind, lasting) = (start.kind, start.duration());
        (self.motion).begin(self.now, self.firmware.model.law, start);
        self.watch_limits();
        if lasting > 0 {
            self.motion.show_path(self.now, &mut self.world);
            return Completion::Moving;
        }
        // Nothing to move: the motion ends in this instant, with its outputs and its alarm.
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

    /// Handles what is due in the motion: an output, a limit alarm that drops, or the end.
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
        // Only a standing limit alarm can drop, and it has latched the hold. Without the latch the
        // search for that moment is skipped.
        let standing = if self.alarms.latched() {
            self.alarms.standing()
        } else {
            AlarmSet::default()
        };
        (self.motion).watch_limits(self.now, &self.firmware.model.limits, standing);
    }

    fn end_motion(&mut self) {
        let Some(MotionEnd { kind, alarm, speed }) = self.motion.end() else {
            return;
        };
        self.rest_here();
        if let Some(code) = alarm {
            self.record.assume(assumption_of_end(code));
            self.record.assume(Assumption::SoftLimits);
            self.raise(code);
            if self.queues.active().busy() == Some(Activity::Moving) {
                // A motion that is cut short counts as finished (model section 15a).
                self.record.assume(Assumption::RefusedFinishes);
            }
        }
        if self.follow_up(kind, speed) == Completion::Done {
            self.finish_moving();
        }
    }

    /// Continues after the end of a motion. `speed` is the speed at that end, mm/s.
    fn follow_up(&mut self, kind: MotionKind, speed: f64) -> Completion {
        match kind {
            MotionKind::Search(stage) => return self.search_on(stage),
            MotionKind::Segment(_) => {
                self.motion.set_junction_speed(speed);
                if speed == 0.0 {
                    // At rest the laser is off (model section 8).
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

    /// Ends the running motion at once, without a ramp and without its continuation.
    ///
    /// A queued command that it belongs to has finished, and the laser of a path is off.
    pub(super) fn halt(&mut self) {
        if self.rest_here() {
            // Off here, too: the motion that follows is no continuation of the path.
            self.io.tools.burn(0.0);
            self.finish_moving();
        }
    }

    /// Removes the running motion, at its end or before; the arm rests where it is. Returns true if
    /// there was one.
    fn rest_here(&mut self) -> bool {
        let moved = self.motion.rest(self.now, &mut self.world);
        if moved {
            // The commanded joints have changed, so a joint may be back inside.
            self.drop_limit_alarms();
        }
        moved
    }

    /// Brakes the running motion. A motion already braking continues to do so.
    pub(super) fn brake(&mut self) {
        if let Some(start) = self.view().plan_brake() {
            // The queued command of the motion finishes when the arm stands, but the laser is off
            // at once.
            self.rest_here();
            self.io.tools.burn(0.0);
            let _: Completion = self.begin(start);
        }
    }

    /// Applies a plan for a jog. The command has finished in any case: the queue does not wait for
    /// a jog.
    pub(super) fn jog(&mut self, plan: JogPlan) {
        match plan {
            JogPlan::Unchanged => {}
            JogPlan::Begin(start) => {
                self.halt();
                let _: Completion = self.begin(start);
            }
            // Not `halt`: the same jog goes on as a ramp, so no command finishes and the laser
            // stays as it is.
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
    /// Starts homing. Until J1 is referenced the arm is not homed, even if it was before.
    pub(super) fn home(&mut self) -> Completion {
        self.halt();
        self.motion.set_homed(false);
        // Enter at the first stage: a base that stands at its switch already skips the search.
        self.search_on(HomingStage::Seek)
    }

    fn search_on(&mut self, stage: HomingStage) -> Completion {
        // The switch has closed for the last time: J1 is referenced.
        let Some(stage) = self.view().stage_after(stage) else {
            let geometry = self.view().geometry();
            let switch = self.firmware.model.homing.switch;
            self.motion.set_base(self.now, &geometry, switch);
            self.drop_limit_alarms();
            return self.go_home();
        };
        let planned = self.view().plan_search(stage);
        // The rail homes along with the search. Its true position becomes known now, because the
        // search takes the carriage to its end.
        if planned.is_ok() && self.store.settings.motion.has_rail() {
            self.motion.find_rail(self.now);
        }
        self.begin_homing(planned)
    }

    /// Plans the last part of homing, the move to the home point.
    ///
    /// A home point out of reach is replaced by the default joints, because the vendor's own
    /// demonstration sets such a point and goes on (model section 15a).
    fn go_home(&mut self) -> Completion {
        let id = HomeCmd::ROW.id;
        let planned = match self.view().plan_home_point() {
            Err(PlanError::Arm(MotionError::Unreachable(_) | MotionError::Limit { .. }))
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

    fn begin_homing(&mut self, planned: Result<PlannedMotion, PlanError>) -> Completion {
        match planned {
            Ok(start) => self.begin(start),
            Err(error) => {
                self.unplannable(HomeCmd::ROW.id, &error);
                Completion::Done
            }
        }
    }
}

/// Continuous paths: the queue decides how fast a segment may end.
impl Device {
    /// Starts a segment.
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
        // An immediate segment follows nothing, so it starts from rest.
        let queued = mode == ExecMode::Queued;
        let entry = if queued {
            self.motion.junction_speed()
        } else {
            0.0
        };
        let (from, planner) = (view.arm(), view.planner_given_rates());
        let way = PathLine::from(&planner, [from.pose.x, from.pose.y, from.pose.z], point);
        if way.is_empty() {
            // A segment of no length is no corner: the speed of the previous segment passes to the
            // next.
            self.halt();
            return Completion::Done;
        }
        let segment = Segment::new(way, look_ahead, queued);
        let queue = self.queues.active_mut();
        if entry == 0.0 {
            // At rest a new path begins, and known lines may stem from the previous one.
            queue.forget_path_lines();
        }
        if queued {
            queue.resolve_path_lines(way.to(), |from, point| {
                PathLine::from(&planner, from, point)
            });
        }
        // Both ends follow from the neighbours: the speed left by the previous segment, and the
        // look-ahead.
        let speeds = [entry, self.exit_speed(&segment)];
        let planned = self.view().plan_segment(&planner, &from, segment, speeds);
        // A plan with an alarm would stop at a limit on the way: also a segment that cannot be
        // done.
        let impossible = match &planned {
            Ok(start) => start.alarm.is_some(),
            Err(_) => true,
        };
        // One arm was seen to drop such segments without an alarm (model section 8).
        if impossible && self.firmware.profile.motion.cp_drop_silently {
            self.halt();
            return Completion::Done;
        }
        match planned {
            Ok(start) => {
                // Halt before the laser is set: it ends the previous motion and its laser.
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

    /// Replans the running segment if it may now end faster, or has to end slower.
    pub(super) fn replan_segment(&mut self) {
        let Some(segment) = self.motion.segment() else {
            return;
        };
        // An exit speed of 0 ends the path, because look-ahead cannot be computed without valid
        // speeds.
        let exit = match self.view().look_ahead() {
            Ok(_) => self.exit_speed(&segment),
            Err(_) => 0.0,
        };
        // `None` if nothing changes: most commands do not affect the path.
        if let Some(start) = self.view().replan_segment(exit) {
            self.rest_here();
            let _: Completion = self.begin(start);
        }
    }

    /// Highest exit speed of a segment, mm/s; 0 if the queue will not take the next one at once.
    fn exit_speed(&self, segment: &Segment) -> f64 {
        // An immediate segment has no successor, and a held or stopped queue will not deliver one.
        if !segment.is_queued() || !self.goes_on() {
            return 0.0;
        }
        segment.exit_speed(self.queues.active().path_lines())
    }

    /// Resolves the line of a segment just queued, if it follows another segment.
    pub(super) fn path_grows(&mut self) {
        let view = self.view();
        let from = match self.queues.active().path_line_before_last() {
            Some(way) => way.map(|way| way.to()),
            None => self.motion.queued_segment_end(&view.geometry()),
        };
        let Some(from) = from else {
            return;
        };
        let planner = view.planner_given_rates();
        let queue = self.queues.active_mut();
        // Only a segment changes the look-ahead; any other command is where the path ends already.
        if queue.resolve_last(|point| PathLine::from(&planner, from, point)) {
            self.replan_segment();
        }
    }

    /// Ends a path that no segment has continued: the remaining speed is lost and the laser is off.
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
