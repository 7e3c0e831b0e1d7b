//! Application of the effects of commands to the parts of the device.
//!
//! Handlers cannot reach queue, motion and alarms for writing. All changes to these are here, so
//! the order in which parts are updated is decided in one place.

use magician_motion::Bound;
use magician_protocol::commands::IoDo;
use magician_protocol::{Alarm, Flag, PoCmd, Row, Set, Writable};

use super::Device;
use super::effect::{Completion, Effect, Effects, ExecMode};
use super::handlers::{self, Apply};
use super::motion::limits::limit_alarm;
use super::motion::plan::PlanError;
use crate::event::{Event, Refusal};
use crate::fidelity::Assumption;

impl Device {
    /// Counts the assumptions of a command and returns true if it may be carried out.
    pub(crate) fn allows(&mut self, set: &Set, mode: ExecMode) -> bool {
        handlers::allows(&mut self.lend(), set, mode)
    }

    pub(crate) fn carry_out(&mut self, set: &Set, mode: ExecMode) -> Completion {
        // Before the handler: a value that was set no longer relies on its value of power-up.
        self.store.settings.set_ids.add(set.row().id);
        let effects = handlers::apply(&mut self.lend(), set, mode);
        self.apply_all(set.row(), effects)
    }

    /// Applies the effects of a command in order. Returns what the last one leaves the queue to
    /// wait for.
    fn apply_all(&mut self, row: &'static Row, effects: Effects) -> Completion {
        let mut completion = Completion::Done;
        for effect in effects {
            completion = self.apply(row, effect);
        }
        completion
    }

    fn apply(&mut self, row: &'static Row, effect: Effect) -> Completion {
        match effect {
            Effect::Refuse(reason) => self.record.refuse(row.id, reason),
            Effect::NotSimulated => self.record.not_simulated(row),
            Effect::Raise(code) => self.raise(code),
            Effect::ClearAlarms => self.clear_alarms(),
            Effect::Move(Ok(start)) => {
                // An immediate motion replaces the one under way (model section 14).
                self.halt();
                return self.begin(start);
            }
            Effect::Move(Err(error)) => self.unplannable(row.id, &error),
            Effect::Segment(point, power, mode) => {
                return self.begin_segment(row.id, point, power, mode);
            }
            Effect::Jog(plan) => self.jog(plan),
            Effect::Home => return self.home(),
            Effect::SetReported(joints) => {
                let geometry = self.view().geometry();
                // The reported joints move without the arm, so a limit alarm may lose its cause.
                self.motion.set_reported(self.now, &geometry, joints);
                self.drop_limit_alarms();
            }
            Effect::ToolChanged => {
                // Known lines were computed with the old bias. They are resolved again when the arm
                // stands.
                self.queues.active_mut().forget_path_lines();
                self.replan_segment();
            }
            // A running segment keeps its line; only its speeds change.
            Effect::PathChanged => self.replan_segment(),
            Effect::Turn {
                output,
                rate,
                pulses,
            } => return self.turn(output, rate, pulses),
            Effect::WaitUntil(until) => return Completion::Waiting(until),
            Effect::WaitFor(trigger) => return Completion::Triggered(trigger),
            Effect::StartQueue => self.start_queue(),
            Effect::StopQueue => self.stop_queue(),
            Effect::ForceStop => {
                // The motor of a counted EMotorS stops with its command. Braking comes last: the
                // queue must not start another command meanwhile.
                self.stop_queue();
                self.cut_turning();
                self.brake();
            }
            Effect::ClearQueue => self.clear_queue(),
            Effect::StartDownload { loops, announced } => {
                self.queues.start_download(loops, announced);
            }
            Effect::StopDownload { keep } => self.stop_download(keep),
        }
        Completion::Done
    }

    /// Switches an output of a PTPPO move. A missing pin is refused as by IODO, and the move
    /// continues.
    pub(super) fn switch(&mut self, output: PoCmd) {
        // An address beyond 255 is refused like any other that does not exist.
        let address = u8::try_from(output.address).unwrap_or(u8::MAX);
        let level = Flag(output.level);
        let effects = IoDo { address, level }.apply(&mut self.lend(), ExecMode::Queued);
        let _: Completion = self.apply_all(<IoDo as Writable>::ROW, effects);
    }
}

/// Alarms.
impl Device {
    /// Raises an alarm, unless it is standing already.
    pub(crate) fn raise(&mut self, code: u8) {
        let latched = self.alarms.latched();
        if self.alarms.set(code) {
            self.record.event(Event::AlarmRaised { code });
            // With a bias of 0 a pose within reach of the mounted tool may look out of reach.
            if Alarm::is_kinematic(code) && self.store.settings.motion.tool.is_zero() {
                self.record.event(Event::ToolUnknown { code });
            }
        }
        if !Alarm::blocks(code) {
            self.record.assume(Assumption::QuietAlarms);
        } else if !latched {
            self.record.assume(Assumption::AlarmHold);
        }
        // An alarm that holds the queue ends the path with the running segment.
        self.replan_segment();
    }

    /// Raises the alarm for a motion that cannot be planned, and refuses the command.
    pub(super) fn unplannable(&mut self, id: u8, error: &PlanError) {
        let allowed = error.assumption();
        if allowed.is_none_or(|assumption| self.record.allows(id, assumption)) {
            self.raise(error.alarm());
            self.record.refuse(id, Refusal::Unplannable);
        }
    }

    /// Clears the alarms whose cause is gone. The queue may then continue.
    fn clear_alarms(&mut self) {
        let (motion, limits) = (&self.motion, &self.firmware.model.limits);
        let cleared = (self.alarms).clear(|code| motion.limit_stands(self.now, limits, code));
        for code in cleared.codes() {
            self.record.event(Event::AlarmCleared { code });
        }
        self.replan_segment();
    }

    /// Drops the limit alarms of joints that are back inside. The hold on the queue stays (model
    /// section 4).
    pub(super) fn drop_limit_alarms(&mut self) {
        // Without the latch no limit alarm stands: this runs at each end of a motion and must be
        // cheap.
        if !self.alarms.latched() {
            return;
        }
        let limits = &self.firmware.model.limits;
        for code in Bound::ALL.map(limit_alarm) {
            let stands = || self.motion.limit_stands(self.now, limits, code);
            if self.alarms.standing().contains(code) && !stands() {
                self.alarms.drop_alarm(code);
                self.record.event(Event::AlarmCleared { code });
                self.record.assume(Assumption::LimitDrops);
                self.record.assume(Assumption::LatchedHold);
            }
        }
    }
}
