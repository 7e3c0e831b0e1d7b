//! The picture of an arm: settings, tools, laser and speed, known without asking it.

mod laser;
#[cfg(test)]
mod law;
mod pending;
mod settings;
mod tools;

use magician_protocol::commands::{
    Pose, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdForceStopExec, QueuedCmdStartDownload,
    QueuedCmdStopExec,
};
use magician_protocol::{
    Ctrl, Effect, Frame, FrameBuf, NoArgs, QueuedCmdIndex, Readable, Row, Set, Writable,
};

use self::laser::{Channels, LaserPicture, Light};
use self::pending::{Pending, PendingQueue};
use self::settings::{SettingValues, as_value, changes, reaches};
use self::tools::ToolPicture;
pub use self::tools::{ArmOutputs, GripperState};
use crate::RestDetector;
use crate::burning::frame_releases_queue;
use crate::connection::{Failure, Micros};

/// An arm as far as it is known from what was sent over one connection, and from what the arm has answered.
///
/// It has two kinds of values:
///
/// * Settings ([`get`](Self::get)): a check that needs them need not read them again. A value is forgotten before anything
///   is sent that may change it, and known again when the arm has answered. A queued command counts when the arm has
///   finished it; until then nothing that was read in between is kept. At most 48 values are kept.
/// * Outputs ([`outputs`](Self::outputs)): tool, laser, suction cup, gripper and speed, to be shown. They stay as they were
///   until the arm has answered a command, or has finished a queued one by its current index. The laser errs towards
///   burning: it counts as lit as soon as a command that may burn goes out, and until a command that puts it out was
///   answered, or has finished in the queue. When `SetEndEffectorLaser` off was answered while the queue is held, what waits
///   in it does not count before the queue is started again.
///
/// Resets, lost lines and commands of other programs are not seen here: the caller reports them ([`forget`](Self::forget),
/// [`reset`](Self::reset)).
///
/// ```
/// use magician_host::protocol::{EncodeError, Readable};
/// use magician_host::{ArmPicture, Ctrl, FrameBuf, commands::PtpCommonParams, build};
///
/// let mut picture = ArmPicture::default();
/// let request = FrameBuf::set(&build::speed(80.0, 60.0), Ctrl::SET)?;
/// let reply = FrameBuf::new(PtpCommonParams::ROW.id, Ctrl::SET, &[])?;
/// picture.sent(&request.frame());
/// assert_eq!(picture.get::<PtpCommonParams>(0), None);
/// picture.answered(5_000, &request.frame(), &reply.frame());
/// let known: PtpCommonParams = picture.get(0).unwrap();
/// assert_eq!(known.velocity_ratio, 80.0);
/// assert_eq!(picture.outputs(true).speed, Some(80.0));
/// # Ok::<(), EncodeError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ArmPicture {
    settings: SettingValues,
    tools: ToolPicture,
    laser: LaserPicture,
    /// Queued commands that change one of these and have not finished.
    pending: PendingQueue,
    queue: QueueHold,
    /// Poses since anything but a read was sent.
    rest: RestDetector,
    /// Number of times that a known value became unknown.
    lapses: u64,
}

/// State of the queue, as far as stops over this connection tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum QueueHold {
    /// The queue runs, or may run.
    #[default]
    Open,
    /// StopExec was answered; the command under way goes on to its end.
    Stopping,
    /// Stopped, and no command is under way.
    Held,
}

/// Hear.
impl ArmPicture {
    /// A request goes out: the settings that it may change are not known any more.
    pub fn sent(&mut self, request: &Frame<'_>) {
        let ctrl = request.ctrl();
        if !ctrl.write() && !ctrl.queued() {
            return;
        }
        if frame_releases_queue(request) {
            self.queue = QueueHold::Open;
            self.pending.release();
        }
        self.rest.forget();
        if ctrl.queued() {
            // From here on the index does not tell what was done before a Clear.
            while let Some(one) = self.pending.pop_cleared() {
                self.finish(0, &one);
            }
        }
        let Some(row) = Row::with_id(request.id()) else {
            return self.forget();
        };
        match row.effect {
            // A program that the arm keeps sets what it likes.
            Effect::Queue if row.id == QueuedCmdStartDownload::ROW.id => self.forget(),
            Effect::Store => self.forget(),
            _ if changes(row) => {
                self.settings.drop_changed(row);
                if ctrl.queued() {
                    if let Some(oldest) = self.pending.sent(row, request) {
                        self.finish(0, &oldest);
                    }
                } else if let Some(light) = Light::of(request) {
                    self.laser.sent(light);
                }
            }
            _ => {}
        }
    }

    /// A request was answered at `now`, us.
    pub fn answered(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        let Some(row) = Row::with_id(request.id()) else {
            return;
        };
        let ctrl = request.ctrl();
        if ctrl.queued() {
            if let (true, Ok(QueuedCmdIndex(index))) = (changes(row), reply.read()) {
                self.pending.accepted(index, row, request);
            }
        } else if !ctrl.write() {
            self.read(now, row, request, reply);
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
            if let Some(light) = Light::of(request) {
                self.laser.set(light);
                let put_out = light.channels.meet(Channels::BEAM) && !light.burns;
                if put_out && self.queue == QueueHold::Held {
                    self.pending.rest();
                }
            }
            self.tools.set(row, request);
        }
    }

    /// The arm has taken a command into its queue under this index.
    pub fn accepted(&mut self, index: u64, command: &Set) {
        let row = command.row();
        if changes(row)
            && let Ok(frame) = FrameBuf::set(command, Ctrl::QUEUED)
        {
            self.pending.accepted(index, row, &frame.frame());
        }
    }

    /// A request was not answered.
    pub fn failed(&mut self, request: &Frame<'_>, failure: &Failure) {
        let ctrl = request.ctrl();
        let row = Row::with_id(request.id()).filter(|row| changes(row));
        let Some(row) = row.filter(|_| ctrl.write() || ctrl.queued()) else {
            return;
        };
        if ctrl.queued() {
            // Uncertain: it may be in the queue.
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
            // A laser that was switched off meanwhile may have been lit by this after it.
            if let Some(light) = Light::of(request) {
                self.laser.sent(light);
            }
            self.doubt(row);
        }
    }

    /// Forgets all values: the line was lost, or another program has used the arm. Commands in the queue may still be done,
    /// and a laser that was lit over this connection counts as lit.
    pub fn forget(&mut self) {
        self.settings.clear();
        self.tools.forget();
        self.laser.forget();
        self.pending.doubt();
        self.lapses += 1;
    }

    /// The arm was reset: nothing is known, and nothing waits.
    pub fn reset(&mut self) {
        let mut laser = std::mem::take(&mut self.laser);
        laser.reset();
        *self = Self {
            laser,
            lapses: self.lapses + 1,
            ..Self::default()
        };
    }

    /// The laser was switched off, and its pins are low.
    pub fn darkened(&mut self) {
        if self.queue == QueueHold::Held {
            self.pending.rest();
        }
        self.laser.darkened();
    }

    /// Laser off, StopExec and Clear were answered on a line that was found again.
    pub fn cleared(&mut self) {
        self.pending.cleared();
        self.pending.rest();
        self.darkened();
    }

    /// The laser's pins were read; `None` where the arm does not say.
    pub fn note_laser_pins(&mut self, high: Option<bool>) {
        self.laser.note_pins(high);
    }

    /// Notes whether commands of other programs wait in the queue, which may light the laser and cannot be read.
    pub fn note_foreign_commands(&mut self, foreign: bool) {
        self.laser.note_foreign(foreign);
    }

    fn read(&mut self, now: Micros, row: &'static Row, request: &Frame<'_>, reply: &Frame<'_>) {
        if row.id == <QueuedCmdCurrentIndex as Readable>::ROW.id {
            if let Ok(read) = reply.read::<QueuedCmdCurrentIndex>() {
                self.finished(now, read.queued_cmd_current_index);
            }
        } else if row.id == <Pose as Readable>::ROW.id {
            if let Ok(pose) = reply.read::<Pose>() {
                self.see(now, pose);
            }
        } else if matches!(row.effect, Effect::Setting | Effect::Laser) {
            self.keep(now, row, request.params(), reply.params());
            self.tools.read(reply);
            self.laser.read(reply);
        }
    }

    /// The arm is there.
    fn see(&mut self, now: Micros, pose: Pose) {
        if self.rest.see(now, pose) {
            if self.queue == QueueHold::Stopping {
                self.queue = QueueHold::Held;
            }
            self.pending.stands();
        }
    }

    /// The arm has finished the commands of its queue up to this index.
    fn finished(&mut self, now: Micros, current: u64) {
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
        // What may not have been done puts no laser out.
        let light = one.light_at_its_end();
        if let Some(light) = light.filter(|light| light.burns || one.certain) {
            self.laser.set(light);
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

    fn doubt(&mut self, row: &Row) {
        self.lapses += u64::from(self.tools.doubt(row));
    }

    fn keep(&mut self, at: Micros, row: &'static Row, query: &[u8], params: &[u8]) {
        if !(self.pending).any(|one| !one.cleared && reaches(one.row, row)) {
            self.settings.keep(at, row, query, params);
        }
    }
}

/// Look.
impl ArmPicture {
    /// A value, if it is known and was so at `since` (us) or later.
    #[must_use]
    pub fn get<T: Readable<Query = NoArgs>>(&self, since: Micros) -> Option<T> {
        self.get_with(&NoArgs, since)
    }

    /// As [`get`](Self::get), of a value that depends on something.
    #[must_use]
    pub fn get_with<T: Readable>(&self, query: &T::Query, since: Micros) -> Option<T> {
        self.settings.get_with(query, since)
    }

    /// Tool, laser, suction cup, gripper and speed. `laser_pins`: a laser may be wired to EIO 2 and 4.
    #[must_use]
    pub fn outputs(&self, laser_pins: bool) -> ArmOutputs {
        let of_interest = if laser_pins {
            Channels::ALL
        } else {
            Channels::BEAM | Channels::PATH
        };
        let waiting = self.pending.may_light(of_interest);
        self.tools.outputs(self.laser.told(waiting, laser_pins))
    }

    /// True if commands of this connection may have lit the laser, by its pins or otherwise.
    #[must_use]
    pub fn may_be_lit(&self) -> bool {
        self.laser.may_be_lit(Channels::ALL) || self.pending.may_light(Channels::ALL)
    }

    /// True if commands of this connection may have raised one of the laser's pins.
    #[must_use]
    pub fn pins_may_be_high(&self) -> bool {
        self.laser.may_be_lit(Channels::PINS) || self.pending.may_light(Channels::PINS)
    }

    /// True if the levels of the laser's pins are known.
    #[must_use]
    pub const fn knows_laser_pins(&self) -> bool {
        self.laser.knows_pins()
    }

    /// Number of times that a known value became unknown, so that it has to be read again.
    #[must_use]
    pub const fn lapses(&self) -> u64 {
        self.lapses
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::Flag;
    use magician_protocol::commands::{
        EndEffectorLaser, IoMultiplexing, PtpCommonParams, PtpJump2Params, PtpJumpParams,
        QueuedCmdStartExec,
    };

    use super::*;
    use crate::build;

    const JUMP: PtpJumpParams = PtpJumpParams {
        jump_height: 20.0,
        z_limit: 100.0,
    };

    #[derive(Default)]
    struct Rig(ArmPicture);

    impl Rig {
        fn answer(&mut self, request: FrameBuf, params: &[u8]) {
            let request = request.frame();
            let reply = FrameBuf::new(request.id(), request.ctrl(), params).unwrap();
            self.0.sent(&request);
            self.0.answered(7, &request, &reply.frame());
        }

        fn sets(&mut self, command: impl Into<Set>) {
            let request = FrameBuf::set(&command.into(), Ctrl::SET).unwrap();
            self.answer(request, &[]);
        }

        fn queues(&mut self, index: u64, command: impl Into<Set>) {
            let request = FrameBuf::set(&command.into(), Ctrl::QUEUED).unwrap();
            self.answer(request, &index.to_le_bytes());
        }

        fn reads<T: Readable<Query = NoArgs>>(&mut self, value: &T) {
            let value = FrameBuf::encode(T::ROW.id, Ctrl::GET, value).unwrap();
            let request = FrameBuf::get(&NoArgs, T::ROW).unwrap();
            self.answer(request, value.frame().params());
        }

        fn finishes(&mut self, current: u64) {
            self.reads(&QueuedCmdCurrentIndex {
                queued_cmd_current_index: current,
            });
        }

        fn ratio(&self) -> Option<f32> {
            let known = self.0.get::<PtpCommonParams>(0);
            known.map(|known| known.velocity_ratio)
        }
    }

    fn ratio(velocity_ratio: f32) -> PtpCommonParams {
        PtpCommonParams {
            velocity_ratio,
            acceleration_ratio: 50.0,
        }
    }

    #[test]
    fn what_was_read_or_set_is_known_until_it_may_change() {
        let mut rig = Rig::default();
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), Some(40.0));
        let request = FrameBuf::set(&ratio(60.0).into(), Ctrl::SET).unwrap();
        rig.0.sent(&request.frame());
        assert_eq!(rig.ratio(), None, "it is unknown whether the arm took it");
        rig.sets(ratio(60.0));
        assert_eq!(rig.ratio(), Some(60.0));
        assert!(rig.0.get::<PtpCommonParams>(8).is_none(), "it is too old");
        rig.0.forget();
        assert_eq!(rig.ratio(), None);
    }

    #[test]
    fn what_is_queued_counts_when_it_is_done() {
        let mut rig = Rig::default();
        rig.sets(ratio(40.0));
        rig.queues(5, ratio(70.0));
        rig.finishes(4);
        // Between them the arm may change it at any time.
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), None);
        rig.queues(6, ratio(90.0));
        rig.finishes(5);
        assert_eq!(rig.ratio(), None);
        rig.finishes(6);
        assert_eq!(rig.ratio(), Some(90.0));
        rig.queues(7, ratio(10.0));
        rig.sets(magician_protocol::commands::QueuedCmdClear {});
        rig.finishes(8);
        assert_eq!(rig.ratio(), None, "it was dropped, or not");
        rig.reads(&ratio(90.0));
        assert_eq!(rig.ratio(), Some(90.0));
    }

    #[test]
    fn a_queue_that_goes_on_after_a_lost_line_changes_settings_still() {
        let mut rig = Rig::default();
        rig.queues(5, ratio(70.0));
        rig.0.forget();
        rig.reads(&ratio(40.0));
        assert_eq!(rig.ratio(), None);
        rig.finishes(5);
        assert_eq!(rig.ratio(), None);
        rig.reads(&ratio(70.0));
        assert_eq!(rig.ratio(), Some(70.0));
        rig.queues(6, ratio(80.0));
        rig.0.reset();
        rig.reads(&ratio(50.0));
        assert_eq!(rig.ratio(), Some(50.0), "nothing waits after a reset");
    }

    #[test]
    fn one_height_is_both_heights_and_whatever_may_burn_touches_the_laser() {
        let mut rig = Rig::default();
        let both = PtpJump2Params {
            start_jump_height: 1.0,
            end_jump_height: 2.0,
            z_limit: 3.0,
        };
        rig.sets(both);
        assert_eq!(rig.0.get::<PtpJump2Params>(0), Some(both));
        rig.sets(JUMP);
        assert_eq!(rig.0.get::<PtpJump2Params>(0), None);
        let dark = EndEffectorLaser {
            is_ctrl_enabled: Flag::OFF,
            is_on: Flag::OFF,
        };
        for light in [build::laser(true), build::output(2, true)] {
            rig.reads(&dark);
            assert_eq!(rig.0.get::<EndEffectorLaser>(0), Some(dark));
            rig.sets(light);
            assert_eq!(rig.0.get::<EndEffectorLaser>(0), None, "{light:?}");
        }
        rig.queues(9, build::laser(true));
        rig.reads(&dark);
        assert_eq!(
            rig.0.get::<EndEffectorLaser>(0),
            None,
            "it may be lit by now"
        );
    }

    #[test]
    fn what_says_nothing_of_settings_changes_none_and_what_nobody_knows_all() {
        let mut rig = Rig::default();
        rig.sets(ratio(40.0));
        rig.sets(QueuedCmdStartExec {});
        rig.queues(1, build::move_to(220.0, 0.0, 0.0, 0.0));
        assert_eq!(rig.ratio(), Some(40.0));
        rig.sets(ratio(f32::NAN));
        assert_eq!(rig.ratio(), None, "what an arm makes of that is unknown");
        rig.sets(ratio(40.0));
        let unknown = FrameBuf::new(99, Ctrl::SET, &[1]).unwrap();
        rig.answer(unknown, &[]);
        assert_eq!(rig.ratio(), None);
    }

    #[test]
    fn it_keeps_a_bounded_number_of_values() {
        let mut rig = Rig::default();
        for query in 0..=255_u8 {
            let row = <IoMultiplexing as Readable>::ROW;
            let request = FrameBuf::new(row.id, Ctrl::GET, &[query]).unwrap();
            rig.answer(request, &[query, 0]);
        }
        assert_eq!(rig.0.settings.len(), settings::MOST);
    }
}
