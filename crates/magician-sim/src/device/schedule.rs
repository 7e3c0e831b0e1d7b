//! Time and scheduling: the next event, and the command that may run then.
//!
//! [`advance`](Device::advance) goes from event to event: the end of a motion, a wait, pulses, or
//! an event of the world. After each one the queue takes as many commands as it may.

use magician_protocol::Set;

use super::Device;
use super::effect::{Completion, ExecMode};
use super::io::steppers::Steppers;
use super::queue::{Activity, Entry, QueuedCommand, Running};
use crate::ArmInstant;
use crate::event::Event;
use crate::fidelity::Assumption;

impl Device {
    /// Advances time to `to`, event by event.
    pub(crate) fn advance(&mut self, to: ArmInstant) {
        while let Some(at) = self.next_event().filter(|at| *at <= to) {
            // An event may be overdue, never early: the clock does not go back.
            self.now = self.now.max(at);
            self.handle_due();
        }
        self.now = self.now.max(to);
    }

    /// Does everything possible at the present instant: due events, and commands of the queue.
    pub(crate) fn run_until_idle(&mut self) {
        self.run_queue();
        self.advance(self.now);
    }

    /// Next instant at which something happens by itself.
    pub(crate) fn next_event(&self) -> Option<ArmInstant> {
        // The world's events count as well: a script acts on an idle arm.
        let events = [self.own_event(), self.world.next_event()];
        events.into_iter().flatten().min()
    }

    /// True if the arm does something that ends by itself, or waits for an input that the scenario
    /// will change.
    pub(crate) fn is_busy(&self) -> bool {
        let awaited = self.awaited_input();
        let waits = awaited.is_some_and(|address| self.world.will_change(address));
        // A jog ends by a command; only its stop ramp ends by itself.
        let jogs = self.motion.is_jogging() && !self.motion.ends_jog();
        !jogs && (waits || self.own_event().is_some())
    }

    /// Next instant at which the arm itself finishes something.
    fn own_event(&self) -> Option<ArmInstant> {
        let waited = match self.queues.active().busy() {
            Some(Activity::Waiting(until)) => Some(until),
            _ => None,
        };
        let motion = self.motion.next_event();
        let ends = [waited, motion, self.io.next_event(self.now)];
        ends.into_iter().flatten().min()
    }

    /// Handles everything due at the present instant.
    ///
    /// The order matters: the motion first, because a wait that ends at the same time may start
    /// another; then the tools, because the world acts on the tool as it is now.
    fn handle_due(&mut self) {
        let now = self.now;
        if self.motion.next_event().is_some_and(|at| at <= now) {
            self.motion_event();
        }
        self.steppers_event();
        self.update_tools();
        while let Some(event) = self.world.poll_external(now) {
            self.apply_external(event);
        }
        if let Some(Activity::Waiting(until)) = self.queues.active().busy()
            && until <= now
        {
            self.finish_running();
        }
        self.run_queue();
        // A path that no queued segment has continued in this instant is over.
        self.finish_path();
        self.record_world_events();
    }

    /// Takes commands from the queue as long as they finish at once.
    fn run_queue(&mut self) {
        // A met TRIG frees the queue, and so may the change between program and hosts' queue.
        self.look_at_input();
        self.change_queue();
        while self.may_take() {
            let Some(entry) = self.queues.active_mut().pop() else {
                return;
            };
            // The popped place makes room for the next line of a stored program.
            self.read_ahead();
            self.start(entry);
            self.change_queue();
        }
    }

    /// True if the queue may take its next command.
    ///
    /// The queue must be started, nothing may run or move, and no alarm may hold it; homing is
    /// exempt (model section 4). A jog counts as finished at its start, so during a jog the queue
    /// continues up to the next command that moves.
    fn may_take(&self) -> bool {
        let queue = self.queues.active();
        let Some(head) = queue.head() else {
            return false;
        };
        let homes = matches!(head, QueuedCommand::Set(Set::HomeCmd(_)));
        let moves_aside = self.motion.is_jogging() && !head.moves();
        self.is_free()
            && queue.running().is_none()
            // An immediate motion delays the queue until it has ended (model section 14, a choice).
            && (!self.motion.is_moving() || moves_aside)
            && (!self.alarms.hold_queue() || homes)
    }

    /// True if the queue is started, the unlock key is not held, and no stored program waits for
    /// its turn.
    fn is_free(&self) -> bool {
        let started = self.queues.active().is_started();
        started && !self.teaching.held() && !self.queues.program_is_due()
    }

    /// True if the queue will take its next command as soon as the running one ends.
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
        // Hosts do not see the indices of a running program, so they are not logged.
        if !self.queues.program_runs() {
            self.record.event(Event::Started { index, id });
            // Faults of a scenario may be tied to the start of a command.
            self.world.index_started(self.now, index);
        }
        let completion = match &command {
            QueuedCommand::Set(set) if self.allows(set, ExecMode::Queued) => {
                self.carry_out(set, ExecMode::Queued)
            }
            QueuedCommand::Set(_) | QueuedCommand::Nothing => Completion::Done,
        };
        self.update_tools();
        // A refused motion counts as finished (model section 15a).
        if command.moves() && completion == Completion::Done && self.alarms.hold_queue() {
            self.record.assume(Assumption::RefusedFinishes);
        }
        let busy = match completion {
            Completion::Done => return self.finished(index, id),
            Completion::Moving => Activity::Moving,
            Completion::Waiting(until) => Activity::Waiting(until),
            Completion::Triggered(trigger) => Activity::Triggered(trigger),
            Completion::Turning(output) => Activity::Turning(output),
        };
        self.queues.active_mut().run(Running { index, id, busy });
    }

    /// EIO address of the input that a running TRIG waits for.
    pub(crate) fn awaited_input(&self) -> Option<u8> {
        match self.queues.active().busy()? {
            Activity::Triggered(trigger) => Some(trigger.address()),
            _ => None,
        }
    }

    /// Finishes a running TRIG if its condition is met.
    fn look_at_input(&mut self) {
        if let Some(Activity::Triggered(trigger)) = self.queues.active().busy()
            && trigger.is_met(&self.io.pins, &self.world, self.now)
        {
            self.finish_running();
        }
    }

    /// Finishes the running command, for whatever reason.
    pub(super) fn finish_running(&mut self) {
        if let Some(Running { index, id, .. }) = self.queues.active_mut().take_running() {
            self.finished(index, id);
        }
    }

    /// Finishes the running command if the ended motion belongs to it.
    pub(super) fn finish_moving(&mut self) {
        if self.queues.active().busy() == Some(Activity::Moving) {
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
    /// Stops the queue and a stored program. The running motion goes to its end; a running wait or
    /// trigger is cut short (model section 14).
    pub(super) fn stop_queue(&mut self) {
        // Before the path is replanned, which looks at whether the queue goes on.
        self.queues.hosts_mut().set_started(false);
        self.stop_program();
        // The segment under way must now end at rest, because the queue takes no further one.
        self.replan_segment();
        self.cut_wait();
    }

    /// Ends a running wait or trigger.
    fn cut_wait(&mut self) {
        if let Some(Activity::Waiting(_) | Activity::Triggered(_)) = self.queues.active().busy() {
            self.finish_running();
        }
    }

    /// Drops the waiting commands of hosts. Numbering and the current index do not change.
    pub(super) fn clear_queue(&mut self) {
        // The running command is not in the list: whether it ends is decided below.
        let count = self.queues.hosts_mut().clear();
        if count > 0 {
            self.record.event(Event::Dropped { count });
        }
        // The running motion belongs to the stored program, not to the hosts' queue.
        if self.queues.program_runs() {
            return;
        }
        self.replan_segment();
        if self.firmware.profile.queue.clear_ends_motion {
            self.drop_motion();
        }
    }

    /// Starts the queue.
    pub(super) fn start_queue(&mut self) {
        self.queues.hosts_mut().set_started(true);
        // Start ends a running motion as well (model section 14), so hosts start a queue only when
        // the arm stands.
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

/// The program stored in the flash.
impl Device {
    /// Starts the stored program, or stops it. Without a program, or while one is being stored,
    /// nothing happens.
    pub(super) fn toggle_program(&mut self) {
        if !self.queues.program_is_off() {
            self.stop_program();
        } else if !self.queues.is_downloading() && self.store.flash().program.line(0).is_some() {
            self.queues.set_program_due();
            self.replan_segment();
        }
    }

    /// Stops the stored program: its motion goes to its end, a wait is cut short.
    pub(super) fn stop_program(&mut self) {
        if self.queues.stop_program() {
            self.replan_segment();
            self.cut_wait();
        }
    }

    /// Moves the downloaded program to the flash, unless it is dropped.
    pub(super) fn stop_download(&mut self, keep: bool) {
        let download = self.queues.take_download();
        if let Some((program, announced)) = download.filter(|_| keep) {
            let stored = u32::try_from(program.lines.len()).unwrap_or(u32::MAX);
            self.store.write_flash(|flash| flash.program = program);
            self.record.event(Event::Downloaded { stored, announced });
        }
    }

    /// Exchanges the hosts' queue and that of the program, once nothing is under way.
    fn change_queue(&mut self) {
        if self.queues.active().running().is_some() || self.motion.is_moving() {
            return;
        }
        if let Some(runs) = self.queues.change() {
            self.record.event(Event::Program { runs });
            // Fill the program's queue at once, so that a path sees its segments from the start.
            while runs && self.read_ahead() {}
        }
    }

    /// Reads the next line of a running program if there is room. Returns true if there was one.
    fn read_ahead(&mut self) -> bool {
        let read = self.queues.read_ahead(&self.store.flash().program);
        if read {
            self.path_grows();
        }
        read
    }

    /// True if a command is skipped because the program has nothing left to do.
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
    /// Runs a stepper output at a rate, for a number of pulses if given.
    ///
    /// A queued command that was counting pulses on this output has finished.
    pub(super) fn turn(&mut self, output: usize, rate: f64, pulses: Option<u32>) -> Completion {
        let Some(turned) = self.io.steppers.turn(self.now, output, rate, pulses) else {
            return Completion::Done;
        };
        if let Some(rate) = turned.rate {
            self.world.stepper(self.now, output, rate);
        }
        // A new rate for the output ends the count that the queue was waiting for.
        if self.queues.active().busy() == Some(Activity::Turning(output)) {
            self.finish_running();
        }
        if turned.counts {
            Completion::Turning(output)
        } else {
            Completion::Done
        }
    }

    /// Stops the outputs whose pulses are counted out.
    fn steppers_event(&mut self) {
        for output in 0..Steppers::COUNT {
            if let Some(counted) = self.io.steppers.due(self.now, output) {
                self.turn(output, 0.0, None);
                self.io.steppers.set_counted(output, counted);
            }
        }
    }

    /// Ends a running command that counts pulses, and its motor with it.
    pub(super) fn cut_turning(&mut self) {
        if let Some(Activity::Turning(output)) = self.queues.active().busy() {
            self.turn(output, 0.0, None);
        }
    }

    /// Stops both outputs.
    pub(super) fn rest_steppers(&mut self) {
        for output in 0..Steppers::COUNT {
            self.turn(output, 0.0, None);
        }
    }
}
