//! Time and turns: what happens next, and what that lets happen.

use crate::Micros;
use crate::device::Device;
use crate::device::dispatch::{Step, Turn};
use crate::device::queue::program::Run;
use crate::device::queue::{Busy, Entry, Order, Running};
use crate::event::Event;
use crate::fidelity::Assumption;
use magician_protocol::{AlarmSet, Set};

impl Device {
    /// Lets time pass up to `to`, from one event to the next.
    pub(crate) fn advance(&mut self, to: Micros) {
        while let Some(at) = self.next_event().filter(|at| *at <= to) {
            self.now = self.now.max(at);
            self.happen();
        }
        self.now = self.now.max(to);
    }

    /// Does all that can be done at the present instant: what is due, and what the queue may take.
    pub(crate) fn settle(&mut self) {
        self.run_queue();
        self.advance(self.now);
    }

    /// When something next happens by itself.
    pub(crate) fn next_event(&self) -> Option<Micros> {
        let events = [self.own_event(), self.world.next_event()];
        events.into_iter().flatten().min()
    }

    /// Whether the arm does something that ends by itself, or waits for an input that the scenario will change.
    pub(crate) fn is_busy(&self) -> bool {
        let waits = match self.queue.running.map(|running| running.busy) {
            Some(Busy::Triggered(trigger)) => self.world.will_change(trigger.address),
            _ => false,
        };
        let jogs = self.motion.is_jogging() && !self.motion.ends_jog();
        !jogs && (waits || self.own_event().is_some())
    }

    /// When the arm itself next comes to an end of what it does.
    fn own_event(&self) -> Option<Micros> {
        let waited = match self.queue.running.map(|running| running.busy) {
            Some(Busy::Waiting(until)) => Some(until),
            _ => None,
        };
        [
            waited,
            self.motion.next_event(),
            self.actuators.next_change(self.now),
            self.steppers.next_event(),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// What is due at the present instant. The motion comes first: a wait that ends with it may begin another. What
    /// the world sees of the tool is settled before the world acts.
    fn happen(&mut self) {
        let now = self.now;
        if self.motion.next_event().is_some_and(|at| at <= now) {
            self.motion_event();
        }
        self.steppers_event();
        self.feel_grip();
        while let Some(happening) = self.world.happen(now) {
            self.meet(happening);
        }
        if let Some(Busy::Waiting(until)) = self.queue.running.map(|running| running.busy)
            && until <= now
        {
            self.finish_running();
        }
        self.run_queue();
        self.come_to_rest();
        self.tell_incidents();
    }

    /// Takes commands from the queue as long as it may and they finish on the spot.
    fn run_queue(&mut self) {
        self.look_at_input();
        self.change_queue();
        while self.may_take() {
            let Some(entry) = self.queue.pop() else {
                return;
            };
            self.read_ahead();
            self.start(entry);
            self.change_queue();
        }
    }

    /// The queue takes its next command when it is started, nothing runs or moves, and no alarm holds it; homing is
    /// taken all the same (model section 4). During a jog, which is over for the queue when it begins, it goes on to
    /// the next command that moves.
    fn may_take(&self) -> bool {
        let Some(head) = self.queue.head() else {
            return false;
        };
        let homes = matches!(head, Order::Set(Set::HomeCmd(_)));
        let moves_aside = self.motion.is_jogging() && !head.moves();
        self.is_free()
            && self.queue.running.is_none()
            && (!self.motion.is_moving() || moves_aside)
            && (!self.is_held() || homes)
    }

    /// Whether the queue may take commands but for alarms: it is started, no hand has unlocked the motors, and the
    /// program in the flash does not wait for its turn.
    fn is_free(&self) -> bool {
        self.queue.started && !self.teaching.held() && !matches!(self.run, Run::Due)
    }

    /// Whether the queue takes its next command as soon as nothing is under way.
    pub(crate) fn goes_on(&self) -> bool {
        self.is_free() && !self.is_held()
    }

    /// Whether an alarm holds the queue.
    pub(crate) fn is_held(&self) -> bool {
        self.alarms.held() && self.profile.queue.alarms_hold
    }

    fn start(&mut self, entry: Entry) {
        let Entry {
            index, id, order, ..
        } = entry;
        if self.pass_over(index) {
            return;
        }
        if !self.runs_program() {
            self.log.push(Event::Started { index, id });
            self.world.index_started(self.now, index);
        }
        let step = match &order {
            Order::Set(set) if self.allows_apply(set, Turn::Queued) => {
                self.carry_out(set, Turn::Queued)
            }
            Order::Set(_) | Order::Nothing => Step::Done,
        };
        self.feel_grip();
        if order.moves() && step == Step::Done && self.is_held() {
            self.assume(Assumption::RefusedFinishes);
        }
        let busy = match step {
            Step::Done => return self.finished(index, id),
            Step::Moving => Busy::Moving,
            Step::Waiting(until) => Busy::Waiting(until),
            Step::Triggered(trigger) => Busy::Triggered(trigger),
            Step::Turning(output) => Busy::Turning(output),
        };
        self.queue.running = Some(Running { index, id, busy });
    }

    /// EIO address of the input that a running trigger waits for.
    pub(crate) fn awaited_input(&self) -> Option<u8> {
        match self.queue.running?.busy {
            Busy::Triggered(trigger) => Some(trigger.address),
            _ => None,
        }
    }

    /// Finishes a running trigger that is met.
    fn look_at_input(&mut self) {
        if let Some(Busy::Triggered(trigger)) = self.queue.running.map(|running| running.busy)
            && self.is_met(&trigger)
        {
            self.finish_running();
        }
    }

    /// The running command has ended, however it did.
    pub(crate) fn finish_running(&mut self) {
        if let Some(Running { index, id, .. }) = self.queue.running.take() {
            self.finished(index, id);
        }
    }

    /// A motion has ended before its target: its command counts as finished all the same.
    pub(crate) fn finishes_refused(&mut self) {
        if let Some(Busy::Moving) = self.queue.running.map(|running| running.busy) {
            self.assume(Assumption::RefusedFinishes);
        }
    }

    /// The running command has ended if the motion was its own.
    pub(crate) fn finish_moving(&mut self) {
        if let Some(Busy::Moving) = self.queue.running.map(|running| running.busy) {
            self.finish_running();
        }
    }

    fn finished(&mut self, index: u64, id: u8) {
        self.queue.current = index;
        if !self.runs_program() {
            self.log.push(Event::Finished { index, id });
        }
    }
}

impl Device {
    /// Stops the queue, and the program if it runs: the running motion goes on to its end, a running wait or trigger is
    /// cut short (model section 14).
    pub(crate) fn stop(&mut self) {
        self.hosts_mut().started = false;
        self.stop_program();
        self.replan_segment();
        self.cut_wait();
    }

    /// Ends a running wait or trigger.
    pub(crate) fn cut_wait(&mut self) {
        let busy = self.queue.running.map(|running| running.busy);
        if let Some(Busy::Waiting(_) | Busy::Triggered(_)) = busy {
            self.finish_running();
        }
    }

    /// Stops the queue and brakes whatever moves.
    pub(crate) fn force_stop(&mut self) {
        self.stop();
        self.cut_turning();
        self.brake();
    }

    /// Drops what hosts have queued. Numbering goes on and the current index stands.
    pub(crate) fn clear_queue(&mut self) {
        let count = self.hosts_mut().clear();
        if count > 0 {
            self.log.push(Event::Dropped { count });
        }
        if self.runs_program() {
            return;
        }
        self.replan_segment();
        let moving = self
            .queue
            .running
            .is_some_and(|running| running.busy == Busy::Moving);
        if moving && self.profile.queue.clear_ends_motion {
            self.halt();
        }
    }

    /// Clears the alarms whose cause is gone, which may let the queue go on.
    pub(crate) fn clear_alarms(&mut self) {
        let before = self.alarms.standing();
        let standing: AlarmSet = (before.codes())
            .filter(|code| self.limit_stands(*code))
            .collect();
        self.alarms.clear(|code| standing.contains(code));
        let after = self.alarms.standing();
        for code in before.codes().filter(|code| !after.contains(*code)) {
            self.log.push(Event::AlarmCleared { code });
        }
        self.replan_segment();
    }
}
