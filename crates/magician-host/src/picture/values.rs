//! Settings and outputs, derived from the commands sent and the arm's replies.

use magician_protocol::commands::{
    Pose, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStartDownload, QueuedCmdStopExec,
};
use magician_protocol::{
    Ctrl, Effect, Frame, FrameBuf, NoArgs, QueuedCmdIndex, Readable, Row, Set, Writable,
};

use super::ArmPicture;
use super::laser::{Channels, LaserEffect, LaserPicture};
use super::pending::{Pending, PendingQueue};
use super::settings::{SettingValues, as_value, changes, reaches};
use super::tools::{ArmOutputs, ToolPicture};
use crate::RestDetector;
use crate::burning::frame_releases_queue;
use crate::connection::{Failure, Micros};

/// Settings and outputs; see [`ArmPicture`](super::ArmPicture).
#[derive(Clone, Debug, Default)]
pub(super) struct Values {
    pub(super) settings: SettingValues,
    tools: ToolPicture,
    laser: LaserPicture,
    /// Unfinished queued commands that change a setting or an output.
    pending: PendingQueue,
    queue: QueueHold,
    /// Poses read since the last frame sent that was not a read.
    rest: RestDetector,
    /// Number of times that a known value became unknown.
    pub(super) lapses: u64,
}

/// State of the queue, as far as stops over this connection show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum QueueHold {
    /// The queue runs, or may run.
    #[default]
    Open,
    /// StopExec was answered; the running command continues to its end.
    Stopping,
    /// Stopped, and no command is running.
    Held,
}

impl Values {
    /// Processes a sent request: settings that it may change become unknown.
    pub(super) fn sent(&mut self, request: &Frame<'_>) {
        let ctrl = request.ctrl();
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        if frame_releases_queue(request) {
            self.queue = QueueHold::Open;
            self.pending.release();
        }
        // Anything but a read may move the arm, so earlier poses prove no rest.
        self.rest.forget();
        if ctrl.queued() {
            // With new commands the index no longer shows what ran before a Clear.
            while let Some(one) = self.pending.pop_cleared() {
                self.finish(0, &one);
            }
        }
        // An unknown id may change anything.
        let Some(row) = Row::with_id(request.id()) else {
            return self.forget();
        };
        match row.effect {
            // A program stored in the arm may change anything.
            Effect::Queue if row.id == QueuedCmdStartDownload::ROW.id => self.forget(),
            Effect::Store => self.forget(),
            _ if changes(row) => {
                self.settings.drop_changed(row);
                if ctrl.queued() {
                    if let Some(oldest) = self.pending.sent(row, request) {
                        self.finish(0, &oldest);
                    }
                } else if let Some(effect) = LaserEffect::of(request) {
                    self.laser.sent(effect);
                }
            }
            _ => {}
        }
    }

    /// Processes the reply to a request at `now`, us.
    pub(super) fn answered(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        let Some(row) = Row::with_id(request.id()) else {
            return;
        };
        let ctrl = request.ctrl();
        if ctrl.queued() {
            if let (true, Ok(QueuedCmdIndex(index))) = (changes(row), reply.read()) {
                self.pending.accepted(index, row, request);
            }
        } else if row.id == QueuedCmdClear::ROW.id {
            self.pending.cleared();
        } else if row.id == QueuedCmdForceStopExec::ROW.id {
            self.queue = QueueHold::Held;
        } else if row.id == QueuedCmdStopExec::ROW.id {
            if self.queue == QueueHold::Open {
                self.queue = QueueHold::Stopping;
            }
        } else if changes(row) {
            self.pending.overtaken(row);
            if let Some(value) = as_value(row, request) {
                self.keep(now, row, &[], value.frame().params());
            }
            if let Some(effect) = LaserEffect::of(request) {
                self.laser.set(effect);
                let put_out = effect.channels.intersects(Channels::BEAM) && !effect.burns;
                // While the queue is held, only a new command can light the laser again.
                if put_out && self.queue == QueueHold::Held {
                    self.pending.rest();
                }
            }
            self.tools.set(row, request);
        }
    }

    /// Notes that the arm accepted a command with this index.
    pub(super) fn accepted(&mut self, index: u64, command: &Set) {
        let row = command.row();
        if changes(row)
            && let Ok(frame) = FrameBuf::set(command, Ctrl::QUEUED)
        {
            self.pending.accepted(index, row, &frame.frame());
        }
    }

    /// Notes that a request failed.
    pub(super) fn failed(&mut self, request: &Frame<'_>, failure: &Failure) {
        let ctrl = request.ctrl();
        let row = Row::with_id(request.id()).filter(|row| changes(row));
        let Some(row) = row.filter(|_| ctrl.write() || ctrl.queued()) else {
            return;
        };
        if ctrl.queued() {
            // Uncertain: the command may be in the queue.
            if !matches!(failure, Failure::Uncertain { .. } | Failure::NoIndex) {
                self.pending.withdraw(request);
            }
            return;
        }
        let done = match failure {
            Failure::Timeout { sent } => *sent > 0,
            Failure::Uncertain { .. } | Failure::NoIndex | Failure::Lost => true,
            Failure::QueueFull
            | Failure::Refused
            | Failure::Stopped
            | Failure::Draining
            | Failure::Busy => false,
        };
        if done {
            // The laser may have been lit by this command after it was switched off.
            if let Some(effect) = LaserEffect::of(request) {
                self.laser.sent(effect);
            }
            self.doubt(row);
        }
    }

    /// Discards all values, because the line was lost or another program has used the arm. Commands
    /// in the queue may still run, and a laser lit over this connection counts as lit.
    pub(super) fn forget(&mut self) {
        self.settings.clear();
        self.tools.forget();
        self.laser.forget();
        self.pending.doubt();
        // Displays read the outputs again when this count changes.
        self.lapses += 1;
    }

    /// Notes that the arm was reset: nothing is known, and its queue is empty.
    pub(super) fn reset(&mut self) {
        let mut laser = std::mem::take(&mut self.laser);
        laser.reset();
        *self = Self {
            laser,
            lapses: self.lapses + 1,
            ..Self::default()
        };
    }

    /// Notes that the laser was switched off and its pins are low.
    pub(super) fn darkened(&mut self) {
        if self.queue == QueueHold::Held {
            self.pending.rest();
        }
        self.laser.darkened();
    }

    /// Notes that laser off, StopExec and Clear were answered on a restored line.
    pub(super) fn cleared(&mut self) {
        self.pending.cleared();
        self.pending.rest();
        self.darkened();
    }

    /// Processes the reply to a get.
    pub(super) fn read(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        let row = Row::with_id(request.id());
        let Some(row) = row.filter(|row| matches!(row.effect, Effect::Setting | Effect::Laser))
        else {
            return;
        };
        self.keep(now, row, request.params(), reply.params());
        self.tools.read(reply);
        self.laser.read(reply);
    }

    pub(super) fn read_pose(&mut self, now: Micros, pose: Pose) {
        // The arm is at rest, so the command that StopExec let finish has ended.
        if self.rest.see(now, pose) {
            if self.queue == QueueHold::Stopping {
                self.queue = QueueHold::Held;
            }
            self.pending.stands();
        }
    }

    /// Notes that the arm has finished the commands of its queue up to this index.
    pub(super) fn finished(&mut self, now: Micros, current: u64) {
        while let Some(one) = self.pending.pop_finished(current) {
            self.finish(now, &one);
        }
        for row in self.pending.settle_clear() {
            self.doubt(row);
        }
    }

    fn finish(&mut self, now: Micros, one: &Pending) {
        let request = one.request.frame();
        self.settings.drop_changed(one.row);
        // A command that may not have run does not switch the laser off.
        let effect = one.light_at_its_end();
        if let Some(effect) = effect.filter(|effect| effect.burns || one.certain) {
            self.laser.set(effect);
        }
        if !one.certain {
            return self.doubt(one.row);
        }
        if let Some(value) = as_value(one.row, &request)
            && !one.cleared
        {
            self.keep(now, one.row, &[], value.frame().params());
        }
        self.tools.set(one.row, &request);
    }

    fn may_be_lit(&self, channels: Channels) -> bool {
        self.laser.may_be_lit(channels) || self.pending.may_light(channels)
    }

    fn doubt(&mut self, row: &Row) {
        self.lapses += u64::from(self.tools.doubt(row));
    }

    fn keep(&mut self, at: Micros, row: &'static Row, query: &[u8], params: &[u8]) {
        // A waiting command will change the value at an unknown moment, so do not keep it.
        if !(self.pending).any(|one| !one.cleared && reaches(one.row, row)) {
            self.settings.keep(at, row, query, params);
        }
    }
}

/// Settings and outputs.
impl ArmPicture {
    /// Value that is known and was valid at `since` (us) or later. `None` otherwise.
    #[must_use]
    pub fn get<T: Readable<Query = NoArgs>>(&self, since: Micros) -> Option<T> {
        self.values.settings.get_with(&NoArgs, since)
    }

    /// Tool, laser, suction cup, gripper and speed.
    #[must_use]
    pub fn outputs(&self) -> ArmOutputs {
        let Values { laser, pending, .. } = &self.values;
        let of_interest = if self.laser_pins {
            Channels::ALL
        } else {
            Channels::BEAM | Channels::PATH
        };
        let waiting = pending.may_light(of_interest);
        let laser = laser.state(waiting, self.laser_pins);
        self.values.tools.outputs(laser)
    }

    /// True if commands of this connection may have lit the laser, by its pins or otherwise.
    #[must_use]
    pub fn may_be_lit(&self) -> bool {
        self.values.may_be_lit(Channels::ALL)
    }

    /// True if commands of this connection may have raised one of the laser's pins.
    #[must_use]
    pub fn pins_may_be_high(&self) -> bool {
        self.values.may_be_lit(Channels::PINS)
    }

    /// True if the levels of the laser's pins are known.
    #[must_use]
    pub const fn knows_laser_pins(&self) -> bool {
        self.values.laser.knows_pins()
    }

    /// Notes a reading of the laser's pins. `None` if the arm does not report them.
    pub fn note_laser_pins(&mut self, high: Option<bool>) {
        self.values.laser.note_pins(high);
    }

    /// Notes whether commands of other programs wait in the queue. They may light the laser and
    /// cannot be read.
    pub fn note_foreign_commands(&mut self, foreign: bool) {
        self.values.laser.note_foreign(foreign);
    }
}
