//! Time and turns: what happens next, and what that lets happen.

use magician_protocol::Set;

use super::Device;
use super::effect::{Completion, ExecMode};
use super::io::steppers::Steppers;
use super::queue::{Busy, Entry, QueuedCommand, Running};
use crate::ArmInstant;
use crate::event::Event;
use crate::fidelity::Assumption;

impl Device {
    /// Lets time pass up to `to`, from one event to the next.
    pub(crate) fn advance(&mut self, to: ArmInstant) {
        while let Some(at) = self.next_event().filter(|at| *at <= to) {
            self.now = self.now.max(at);
            self.happen();
        }
        self.now = self.now.max(to);
    }

    /// Does all that can be done at the present instant: what is due, and what the queue may take.
    pub(crate) fn run_until_idle(&mut self) {
        self.run_queue();
        self.advance(self.now);
    }

    /// When something next happens by itself.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        let events = [self.own_event(), self.world.next_event()];
        events.into_iter().flatten().min()
    }

    /// Whether the arm does something that ends by itself, or waits for an input that the scenario
    /// will change.
    pub(crate) fn is_busy(&self) -> bool {
        let awaited = self.awaited_input();
        let waits = awaited.is_some_and(|address| self.world.will_change(address));
        let jogs = self.motion.is_jogging() && !self.motion.ends_jog();
        !jogs && (waits || self.own_event().is_some())
    }

    /// When the arm itself next comes to an end of what it does.
    fn own_event(&self) -> Option<ArmInstant> {
        let waited = match self.queues.active().busy() {
            Some(Busy::Waiting(until)) => Some(until),
            _ => None,
        };
        let motion = self.motion.next_event();
        let ends = [waited, motion, self.io.next_event(self.now)];
        ends.into_iter().flatten().min()
    }

    /// What is due at the present instant. The motion comes first: a wait that ends with it may
    /// begin another. What the world sees of the tool is settled before the world acts.
    fn happen(&mut self) {
        let now = self.now;
        if self.motion.next_event().is_some_and(|at| at <= now) {
            self.motion_event();
        }
        self.steppers_event();
        self.update_tools();
        while let Some(event) = self.world.poll_external(now) {
            self.apply_external(event);
        }
        if let Some(Busy::Waiting(until)) = self.queues.active().busy()
            && until <= now
        {
            self.finish_running();
        }
        self.run_queue();
        self.finish_path();
        self.record_world_events();
    }

    /// Takes commands from the queue as long as it may and they finish on the spot.
    fn run_queue(&mut self) {
        self.look_at_input();
        self.change_queue();
        while self.may_take() {
            let Some(entry) = self.queues.active_mut().pop() else {
                return;
            };
            self.read_ahead();
            self.start(entry);
            self.change_queue();
        }
    }

    /// The queue takes its next command when it is started, nothing runs or moves, and no alarm
    /// holds it; homing is taken all the same (model section 4). During a jog, which is over for
    /// the queue when it begins, it goes on to the next command that moves.
    fn may_take(&self) -> bool {
        let queue = self.queues.active();
        let Some(head) = queue.head() else {
            return false;
        };
        let homes = matches!(head, QueuedCommand::Set(Set::HomeCmd(_)));
        let moves_aside = self.motion.is_jogging() && !head.moves();
        self.is_free()
            && queue.running().is_none()
            && (!self.motion.is_moving() || moves_aside)
            && (!self.alarms.hold_queue() || homes)
    }

    /// Whether the queue may take commands but for alarms: it is started, no hand has unlocked the
    /// motors, and the program in the flash does not wait for its turn.
    fn is_free(&self) -> bool {
        let started = self.queues.active().is_started();
        started && !self.teaching.held() && !self.queues.program_is_due()
    }

    /// Whether the queue takes its next command as soon as nothing is under way.
    pub(super) fn goes_on(&self) -> bool {
        self.is_free() && !self.alarms.hold_queue()
    }

    fn start(&mut self, entry: Entry) {
        let Entry {
            index, id, command, ..
        } = entry;
        if self.skip(index) {
            return;
        }
        if !self.queues.program_runs() {
            self.record.event(Event::Started { index, id });
            self.world.index_started(self.now, index);
        }
        let completion = match &command {
            QueuedCommand::Set(set) if self.allows(set, ExecMode::Queued) => {
                self.carry_out(set, ExecMode::Queued)
            }
            QueuedCommand::Set(_) | QueuedCommand::Nothing => Completion::Done,
        };
        self.update_tools();
        if command.moves() && completion == Completion::Done && self.alarms.hold_queue() {
            self.record.assume(Assumption::RefusedFinishes);
        }
        let busy = match completion {
            Completion::Done => return self.finished(index, id),
            Completion::Moving => Busy::Moving,
            Completion::Waiting(until) => Busy::Waiting(until),
            Completion::Triggered(trigger) => Busy::Triggered(trigger),
            Completion::Turning(output) => Busy::Turning(output),
        };
        self.queues.active_mut().run(Running { index, id, busy });
    }

    /// EIO address of the input that a running trigger waits for.
    pub(crate) fn awaited_input(&self) -> Option<u8> {
        match self.queues.active().busy()? {
            Busy::Triggered(trigger) => Some(trigger.address()),
            _ => None,
        }
    }

    /// Finishes a running trigger that is met.
    fn look_at_input(&mut self) {
        if let Some(Busy::Triggered(trigger)) = self.queues.active().busy()
            && trigger.is_met(&self.io.pins, &self.world, self.now)
        {
            self.finish_running();
        }
    }

    /// The running command has ended, however it did.
    pub(super) fn finish_running(&mut self) {
        if let Some(Running { index, id, .. }) = self.queues.active_mut().take_running() {
            self.finished(index, id);
        }
    }

    /// The running command has ended if the motion was its own.
    pub(super) fn finish_moving(&mut self) {
        if self.queues.active().busy() == Some(Busy::Moving) {
            self.finish_running();
        }
    }

    fn finished(&mut self, index: u64, id: u8) {
        self.queues.active_mut().set_current(index);
        if !self.queues.program_runs() {
            self.record.event(Event::Finished { index, id });
        }
    }
}

/// Stops.
impl Device {
    /// Stops the queue, and the program if it runs: the running motion goes on to its end, a
    /// running wait or trigger is cut short (model section 14).
    pub(super) fn stop_queue(&mut self) {
        self.queues.hosts_mut().set_started(false);
        self.stop_program();
        self.replan_segment();
        self.cut_wait();
    }

    /// Ends a running wait or trigger.
    fn cut_wait(&mut self) {
        if let Some(Busy::Waiting(_) | Busy::Triggered(_)) = self.queues.active().busy() {
            self.finish_running();
        }
    }

    /// Drops what hosts have queued. Numbering goes on and the current index stands.
    pub(super) fn clear_queue(&mut self) {
        let count = self.queues.hosts_mut().clear();
        if count > 0 {
            self.record.event(Event::Dropped { count });
        }
        if self.queues.program_runs() {
            return;
        }
        self.replan_segment();
        if self.firmware.profile.queue.clear_ends_motion {
            self.drop_motion();
        }
    }

    /// Lets the queue run.
    pub(super) fn start_queue(&mut self) {
        self.queues.hosts_mut().set_started(true);
        self.drop_motion();
        self.replan_segment();
    }

    /// Ends the running motion where it is (model section 14).
    fn drop_motion(&mut self) {
        if self.motion.can_be_dropped() {
            self.halt();
        }
    }
}

/// The program in the flash.
impl Device {
    /// The base key starts the program, or stops it.
    pub(super) fn toggle_program(&mut self) {
        if !self.queues.program_is_off() {
            self.stop_program();
        } else if !self.queues.is_downloading() && self.store.flash().program.line(0).is_some() {
            self.queues.set_program_due();
            self.replan_segment();
        }
    }

    /// Ends the program: what moves comes to its end, a wait is cut short.
    pub(super) fn stop_program(&mut self) {
        if self.queues.stop_program() {
            self.replan_segment();
            self.cut_wait();
        }
    }

    /// The program that was stored takes the place of the one in the flash, unless it is dropped.
    pub(super) fn stop_download(&mut self, keep: bool) {
        let download = self.queues.take_download();
        if let Some((program, announced)) = download.filter(|_| keep) {
            let stored = u32::try_from(program.lines.len()).unwrap_or(u32::MAX);
            self.store.write_flash(|flash| flash.program = program);
            self.record.event(Event::Downloaded { stored, announced });
        }
    }

    /// The program takes the place of the hosts' queue or gives it back, when nothing is under way.
    fn change_queue(&mut self) {
        if self.queues.active().running().is_some() || self.motion.is_moving() {
            return;
        }
        if let Some(runs) = self.queues.change() {
            self.record.event(Event::Program { runs });
            while runs && self.read_ahead() {}
        }
    }

    /// Reads a line of the running program if there is room for it; whether there was one.
    fn read_ahead(&mut self) -> bool {
        let read = self.queues.read_ahead(&self.store.flash().program);
        if read {
            self.path_grows();
        }
        read
    }

    /// Whether a command is skipped that comes to its turn: the program has done what it does.
    fn skip(&mut self, index: u64) -> bool {
        let program = &self.store.flash().program;
        let idle = self.queues.ends_idle_pass(program, index, self.now);
        if idle {
            self.stop_program();
        }
        idle
    }
}

/// Stepper outputs.
impl Device {
    /// Turns an output at a rate from now on, for so many pulses if that is given. A command of the
    /// queue that it was busy with has finished.
    pub(super) fn turn(&mut self, output: usize, rate: f64, pulses: Option<u32>) -> Completion {
        let Some(turned) = self.io.steppers.turn(self.now, output, rate, pulses) else {
            return Completion::Done;
        };
        if let Some(rate) = turned.rate {
            self.world.stepper(self.now, output, rate);
        }
        if self.queues.active().busy() == Some(Busy::Turning(output)) {
            self.finish_running();
        }
        if turned.counts {
            Completion::Turning(output)
        } else {
            Completion::Done
        }
    }

    /// Outputs that have put out their pulses come to rest.
    fn steppers_event(&mut self) {
        for output in 0..Steppers::COUNT {
            if let Some(counted) = self.io.steppers.due(self.now, output) {
                self.turn(output, 0.0, None);
                self.io.steppers.set_counted(output, counted);
            }
        }
    }

    /// The queue's running command ends on the spot if it counts pulses, and its motor with it.
    pub(super) fn cut_turning(&mut self) {
        if let Some(Busy::Turning(output)) = self.queues.active().busy() {
            self.turn(output, 0.0, None);
        }
    }

    /// Both outputs come to rest.
    pub(super) fn rest_steppers(&mut self) {
        for output in 0..Steppers::COUNT {
            self.turn(output, 0.0, None);
        }
    }
}
