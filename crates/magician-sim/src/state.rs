//! A snapshot of the arm's state for tests, demonstrations and pictures.

use magician_motion::{JointAngles, Pose, ToolBias};
use magician_protocol::AlarmSet;

use crate::device::Device;
use crate::{ArmInstant, LineState, ToolOutput};

/// State of the arm at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ControllerState {
    /// The arm's clock.
    pub now: ArmInstant,
    /// Commanded pose of the tool, for the tool bias in force.
    pub pose: Pose,
    /// Tool bias in force.
    pub tool: ToolBias,
    /// Commanded joints.
    pub joints: JointAngles,
    /// True joints. They differ from the commanded ones after lost steps, and for the base before
    /// homing.
    pub true_joints: JointAngles,
    /// True if anything moves, homing included.
    pub moving: bool,
    /// True if the arm has been homed since power-up.
    pub homed: bool,
    /// Standing alarms.
    pub alarms: AlarmSet,
    /// Command queue filled by hosts.
    pub queue: QueueState,
    /// EIO address of the input that a running TRIG waits for, in the queue or in the stored
    /// program.
    pub awaits_input: Option<u8>,
    /// True if the stored program runs.
    pub program: bool,
    /// True while the unlock key is held: the motors are released and the arm can be moved by hand.
    pub unlocked: bool,
    /// Suction cup: sucking or not.
    pub suction: ToolOutput,
    /// Gripper: closed or open.
    pub gripper: ToolOutput,
    /// True if suction cup or gripper hold an object.
    pub holding: bool,
    /// True if the laser burns.
    pub laser: bool,
    /// Power of the laser, 0 to 100 percent; 0 is off.
    pub laser_power: f64,
    /// Commanded position of the rail's carriage, mm; `None` unless the rail is enabled.
    pub rail: Option<f64>,
    /// State of the cable to the host.
    pub line: LineState,
    /// Number of commands since power-up that were answered but not simulated, or only in part. An
    /// [`Event::NotSimulated`](crate::Event::NotSimulated) reports the first of each row.
    pub not_simulated: u64,
    /// Number of events dropped unread.
    pub events_lost: u64,
}

/// The command queue at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct QueueState {
    /// Number of places.
    pub capacity: usize,
    /// Number of waiting commands.
    pub waiting: usize,
    /// Index of the running command; `None` if none runs.
    pub running: Option<u64>,
    /// Id of the running command.
    pub running_id: Option<u8>,
    /// Index of the command that finished last; 0 before the first.
    pub current_index: u64,
    /// True between start and stop.
    pub started: bool,
    /// True if an alarm holds the queue until it is cleared.
    pub held: bool,
    /// Number of commands refused because the queue was full.
    pub overflows: u64,
}

impl ControllerState {
    pub(crate) fn of(device: &Device) -> Self {
        let Device {
            now,
            store,
            queues,
            alarms,
            motion,
            io,
            ..
        } = device;
        let (queue, arm) = (queues.hosts(), device.view().arm());
        let laser_power = io.tools.laser_power();
        Self {
            now: *now,
            pose: arm.pose,
            tool: store.settings.motion.tool(),
            joints: arm.joints,
            true_joints: motion.true_pose_of(*now, arm.joints).joints,
            moving: motion.is_moving(),
            homed: motion.is_homed(),
            alarms: alarms.standing(),
            queue: QueueState {
                capacity: queue.depth(),
                waiting: queue.waiting(),
                running: queue.running().map(|running| running.index),
                running_id: queue.running().map(|running| running.id),
                current_index: queue.current(),
                started: queue.is_started(),
                held: alarms.hold_queue(),
                overflows: queue.overflows(),
            },
            program: queues.program_runs(),
            unlocked: device.teaching.held(),
            awaits_input: device.awaited_input(),
            suction: io.tools.suction(*now),
            gripper: io.tools.gripper(*now),
            holding: device.world.holding(),
            laser: laser_power > 0.0,
            laser_power,
            rail: store
                .settings
                .motion
                // A disabled rail has a position, too, but only GetPoseL reports it.
                .has_rail()
                .then(|| motion.rail_at(*now)),
            line: device.line,
            not_simulated: device.record.log().count_not_simulated(),
            events_lost: device.record.log().lost(),
        }
    }
}
