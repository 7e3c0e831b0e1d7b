//! State of an arm, tracked from the frames that pass, without asking it.
//!
//! Front ends want to show tool, laser, homing and motion at any time, and checks need the arm's
//! settings; reading all of that before each use would occupy the line. So the picture follows
//! every frame of a connection. Its inputs are [`sent`](ArmPicture::sent) for each frame that goes
//! out, [`answered`](ArmPicture::answered), [`accepted`](ArmPicture::accepted) or
//! [`failed`](ArmPicture::failed) for the end of each request, and [`lost`](ArmPicture::lost),
//! [`reset`](ArmPicture::reset), [`cleared`](ArmPicture::cleared) and
//! [`forget`](ArmPicture::forget) for events of the arm or its line. Each part of the picture uses
//! the inputs that concern it. Events that frames do not show have their own methods: a requested
//! stop, an arm seen at rest, a running program.
//!
//! Where the picture is unsure, it errs towards burning and towards motion: both lead to a stop
//! that may be superfluous, never to a missing one.

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

pub use self::darkness::{LaserOffPose, LaserOffTracker};
pub use self::homing::HomingTracker;
pub use self::known::ArmSnapshot;
pub use self::motion::{MotionInFlight, sets_in_motion};
pub use self::queued::{Origin, OwnCommands, QueuedPace};
use self::readings::{LastReadings, Reading};
pub use self::readings::{Level, PictureEvent, Pin, StateReadings, serial_number};
pub use self::standing::{QueueLook, RestState, is_near, place};
pub use self::tools::{ArmOutputs, GripperState};
use self::values::Values;
use crate::connection::{Failure, Micros};
use crate::gate::Motors;
use crate::stream::ArmPace;

/// Shortest motion from which the arm's pace is judged.
// Shorter ones are dominated by the delays of the line.
const MIN_JUDGED_MOTION: Duration = Duration::from_millis(100);

/// State of an arm, from the frames sent over one connection and the arm's replies.
///
/// * Settings ([`get`](Self::get)), so that a check need not read them again. A value is discarded
///   before anything is sent that may change it, and known again when the arm has replied. A queued
///   command counts when the arm has finished it; readings in between are not kept. At most 48
///   values are kept.
/// * Outputs ([`outputs`](Self::outputs)) for display: tool, laser, suction cup, gripper and speed.
///   They change when the arm has replied to a command, or has finished a queued one according to
///   its current index. The laser errs towards burning: it counts as lit from the moment a command
///   that may burn is sent, until a command that switches it off was answered or has finished in
///   the queue. If `SetEndEffectorLaser` off was answered while the queue is held, waiting commands
///   do not count until the queue is started again.
/// * Motion in flight ([`motion`](Self::motion)), waiting commands ([`own`](Self::own)), running
///   motors ([`motors`](Self::motors)), homing ([`homing`](Self::homing)), the pose where the arm
///   was left ([`standing`](Self::standing)), and the last readings ([`snapshot`](Self::snapshot)).
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
    /// True if other programs may use the line and change settings.
    shared_line: bool,
    /// True if a laser may be wired to EIO 2 and 4.
    laser_pins: bool,
    values: Values,
    motion: MotionInFlight,
    own: OwnCommands,
    motors: Motors,
    homing: HomingTracker,
    standing: RestState,
    readings: LastReadings,
    /// State since this connection switched the laser off, until a command is queued.
    darkness: Option<LaserOffTracker>,
    /// Pace of the arm relative to the durations that checks calculate.
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
            standing: RestState::default(),
            readings: LastReadings::default(),
            darkness: None,
            pace: ArmPace::Unknown,
        }
    }
}

/// Frames, and the ends of requests.
impl ArmPicture {
    /// Processes a frame sent at `now`, us. Retransmissions count again.
    pub fn sent(&mut self, now: Micros, request: &Frame<'_>) {
        // Every part sees every frame; each decides what concerns it.
        self.darkness = LaserOffTracker::after(self.darkness, now, request);
        self.values.sent(request);
        self.homing.sent(request);
        self.motion.sent(request);
        self.motors.sent(request);
        if self.standing.sent(request) {
            self.readings.doubt_alarms();
        }
    }

    /// Processes the reply to a request at `now`, us. Its consequences are returned by
    /// [`poll_event`](Self::poll_event).
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

    /// Returns the next event, oldest first. `None` if all were returned.
    pub fn poll_event(&mut self) -> Option<PictureEvent> {
        self.readings.events.pop_front()
    }

    /// Notes that the arm accepted a command of a program with this index.
    ///
    /// Replaces [`answered`](Self::answered) where the frame of the request is not available.
    /// `command` is `None` if it is not known which command that was.
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

    /// Notes that a request failed. `request` is `None` for a request of a program, which keeps
    /// account of its requests itself.
    pub fn failed(&mut self, request: Option<&Frame<'_>>, failure: &Failure) {
        // Programs consist of queued commands.
        let is_queued = request.is_none_or(|request| request.ctrl().queued());
        self.motion.failed(is_queued, failure);
        if let Some(request) = request {
            self.values.failed(request, failure);
        }
    }
}

/// Events of the arm or its line.
impl ArmPicture {
    /// Discards what another program may have changed. Commands in the queue may still run, and a
    /// laser lit over this connection counts as lit.
    pub fn forget(&mut self) {
        self.values.forget();
        self.standing.forget();
        self.readings.doubt_alarms();
    }

    /// Notes that the line was lost: the arm that comes back may be another one, or have been
    /// switched off.
    pub fn lost(&mut self) {
        // The frame that switches the laser off may not have reached the arm.
        self.darkness = self.darkness.filter(|darkness| darkness.seen().is_some());
        self.forget();
        self.homing.forget();
    }

    /// Notes that the arm was reset: nothing is known, and its queue is empty. Returns the indices,
    /// first and last, of this connection's unfinished commands. `None` if there were none.
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

    /// Notes that laser off, StopExec and Clear were answered on a restored line.
    pub fn cleared(&mut self) {
        self.motion.cleared();
        self.values.cleared();
    }

    /// Notes that the laser was switched off on a restored line before this connection took over
    /// the line.
    pub fn found_dark(&mut self, darkness: Option<LaserOffTracker>) {
        // An earlier pose is closer to the end of the burn.
        self.darkness = self.darkness.or(darkness);
    }
}

/// Events that frames do not show.
impl ArmPicture {
    /// Declares that other programs may use the line and change settings.
    #[must_use]
    pub fn on_shared_line(mut self, shared: bool) -> Self {
        self.shared_line = shared;
        self
    }

    /// Declares whether a laser may be wired to EIO 2 and 4. The default is true.
    #[must_use]
    pub fn laser_pins(mut self, laser_pins: bool) -> Self {
        self.laser_pins = laser_pins;
        self
    }

    /// Notes that a request waits in the connection, until it has [`returned`](Self::returned).
    pub fn handed_over(&mut self, request: &Frame<'_>) {
        self.motion.handed_over(request);
    }

    /// Notes that a request that was handed over has ended.
    pub fn returned(&mut self, request: &Frame<'_>) {
        self.motion.returned(request);
    }

    /// Notes that a program begins or ends.
    pub fn program_runs(&mut self, runs: bool) {
        self.motion.program_runs(runs);
    }

    /// Notes that a forced stop was requested: from now on the arm may brake.
    pub fn stop_asked(&mut self) {
        self.motion.stop_asked();
    }

    /// Notes that the arm was seen at rest, by readings that all followed this many [forced
    /// stops](MotionInFlight::stops).
    pub fn stood_after(&mut self, stops: u64) {
        self.motion.stood_after(stops);
    }

    /// Notes that the queue is empty, so the next command put into it runs next.
    pub fn queue_is_empty(&mut self) {
        self.own.queue_is_empty();
    }

    /// Processes a reading of the queue that began when [`RestState::writes_sent`] was `before`.
    pub fn note_look(&mut self, look: QueueLook, before: u64) {
        if self.standing.account(look.current) {
            // Another program has used the arm, and may have changed any setting.
            self.forget();
        }
        self.standing.note_look(look, before);
    }

    /// Notes that the arm has finished everything, last the command with this index, and stands at
    /// this pose.
    pub fn note_left_at(&mut self, now: Micros, index: u64, pose: Pose) {
        self.standing.note_left_at(now, index, pose);
    }

    /// Notes the calculated and the real time of a command. Short commands are ignored.
    pub fn note_pace(&mut self, should: Duration, took: Duration) {
        if should >= MIN_JUDGED_MOTION {
            // 10 % tolerance for the line and the polling. Virtual arms at full speed are far
            // below.
            self.pace = if took >= should.mul_f64(0.9) {
                ArmPace::OnTime
            } else {
                ArmPace::Faster
            };
        }
    }

    /// Notes that the laser was switched off and its pins are low.
    pub fn darkened(&mut self) {
        self.values.darkened();
    }

    /// Notes whether the arm stands at its home point after the homing command.
    pub fn stood_at_home(&mut self, at_home: bool) {
        self.homing.stood_at_home(at_home);
    }

    /// Notes a record from before this connection that the arm was homed since power-up.
    pub fn remember_homing(&mut self) {
        self.homing.remembered();
    }

    /// Returns true once for each homing that was seen.
    pub fn take_new_homing(&mut self) -> bool {
        self.homing.take_new()
    }
}
