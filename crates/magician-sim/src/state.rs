//! A look at everything, for tests, demonstrations and pictures.

use magician_motion::{JointAngles, Pose, ToolBias};
use magician_protocol::AlarmSet;

use crate::device::Device;
use crate::{ArmInstant, LineState, Output};

/// The arm at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ControllerState {
    /// The arm's clock.
    pub now: ArmInstant,
    /// The commanded tool pose, for the tool bias that is set.
    pub pose: Pose,
    /// The tool bias that is set.
    pub tool: ToolBias,
    /// The commanded joints.
    pub joints: JointAngles,
    /// Where the joints really stand: elsewhere than commanded after lost steps, and the base before homing.
    pub true_joints: JointAngles,
    /// Whether anything moves, homing included.
    pub moving: bool,
    /// Whether the arm has been homed since power-up.
    pub homed: bool,
    /// The alarms that stand.
    pub alarms: AlarmSet,
    /// The command queue that hosts fill.
    pub queue: QueueState,
    /// EIO address of the input that the command at work waits for: a TRIG, of the hosts or of the program.
    pub awaits_input: Option<u8>,
    /// Whether the program in the flash runs.
    pub program: bool,
    /// Whether the unlock key is held: the motors are released and a hand may move the arm.
    pub unlocked: bool,
    /// The suction cup: sucking or not.
    pub suction: Output,
    /// The gripper: closed or open.
    pub gripper: Output,
    /// Whether suction cup or gripper hold something.
    pub holding: bool,
    /// Whether the laser burns.
    pub laser: bool,
    /// Power of the laser, 0 to 100 percent; 0 is off.
    pub laser_power: f64,
    /// Where the carriage on the rail is commanded to be, mm; `None` unless the controller was told of a rail.
    pub rail: Option<f64>,
    /// The cable to the host.
    pub line: LineState,
    /// Commands since power-up that were answered but not acted on, or only in part; an
    /// [`Event::NotSimulated`](crate::Event::NotSimulated) tells the first of each row.
    pub not_simulated: u64,
    /// Events that were dropped unread.
    pub events_lost: u64,
}

/// The command queue at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct QueueState {
    /// Places in all.
    pub capacity: usize,
    /// Commands that wait.
    pub waiting: usize,
    /// Index of the command at work.
    pub running: Option<u64>,
    /// Its id.
    pub running_id: Option<u8>,
    /// Index of the command that finished last, 0 before the first.
    pub current_index: u64,
    /// Whether it takes commands: between start and stop.
    pub started: bool,
    /// Whether an alarm holds it until the alarms are cleared.
    pub held: bool,
    /// Commands that came when it was full.
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
                .has_rail()
                .then(|| motion.rail_at(*now)),
            line: device.line,
            not_simulated: device.record.log().count_not_simulated(),
            events_lost: device.record.log().lost(),
        }
    }
}
