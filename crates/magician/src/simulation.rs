//! Stepped simulation: a virtual arm without driver, thread or wall clock.
//!
//! Made for training and search, where a step must be cheap and repeatable: the same steps give the
//! same bits, and a clone is a snapshot.

use std::time::Duration;

use magician_host::preflight::{Preflight, Readings};
use magician_protocol::commands::{
    ClearAllAlarmsState, PtpCmd, QueuedCmdClear, QueuedCmdForceStopExec, QueuedCmdStartExec,
};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, PtpMode, Readable, Set};
use magician_sim::scenario::ToolKind;
use magician_sim::{ArmInstant, Controller, LinkId};

use crate::{Error, Result, build};

/// Link of the arm's only host.
const LINK: LinkId = LinkId(0);
/// Longest wait for rest. Choice: about twice the longest move at usual speeds.
const LONGEST: Duration = Duration::from_secs(60);

/// Meaning of the four numbers of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionKind {
    /// Pose, all joints at once: [`build::move_to`].
    MoveTo,
    /// Pose in a straight line: [`build::line_to`].
    LineTo,
    /// Pose over obstacles: [`build::jump_to`].
    JumpTo,
    /// Joint angles: [`build::move_joints`].
    MoveJoints,
    /// Offset of the pose, all joints at once: [`build::move_by`].
    MoveBy,
    /// Offset of the pose in a straight line: [`build::line_by`].
    LineBy,
    /// Offset of the joint angles: [`build::move_joints_by`].
    MoveJointsBy,
}

impl ActionKind {
    /// All kinds with their names.
    pub const NAMED: [(&str, Self); 7] = [
        ("move_to", Self::MoveTo),
        ("line_to", Self::LineTo),
        ("jump_to", Self::JumpTo),
        ("move_joints", Self::MoveJoints),
        ("move_by", Self::MoveBy),
        ("line_by", Self::LineBy),
        ("move_joints_by", Self::MoveJointsBy),
    ];

    /// True if the numbers are relative to the current position.
    #[must_use]
    pub fn is_relative(self) -> bool {
        matches!(self, Self::MoveBy | Self::LineBy | Self::MoveJointsBy)
    }

    fn command(self, [x, y, z, r]: [f32; 4]) -> Set {
        let ptp_mode = match self {
            Self::MoveTo => PtpMode::MovjXyz,
            Self::LineTo => PtpMode::MovlXyz,
            Self::JumpTo => PtpMode::JumpXyz,
            Self::MoveJoints => PtpMode::MovjAngle,
            Self::MoveBy => PtpMode::MovjXyzInc,
            Self::LineBy => PtpMode::MovlXyzInc,
            Self::MoveJointsBy => PtpMode::MovjAngleInc,
        };
        PtpCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
        }
        .into()
    }
}

/// Action of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepAction {
    /// Target. Without one, or if it contains NaN, the arm continues as before. An infinite target
    /// is refused like any target out of reach.
    pub target: Option<[f64; 4]>,
    /// True switches the suction cup on or closes the gripper, from now on.
    pub tool: Option<bool>,
}

/// State of the arm after a step, as a host sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Observation {
    /// Reported pose: x, y, z in mm, r in deg.
    pub pose: [f64; 4],
    /// Reported joint angles, deg.
    pub joints: [f64; 4],
    /// Clock of the arm, s.
    pub time: f64,
    /// True if the arm is busy.
    pub moving: bool,
    /// True if the check refused the last target, so that it was not sent.
    pub refused: bool,
    /// True if an alarm holds the arm; the next target clears it.
    pub alarm: bool,
    /// True if the suction cup or the gripper holds an object.
    pub holding: bool,
}

/// Virtual arm that is simulated step by step: each step takes a target, sends the frames that a
/// host would send, and lets the arm's time pass.
///
/// It is the arm behind [`VirtualArm`](crate::VirtualArm), without driver, thread and wall clock.
/// The same steps give the same bits, and a clone is a snapshot.
///
/// Targets are checked by [`Preflight`], as in a run; a refused target is not sent. A real arm
/// cannot change its target during a motion, only stop. So if a step ends before the arm is at rest
/// and the next has another target, the simulation sends a forced stop, clears the queue, and sends
/// the new target once the arm is at rest.
///
/// ```
/// use std::time::Duration;
/// use magician::{StepAction, ActionKind, Simulation, sim::Controller};
///
/// let mut arm = Simulation::new(Controller::default(), None)?;
/// let action = StepAction { target: Some([220.0, 60.0, 20.0, 0.0]), tool: None };
/// let seen = arm.step(ActionKind::LineTo, action, None);
/// assert_eq!(seen.pose[..2], [220.0, 60.0]);
/// let before = arm.clone();
/// let there = arm.step(ActionKind::MoveTo, StepAction::default(), Some(Duration::from_millis(100)));
/// assert_eq!(there.time, before.observe().time + 0.1);
/// # Ok::<(), magician::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Simulation {
    arm: Controller,
    /// Settings used by the check; they do not change.
    readings: Readings,
    grips: bool,
    /// Last target, unless its motion was stopped.
    target: Option<(ActionKind, [f32; 4])>,
    tool: Option<bool>,
    /// True if the queue was stopped and has to be started for the next target.
    stopped: bool,
    refused: bool,
}

impl Simulation {
    /// Takes over an arm at rest: clears its alarms, clears and starts its queue, and sets the
    /// point-to-point speed to `speed` percent, if given.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) if the check refuses the speed, or the arm
    /// is busy.
    pub fn new(arm: Controller, speed: Option<f64>) -> Result<Self> {
        if arm.busy() || arm.jogging() {
            let why = "the arm is busy: a simulation begins with an arm at rest";
            return Err(Error::invalid(why));
        }
        let grips = arm
            .world()
            .scenario()
            .is_some_and(|scenario| scenario.tool().kind == ToolKind::Gripper);
        let mut simulation = Self {
            readings: Readings::at_power_up(arm.arm_model()),
            arm,
            grips,
            target: None,
            tool: None,
            stopped: false,
            refused: false,
        };
        // Bytes of an earlier host may be half a frame.
        simulation.arm.close(LINK);
        simulation.send(&ClearAllAlarmsState {}.into(), Ctrl::SET);
        simulation.send(&QueuedCmdClear {}.into(), Ctrl::SET);
        simulation.send(&QueuedCmdStartExec {}.into(), Ctrl::SET);
        if let Some(percent) = speed {
            let speed = build::speed(percent as f32, percent as f32);
            Preflight::new(&Readings::default()).check(&speed)?;
            simulation.send(&speed, Ctrl::SET);
        }
        simulation.read();
        Ok(simulation)
    }

    /// Sends the target and lets `time` pass, or the time until the arm is at rest (at most a
    /// minute).
    pub fn step(
        &mut self,
        kind: ActionKind,
        action: StepAction,
        time: Option<Duration>,
    ) -> Observation {
        let end = self.arm.now() + time.unwrap_or(LONGEST);
        if let Some(on) = action.tool.filter(|on| self.tool != Some(*on)) {
            self.tool = Some(on);
            let command = match (self.grips, on) {
                (false, on) => build::suction(on),
                (true, true) => build::grip(),
                (true, false) => build::release(),
            };
            self.send(&command, Ctrl::SET);
        }
        // In the precision of the wire, so that equal targets compare equal.
        let target = action.target.map(|target| target.map(|value| value as f32));
        if let Some(target) = target.filter(|target| !target.iter().any(|value| value.is_nan())) {
            self.tell(kind, target, end);
        }
        match time {
            Some(_) => self.arm.advance(end),
            None => self.rest_by(end),
        }
        self.observe()
    }

    /// Returns the current state.
    #[must_use]
    pub fn observe(&self) -> Observation {
        let state = self.arm.state();
        // Rounded as on the wire: a host reads no more digits of a real arm.
        let wire = |values: [f64; 4]| values.map(|value| f64::from(value as f32));
        Observation {
            pose: wire(state.pose.to_array()),
            joints: wire(state.joints.to_array()),
            time: state.now.as_micros() as f64 / 1e6,
            moving: self.arm.busy(),
            refused: self.refused,
            alarm: state.alarms.blocking(),
            holding: state.holding,
        }
    }

    /// Returns the simulated controller.
    #[must_use]
    pub fn arm(&self) -> &Controller {
        &self.arm
    }

    /// Reads the settings used by the check.
    fn read(&mut self) {
        let mut known = self.readings.settings;
        known.tool = self.ask().unwrap_or(known.tool);
        known.ptp_joint = self.ask().unwrap_or(known.ptp_joint);
        known.ptp_coordinate = self.ask().unwrap_or(known.ptp_coordinate);
        known.ptp_common = self.ask().unwrap_or(known.ptp_common);
        known.ptp_jump2 = self.ask().unwrap_or(known.ptp_jump2);
        self.readings.settings = known;
    }

    /// Sends a target if the check accepts it and the arm comes to rest before the end of the step.
    fn tell(&mut self, kind: ActionKind, target: [f32; 4], end: ArmInstant) {
        // A forced stop leaves the queue stopped, even once the arm is at rest.
        if self.arm.busy() || self.stopped {
            // The same target again continues the motion; relative targets always add up.
            let goes_there = !kind.is_relative() && self.target == Some((kind, target));
            if goes_there && !self.stopped {
                return;
            }
            if !self.stopped {
                self.send(&QueuedCmdForceStopExec {}.into(), Ctrl::SET);
                (self.stopped, self.target) = (true, None);
            }
            self.rest_by(end);
            if self.arm.busy() {
                return;
            }
            self.send(&QueuedCmdClear {}.into(), Ctrl::SET);
            self.send(&QueuedCmdStartExec {}.into(), Ctrl::SET);
            self.stopped = false;
        }
        if self.arm.state().alarms.blocking() {
            self.send(&ClearAllAlarmsState {}.into(), Ctrl::SET);
        }
        let command = kind.command(target);
        self.readings.pose = self.ask();
        let check = Preflight::new(&self.readings).model(*self.arm.arm_model());
        self.refused = check.clone().check(&command).is_err();
        if !self.refused {
            self.target = Some((kind, target));
            self.send(&command, Ctrl::QUEUED);
        }
    }

    /// Lets time pass until the arm is at rest, or until `end`.
    fn rest_by(&mut self, end: ArmInstant) {
        // Event by event: a queue that ends early must not consume the rest of the time.
        while self.arm.busy() {
            match self.arm.poll_timeout().filter(|next| *next < end) {
                Some(next) => self.arm.advance(next),
                None => return self.arm.advance(end),
            }
        }
    }

    fn send(&mut self, command: &Set, ctrl: Ctrl) {
        if let Ok(frame) = FrameBuf::set(command, ctrl) {
            self.exchange(&frame);
        }
    }

    fn exchange(&mut self, frame: &FrameBuf) -> Option<FrameBuf> {
        self.arm.exchange(LINK, frame.bytes()).pop()
    }

    // Answered at once: the controller needs no time for a read.
    fn ask<R: Readable<Query = NoArgs>>(&mut self) -> Option<R> {
        let frame = FrameBuf::get(&NoArgs, R::ROW).ok()?;
        self.exchange(&frame)?.frame().read().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_sim::{Profile, Scenario, World};

    const TABLE: &str = "tool = { kind = \"suction\" }\ntable = { height = -60 }\n\
        object = [{ name = \"cube\", size = [20, 20, 20], at = [220, 80] }]";

    fn arm() -> Simulation {
        let world = World::from_scenario(&Scenario::from_toml(TABLE).unwrap());
        Simulation::new(Controller::in_world(Profile::default(), world), None).unwrap()
    }

    fn to(target: [f64; 4]) -> StepAction {
        let target = Some(target);
        StepAction { target, tool: None }
    }

    #[test]
    fn a_step_takes_the_time_that_a_run_takes() {
        let mut arm = arm();
        let from = arm.observe().time;
        let check = Preflight::at(arm.arm.state().joints, arm.arm.state().tool);
        let there = build::line_to(220.0, 80.0, 20.0, 0.0);
        let seen = arm.step(ActionKind::LineTo, to([220.0, 80.0, 20.0, 0.0]), None);
        let time = check.estimate(&[there]).unwrap();
        assert_eq!(seen.time - from, time.as_secs_f64());
        assert!(!seen.moving && !seen.refused && !seen.alarm, "{seen:?}");
    }

    #[test]
    fn a_snapshot_goes_on_as_the_original_does_to_the_bit() {
        let mut arm = arm();
        let tenth = Some(Duration::from_millis(100));
        arm.step(ActionKind::MoveTo, to([220.0, 80.0, 20.0, 0.0]), tenth);
        let mut copy = arm.clone();
        for target in [
            [250.0, 0.0, 10.0, 5.0],
            [250.0, 0.0, 10.0, 5.0],
            [180.0, 90.0, 0.0, 0.0],
        ] {
            let seen = arm.step(ActionKind::LineTo, to(target), tenth);
            assert!(seen.moving);
            assert_eq!(seen, copy.step(ActionKind::LineTo, to(target), tenth));
        }
    }

    #[test]
    fn a_refused_target_is_not_sent() {
        let mut arm = arm();
        let before = arm.observe();
        let seen = arm.step(
            ActionKind::LineTo,
            to([400.0, 0.0, 0.0, 0.0]),
            Some(Duration::from_secs(1)),
        );
        assert!(seen.refused && !seen.alarm);
        assert_eq!((seen.pose, seen.time), (before.pose, before.time + 1.0));
        assert_eq!(arm.arm.state().queue.current_index, 0);
        let seen = arm.step(ActionKind::LineTo, to([f64::NAN; 4]), None);
        assert!(seen.refused, "nothing new was said");
        // NaN means no target; an infinite value is a target out of reach.
        let near = to([220.0, 80.0, 20.0, 0.0]);
        for far in [f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
            let there = arm.step(ActionKind::LineTo, near, None);
            assert!(!there.refused);
            let seen = arm.step(ActionKind::LineTo, to([220.0, far, 20.0, 0.0]), None);
            assert_eq!((seen.refused, seen.pose), (true, there.pose), "{far}");
        }
    }

    #[test]
    fn another_target_on_the_way_stops_the_arm_and_the_same_does_not() {
        let (mut one, mut other) = (arm(), arm());
        let tenth = Some(Duration::from_millis(100));
        let target = to([220.0, 80.0, 20.0, 0.0]);
        let mut steps = 0;
        while steps == 0 || one.observe().moving {
            one.step(ActionKind::LineTo, target, tenth);
            steps += 1;
        }
        other.step(ActionKind::LineTo, target, None);
        assert_eq!(one.observe().pose, other.observe().pose);
        assert_eq!(one.arm.state().queue.current_index, 2);
        one.step(ActionKind::LineTo, to([250.0, 0.0, 20.0, 0.0]), tenth);
        let way = one.step(ActionKind::LineTo, target, Some(Duration::from_secs(20)));
        assert_eq!(way.pose, other.observe().pose);
        assert!(!way.moving);
    }

    #[test]
    fn the_cup_takes_a_cube() {
        let mut arm = arm();
        arm.step(ActionKind::JumpTo, to([220.0, 80.0, -40.0, 0.0]), None);
        let sucks = StepAction {
            target: None,
            tool: Some(true),
        };
        let seen = arm.step(ActionKind::LineTo, sucks, Some(Duration::from_millis(500)));
        assert!(seen.holding);
        let up = StepAction {
            target: Some([0.0, 0.0, 60.0, 0.0]),
            tool: Some(true),
        };
        let seen = arm.step(ActionKind::LineBy, up, None);
        assert!(
            seen.holding && (seen.pose[2] - 20.0).abs() < 1e-3,
            "{seen:?}"
        );
        let cube = arm.arm.look().object("cube").unwrap().place();
        assert!(cube.z.abs() < 0.1, "{cube:?}");
    }
}
