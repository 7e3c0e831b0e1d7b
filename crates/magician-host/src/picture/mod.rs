//! The picture of an arm: all that is known of it without asking.
//!
//! One vocabulary feeds it: [`sent`](ArmPicture::sent) for each frame that goes out, [`answered`](ArmPicture::answered),
//! [`accepted`](ArmPicture::accepted) or [`failed`](ArmPicture::failed) for the end of each request, and
//! [`lost`](ArmPicture::lost), [`reset`](ArmPicture::reset), [`cleared`](ArmPicture::cleared) and
//! [`forget`](ArmPicture::forget) for what befell the arm or its line. Each part takes of that what concerns it. What frames
//! do not show is noted by its own name: a stop that was asked for, an arm that was seen to stand, a program that runs.

mod darkness;
mod homing;
mod known;
mod laser;
mod motion;
mod pending;
mod queued;
mod readings;
mod settings;
mod standing;
#[cfg(test)]
mod tests;
mod tools;
mod values;

use std::time::Duration;

use magician_protocol::commands::{DeviceSn, Pose, QueuedCmdClear};
use magician_protocol::{Frame, QueuedCmdIndex, Readable, Set, Writable};

pub use self::darkness::{Darkness, LightsOut};
pub use self::homing::HomingTracker;
pub use self::known::ArmSnapshot;
pub use self::motion::{MotionInFlight, sets_in_motion};
pub use self::queued::{Origin, OwnCommands, QueuedPace};
use self::readings::{LastReadings, Reading};
pub use self::readings::{Level, PictureEvent, Pin, StateReadings, serial_number};
pub use self::standing::{QueueLook, Standing, is_near, place};
pub use self::tools::{ArmOutputs, GripperState};
use self::values::Values;
use crate::connection::{Failure, Micros};
use crate::gate::Motors;
use crate::stream::ArmPace;

/// Shortest time of a motion that tells how fast an arm is.
const TELLING: Duration = Duration::from_millis(100);

/// An arm as far as it is known from what was sent over one connection, and from what the arm has answered.
///
/// * Settings ([`get`](Self::get)): a check that needs them need not read them again. A value is forgotten before anything
///   is sent that may change it, and known again when the arm has answered. A queued command counts when the arm has
///   finished it; until then nothing that was read in between is kept. At most 48 values are kept.
/// * Outputs ([`outputs`](Self::outputs)): tool, laser, suction cup, gripper and speed, to be shown. They stay as they were
///   until the arm has answered a command, or has finished a queued one by its current index. The laser errs towards
///   burning: it counts as lit as soon as a command that may burn goes out, and until a command that puts it out was
///   answered, or has finished in the queue. When `SetEndEffectorLaser` off was answered while the queue is held, what waits
///   in it does not count before the queue is started again.
/// * Motion that was set going ([`motion`](Self::motion)), the commands that wait ([`own`](Self::own)), the motors that run
///   ([`motors`](Self::motors)), homing ([`homing`](Self::homing)), where the arm was left ([`standing`](Self::standing)), and
///   what was read last ([`snapshot`](Self::snapshot)).
///
/// ```
/// use magician_host::picture::{ArmPicture, Origin};
/// use magician_host::protocol::{EncodeError, Readable};
/// use magician_host::{Ctrl, FrameBuf, commands::PtpCommonParams, build};
///
/// let mut picture = ArmPicture::default();
/// let request = FrameBuf::set(&build::speed(80.0, 60.0), Ctrl::SET)?;
/// let reply = FrameBuf::new(PtpCommonParams::ROW.id, Ctrl::SET, &[])?;
/// picture.sent(4_000, &request.frame());
/// assert_eq!(picture.get::<PtpCommonParams>(0), None);
/// picture.answered(5_000, Origin::Caller, &request.frame(), &reply.frame());
/// let known: PtpCommonParams = picture.get(0).unwrap();
/// assert_eq!(known.velocity_ratio, 80.0);
/// assert_eq!(picture.outputs().speed, Some(80.0));
/// # Ok::<(), EncodeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ArmPicture {
    /// True if other programs may use the line, and set what they like.
    shared_line: bool,
    /// True if a laser may be wired to EIO 2 and 4.
    laser_pins: bool,
    values: Values,
    motion: MotionInFlight,
    own: OwnCommands,
    motors: Motors,
    homing: HomingTracker,
    standing: Standing,
    readings: LastReadings,
    /// Since this connection put the laser out, until a command is queued.
    darkness: Option<Darkness>,
    /// How fast the arm is beside the check's times.
    pace: ArmPace,
}

impl Default for ArmPicture {
    fn default() -> Self {
        Self {
            shared_line: false,
            laser_pins: true,
            values: Values::default(),
            motion: MotionInFlight::default(),
            own: OwnCommands::default(),
            motors: Motors::default(),
            homing: HomingTracker::default(),
            standing: Standing::default(),
            readings: LastReadings::default(),
            darkness: None,
            pace: ArmPace::Unknown,
        }
    }
}

/// Frames, and how requests end.
impl ArmPicture {
    /// Takes a frame that goes out at `now`, us. Retransmitted frames count again.
    pub fn sent(&mut self, now: Micros, request: &Frame<'_>) {
        self.darkness = Darkness::after(self.darkness, now, request);
        self.values.sent(request);
        self.homing.sent(request);
        self.motion.sent(request);
        self.motors.sent(request);
        if self.standing.sent(request) {
            self.readings.doubt_alarms();
        }
    }

    /// Takes the answer to a request at `now`, us. What it shows comes out of [`poll_event`](Self::poll_event).
    pub fn answered(
        &mut self,
        now: Micros,
        origin: Origin,
        request: &Frame<'_>,
        reply: &Frame<'_>,
    ) {
        let (ctrl, id) = (request.ctrl(), request.id());
        if !ctrl.queued() && !ctrl.write() {
            return self.read(now, request, reply);
        }
        self.values.answered(now, request, reply);
        self.motion.answered(request);
        self.motors.answered(request);
        if ctrl.queued() {
            if let Ok(QueuedCmdIndex(index)) = reply.read() {
                let command = Set::decode(id, request.params()).ok();
                self.follow(index, command.as_ref(), origin);
            }
        } else if id == QueuedCmdClear::ROW.id {
            self.own.clear();
        } else if id == <DeviceSn as Readable>::ROW.id {
            self.readings.serial = serial_number(request.params());
        }
    }

    /// Returns the next event that answers have shown, oldest first.
    pub fn poll_event(&mut self) -> Option<PictureEvent> {
        self.readings.events.pop_front()
    }

    /// The arm has taken a command of a program into its queue under this index. It stands for [`answered`](Self::answered)
    /// where the frame of the request is not at hand; `command` is `None` if it is not known which one that was.
    pub fn accepted(&mut self, index: u64, command: Option<&Set>) {
        if let Some(command) = command {
            self.values.accepted(index, command);
        }
        self.follow(index, command, Origin::Run);
    }

    fn follow(&mut self, index: u64, command: Option<&Set>, origin: Origin) {
        self.motion.accepted(index);
        self.standing.accepted(index);
        if let Some(command) = command {
            self.homing.accepted(index, command);
            self.own.accepted(index, command, origin);
        }
    }

    fn read(&mut self, now: Micros, request: &Frame<'_>, reply: &Frame<'_>) {
        self.values.read(now, request, reply);
        match Reading::of(reply) {
            Reading::Current(current) => {
                self.values.finished(now, current);
                self.motion.read_current(current);
                self.homing.read_current(current);
                self.readings.read_current(current);
            }
            Reading::Pose(pose) => {
                self.values.read_pose(now, pose);
                self.homing.read_pose(&pose);
                if let Some(darkness) = &mut self.darkness {
                    darkness.see(now, pose);
                }
                self.readings.pose = Some((pose, now));
            }
            Reading::Alarms(alarms) => {
                self.standing.read_alarms(alarms);
                self.homing.read_alarms(alarms);
                self.readings.read_alarms(now, alarms);
            }
            Reading::LeftSpace(left) => self.readings.left_space = Some(left),
            Reading::Level(level) => self.readings.read_level(level),
            Reading::Serial(serial) => self.readings.serial = serial,
            Reading::Other => {}
        }
    }

    /// A request was not answered. `request` is `None` for one of a program, which finds out itself what became of it.
    pub fn failed(&mut self, request: Option<&Frame<'_>>, failure: &Failure) {
        let is_queued = request.is_none_or(|request| request.ctrl().queued());
        self.motion.failed(is_queued, failure);
        if let Some(request) = request {
            self.values.failed(request, failure);
        }
    }
}

/// What befell the arm, or its line.
impl ArmPicture {
    /// Forgets what another program may have changed. Commands in the queue may still be done, and a laser that was lit
    /// over this connection counts as lit.
    pub fn forget(&mut self) {
        self.values.forget();
        self.standing.forget();
        self.readings.doubt_alarms();
    }

    /// The line was lost: an arm that comes back may be another one, or have been switched off.
    pub fn lost(&mut self) {
        // It is not known whether the frame that puts the laser out has reached the arm.
        self.darkness = self.darkness.filter(|darkness| darkness.seen().is_some());
        self.forget();
        self.homing.forget();
    }

    /// The arm was reset: nothing is known, and nothing waits. Returns the indices, first and last, of what this connection
    /// had queued and had not finished.
    pub fn reset(&mut self) -> Option<(u64, u64)> {
        self.values.reset();
        self.own.clear();
        self.motors = Motors::default();
        self.homing.forget();
        self.standing.reset();
        self.readings.reset();
        (self.darkness, self.pace) = (None, ArmPace::Unknown);
        self.motion.reset()
    }

    /// Laser off, StopExec and Clear were answered on a line that was found again.
    pub fn cleared(&mut self) {
        self.motion.cleared();
        self.values.cleared();
    }

    /// The laser was put out on a line that was found again, before it was handed to this connection.
    pub fn found_dark(&mut self, darkness: Option<Darkness>) {
        self.darkness = self.darkness.or(darkness);
    }
}

/// What frames do not show.
impl ArmPicture {
    /// Other programs may use the line, and set what they like.
    #[must_use]
    pub fn on_shared_line(mut self, shared: bool) -> Self {
        self.shared_line = shared;
        self
    }

    /// A laser may be wired to EIO 2 and 4 (the default), or not.
    #[must_use]
    pub fn laser_pins(mut self, laser_pins: bool) -> Self {
        self.laser_pins = laser_pins;
        self
    }

    /// A request waits in the connection from here on, until it has [`returned`](Self::returned).
    pub fn handed_over(&mut self, request: &Frame<'_>) {
        self.motion.handed_over(request);
    }

    /// A request that was handed over has ended.
    pub fn returned(&mut self, request: &Frame<'_>) {
        self.motion.returned(request);
    }

    /// A program begins or ends.
    pub fn program_runs(&mut self, runs: bool) {
        self.motion.program_runs(runs);
    }

    /// A forced stop was asked for: from here on the arm may brake.
    pub fn stop_asked(&mut self) {
        self.motion.stop_asked();
    }

    /// The arm was seen to stand, by looks that all followed this many [forced stops](MotionInFlight::stops).
    pub fn stood_after(&mut self, stops: u64) {
        self.motion.stood_after(stops);
    }

    /// The queue is empty: what is put into it next runs next.
    pub fn queue_is_empty(&mut self) {
        self.own.queue_is_empty();
    }

    /// Takes a look at the queue that began when [`Standing::orders`] were `before`.
    pub fn note_look(&mut self, look: QueueLook, before: u64) {
        if self.standing.account(look.current) {
            // Another program has used the arm.
            self.forget();
        }
        self.standing.note_look(look, before);
    }

    /// The arm has finished all that it had, the last of it under this index, and stands at this pose.
    pub fn note_left_at(&mut self, now: Micros, index: u64, pose: Pose) {
        self.standing.note_left_at(now, index, pose);
    }

    /// A command that should take this time took that time: a short one says nothing.
    pub fn note_pace(&mut self, should: Duration, took: Duration) {
        if should >= TELLING {
            self.pace = if took >= should.mul_f64(0.9) {
                ArmPace::OnTime
            } else {
                ArmPace::Faster
            };
        }
    }

    /// The laser was switched off, and its pins are low.
    pub fn darkened(&mut self) {
        self.values.darkened();
    }

    /// The arm was seen to stand at its home point behind the homing command, or elsewhere.
    pub fn stood_at_home(&mut self, at_home: bool) {
        self.homing.stood_at_home(at_home);
    }

    /// A record from before this connection shows that the arm was homed since power-up.
    pub fn remember_homing(&mut self) {
        self.homing.remembered();
    }

    /// True once for each homing that was seen.
    pub fn take_new_homing(&mut self) -> bool {
        self.homing.take_new()
    }
}
