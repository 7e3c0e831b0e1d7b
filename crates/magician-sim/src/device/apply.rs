//! Where the effects of commands are applied to the parts, each in its one place.

use magician_motion::Bound;
use magician_protocol::commands::IoDo;
use magician_protocol::{Alarm, Flag, PoCmd, Row, Set, Writable};

use super::Device;
use super::effect::{Completion, Effect, Effects, ExecMode};
use super::handlers::{self, Apply};
use super::motion::limits::limit_alarm;
use super::motion::plan::NoPlan;
use crate::event::{Event, Refusal};
use crate::fidelity::Assumption;

impl Device {
    /// Counts what a command rests on; whether it is carried out.
    pub(crate) fn allows(&mut self, set: &Set, mode: ExecMode) -> bool {
        handlers::allows(&mut self.lend(), set, mode)
    }

    pub(crate) fn carry_out(&mut self, set: &Set, mode: ExecMode) -> Completion {
        self.store.settings.told.add(set.row().id);
        let effects = handlers::apply(&mut self.lend(), set, mode);
        self.apply_all(set.row(), effects)
    }

    /// Applies the effects of a command of a row, one after the other; what the last leaves for the
    /// queue to wait for.
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
                self.motion.set_reported(self.now, &geometry, joints);
                self.drop_limit_alarms();
            }
            Effect::ToolChanged => {
                // Where the path leads will be found out when the arm stands.
                self.queues.active_mut().forget_ways();
                self.replan_segment();
            }
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

    /// Switches an output that a move has come to. A pin that there is not is refused like the
    /// command that it stands for; the move goes on.
    pub(super) fn switch(&mut self, output: PoCmd) {
        let address = u8::try_from(output.address).unwrap_or(u8::MAX);
        let level = Flag(output.level);
        let effects = IoDo { address, level }.apply(&mut self.lend(), ExecMode::Queued);
        let _: Completion = self.apply_all(<IoDo as Writable>::ROW, effects);
    }
}

/// Alarms.
impl Device {
    /// Raises an alarm.
    pub(crate) fn raise(&mut self, code: u8) {
        let latched = self.alarms.latched();
        if self.alarms.set(code) {
            self.record.event(Event::AlarmRaised { code });
            if Alarm::is_kinematic(code) && self.store.settings.motion.tool.is_zero() {
                self.record.event(Event::ToolUnknown { code });
            }
        }
        if !Alarm::blocks(code) {
            self.record.assume(Assumption::QuietAlarms);
        } else if !latched {
            self.record.assume(Assumption::AlarmHold);
        }
        self.replan_segment();
    }

    /// A motion that cannot be planned: an alarm says why.
    pub(super) fn unplannable(&mut self, id: u8, error: &NoPlan) {
        let allowed = error.assumption();
        if allowed.is_none_or(|assumption| self.record.allows(id, assumption)) {
            self.raise(error.alarm());
            self.record.refuse(id, Refusal::Unplannable);
        }
    }

    /// Clears the alarms whose cause is gone, which may let the queue go on.
    fn clear_alarms(&mut self) {
        let (motion, limits) = (&self.motion, &self.firmware.model.limits);
        let cleared = (self.alarms).clear(|code| motion.limit_stands(self.now, limits, code));
        for code in cleared.codes() {
            self.record.event(Event::AlarmCleared { code });
        }
        self.replan_segment();
    }

    /// Drops the limit alarms of joints that are inside again; the hold on the queue stays (model
    /// section 4).
    pub(super) fn drop_limit_alarms(&mut self) {
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
