//! Checks of commands before a byte is sent, and their duration.
//!
//! [`Preflight`] follows a program as the arm would: from the end of one command to the next, with
//! the settings in force by then, on the same planner as the virtual arm. So a program that would
//! stop with an alarm in the middle is refused at the beginning, and durations agree with the
//! virtual arm to the microsecond.

mod fence;
mod guards;
mod laser;
mod motion;
mod numbers;
mod path;
mod place;
mod program;
mod rail;
mod readings;
mod rendezvous;
mod retract;
mod speeds;
mod way;

use std::time::Duration;

use magician_model::tool_to_wire;
use magician_motion::{ArmModel, ArmState, Fence, JointAngles, Limits, MotionError, ToolBias};
use magician_protocol::{Flag, Set};

pub use guards::{Guards, refuse};
use laser::Laser;
use motion::depends_on_tool;
pub use motion::doubt_in_words;
pub(crate) use numbers::check as check_numbers;
pub use numbers::check_power;
use path::Path;
pub use program::CheckedProgram;
pub use readings::{Needs, Readings, governs_motion, pose_of, state_at};
pub use rendezvous::{MovingTarget, Rendezvous};
pub use retract::Lift;
pub use speeds::PathProfiles;
pub use way::Stopping;

use crate::Result;
use crate::message;

/// Duration of a command without a known end, us.
const FOREVER: u64 = u64::MAX;

/// Number of commands that this process has checked and planned.
#[cfg(feature = "counters")]
#[doc(hidden)]
pub static PLANNED: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);

/// Checks commands before a byte of them is sent, and calculates how long each takes.
///
/// It refuses values out of range or not finite, speeds of zero, targets and whole paths
/// out of reach (the corners of a jump, an arc, each segment of a path), and a laser left burning.
/// [`Guards`] lists the checks that can be switched off.
///
/// Each command is checked from the end of the previous one, with the speeds and the tool in force
/// by then.
///
/// ```
/// use magician_host::build;
/// use magician_host::preflight::Preflight;
/// use magician_host::{ErrorKind, JointAngles, ToolBias};
///
/// let mut check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
/// let step = check.check(&build::line_to(250.0, 50.0, 20.0, 0.0))?;
/// assert_eq!(step.time.as_millis(), 1540);
///
/// let error = check.check(&build::line_to(400.0, 0.0, 0.0, 0.0)).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Unreachable);
/// assert!(error.value() > error.limit());
/// # Ok::<(), magician_host::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Preflight {
    model: ArmModel,
    guards: Guards,
    /// Region in which the tip may be. `None` without a fence.
    fence: Option<Fence>,
    /// True if a laser may be wired to the pins.
    laser_pins: bool,
    /// Settings in force at this point.
    now: Readings,
    /// State of the arm at this point. `None` if unknown.
    at: Option<ArmState>,
    /// Position of the carriage on the rail at this point, mm. `None` if unknown.
    rail: Option<f64>,
    /// Home point. `None` if unknown.
    home: Option<magician_motion::Pose>,
    /// True if the program has set the home point, which then does not depend on the tool.
    home_is_set: bool,
    laser: Laser,
    path: Path,
    /// Part of a period that has passed at this point, us: a motion begins with the period in which
    /// its command arrives.
    into_period: u64,
    /// Limit common to all arms that the command under check exceeds, although this arm's own
    /// limits permit it.
    doubt: Option<MotionError>,
}

/// Effect of a command that passed the check.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Step {
    /// Time that the arm is busy with the command. [`Duration::MAX`] without a known end: a
    /// trigger, homing, a motion from an unknown start.
    ///
    /// Exact, except for segments of a continuous path. For these it is the time by which the path
    /// gets longer if it ends here: the sum is never less than the arm takes so far, and exact at
    /// the end of the path.
    pub time: Duration,
    /// Part of that time that belongs to the continuous path ended by this command and was not
    /// reported before.
    pub path: Duration,
    /// State of the arm afterwards. `None` if unknown.
    pub end: Option<ArmState>,
    /// True if the laser may burn afterwards.
    pub laser: bool,
    /// Bound of [`ArmModel::certain`] that the motion exceeds: this arm may move there, and another
    /// one may stop with an alarm. `None` for a motion within those limits or from an unknown
    /// start.
    pub doubt: Option<MotionError>,
}

impl Preflight {
    /// Creates a check that starts from the readings of an arm.
    #[must_use]
    pub fn new(readings: &Readings) -> Self {
        // A moving arm has no pose that a plan could start from.
        let at = readings.pose.as_ref().map(state_at);
        let home = readings.home;
        Self {
            model: ArmModel::MAGICIAN,
            guards: Guards::default(),
            fence: None,
            laser_pins: true,
            now: *readings,
            at,
            rail: readings.rail.map(f64::from),
            home: home.map(|home| [home.x, home.y, home.z, home.r].map(f64::from).into()),
            home_is_set: false,
            laser: Laser::reported(readings),
            path: Path::default(),
            into_period: 0,
            doubt: None,
        }
    }

    /// Creates a check that starts from joint angles, with the settings at power-up.
    #[must_use]
    pub fn at(joints: JointAngles, tool: ToolBias) -> Self {
        Self::of_model(&ArmModel::MAGICIAN, joints, tool)
    }

    /// Creates a check that starts from joint angles, for an arm of this model with its settings at
    /// power-up.
    #[must_use]
    pub fn of_model(model: &ArmModel, joints: JointAngles, tool: ToolBias) -> Self {
        let mut readings = Readings::at_power_up(model);
        readings.settings.tool = tool_to_wire(tool);
        let mut check = Self::new(&readings).model(*model);
        check.at = Some(ArmState::at_joints(&check.geometry(), &joints));
        check
    }

    /// Sets the model, for other firmware.
    #[must_use]
    pub fn model(mut self, model: ArmModel) -> Self {
        self.model = model;
        self
    }

    /// Model of the arm.
    #[must_use]
    pub fn arm_model(&self) -> &ArmModel {
        &self.model
    }

    /// Sets other limits than the controller's, for example [`ArmModel::guaranteed`].
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.model.limits = limits;
        // Limits set by the caller are not doubtful.
        self.model.certain = limits;
        self
    }

    /// Puts the arm on a rail that is in use, with its carriage at this position, mm.
    #[must_use]
    pub fn on_rail(mut self, at: f64) -> Self {
        self.now.settings.rail_setting.with_l = Flag::ON;
        self.rail = Some(at);
        self
    }

    /// True if the arm is on a rail that is in use, after the commands checked so far.
    #[must_use]
    pub fn is_on_rail(&self) -> bool {
        self.now.settings.has_rail()
    }

    /// Sets the guards.
    #[must_use]
    pub fn guards(mut self, guards: Guards) -> Self {
        self.guards = guards;
        self
    }

    /// Reports the time of a continuous path only once it is settled: with later segments, and the
    /// rest with the command that ends the path or by [`rest`](Self::rest).
    ///
    /// The sum is the same at a third of the work, but the times of single segments are lost. The
    /// time of a path in progress counts as reported.
    #[must_use]
    pub fn summing(mut self) -> Self {
        self.path = Path::lazy();
        self
    }

    /// Time of the path in progress that was not reported yet, assuming that it ends here.
    pub fn rest(&mut self) -> Duration {
        let rest = self.path.end();
        Duration::from_micros(self.moved_for(rest))
    }

    /// Additional time of a motion with this duration, a whole number of periods, us.
    fn moved_for(&mut self, lasting: u64) -> u64 {
        match lasting {
            0 => 0,
            FOREVER => FOREVER,
            // The first period has partly passed already.
            _ => lasting.saturating_sub(std::mem::take(&mut self.into_period)),
        }
    }

    /// Time of a command during which the arm stands still.
    fn stood_for(&mut self, lasting: u64) -> u64 {
        let by_then = self.into_period.saturating_add(lasting);
        self.into_period = match self.model.law.period_us() {
            // A model without a period, and an unknown end: motions then begin at once.
            0 => 0,
            _ if lasting == FOREVER => 0,
            period => by_then % u64::from(period),
        };
        lasting
    }

    /// State of the arm after the commands checked so far. `None` if unknown.
    #[must_use]
    pub fn arm(&self) -> Option<&ArmState> {
        self.at.as_ref()
    }

    /// Checks the next command. A refused command changes nothing: the next one is checked from the
    /// same start.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for invalid values and refusals by a guard,
    /// [`Unreachable`](crate::ErrorKind::Unreachable) with value and limit.
    pub fn check(&mut self, command: &Set) -> Result<Step> {
        #[cfg(feature = "counters")]
        PLANNED.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        self.doubt = None;
        let passed = numbers::check(command)
            .and_then(|()| self.laser.check(command, self.guards.laser))
            .and_then(|()| self.check_fence(command))
            .and_then(|()| self.follow(command));
        let own = passed.map_err(|error| {
            let named = self
                .restate_by_position(command, error)
                .with_command(command.row().set_name);
            if self.now.settings.tool.is_zero() && depends_on_tool(command) {
                named.of_unknown_tool()
            } else {
                named
            }
        })?;
        self.laser = self.laser.after(command);
        // Every command but a segment ends the path in progress.
        let path = match command {
            Set::CpCmd(_) | Set::CpLeCmd(_) => 0,
            _ => self.path.end(),
        };
        let path = self.moved_for(path);
        let own = match command {
            Set::WaitCmd(_) | Set::TrigCmd(_) | Set::EMotorS(_) => self.stood_for(own),
            _ => self.moved_for(own),
        };
        Ok(Step {
            time: match own.saturating_add(path) {
                FOREVER => Duration::MAX,
                time => Duration::from_micros(time),
            },
            path: Duration::from_micros(path),
            end: self.at,
            laser: self.laser.burns(),
            doubt: self.doubt,
        })
    }

    /// Checks that a program may end here.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) if it leaves the laser burning.
    pub fn finish(&self) -> Result<()> {
        let why =
            message!("the laser would keep burning after the program: switch it off at the end");
        refuse(self.guards.laser && self.laser.burns(), "laser", why)
    }

    /// Duration of these commands, one after the other from here, on an arm whose queue never runs
    /// dry.
    ///
    /// Equal to that of the virtual arm to the microsecond. [`Duration::MAX`] if one of them has no
    /// known end.
    ///
    /// ```
    /// use std::time::Duration;
    /// use magician_host::build;
    /// use magician_host::preflight::Preflight;
    /// use magician_host::{JointAngles, ToolBias};
    ///
    /// let check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    /// let there_and_back = [
    ///     build::line_by(0.0, 100.0, 0.0, 0.0),
    ///     build::wait(Duration::from_millis(500)),
    ///     build::line_by(0.0, -100.0, 0.0, 0.0),
    /// ];
    /// let time = check.estimate(&there_and_back)?;
    /// assert_eq!(time, Duration::from_millis(2000 + 500 + 2000));
    /// # Ok::<(), magician_host::Error>(())
    /// ```
    ///
    /// # Errors
    /// Same as [`check`](Self::check).
    pub fn estimate(&self, commands: &[Set]) -> Result<Duration> {
        self.clone().sum(commands)
    }

    fn sum(&mut self, commands: &[Set]) -> Result<Duration> {
        // Only the sum is wanted, which `summing` computes with a third of the work.
        let mut whole = self.clone().summing();
        let mut sum = Duration::ZERO;
        for (step, command) in commands.iter().enumerate() {
            let checked = whole.check(command);
            let checked = checked.map_err(|error| error.at_step(step))?;
            sum = sum.saturating_add(checked.time);
        }
        sum = sum.saturating_add(whole.rest());
        // The path has ended, so later commands report single times again.
        whole.path = Path::default();
        *self = whole;
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use magician_protocol::Alarm;

    use super::*;
    use crate::{Act, ErrorKind, Setting, build};

    #[test]
    fn lowest_j2_passes_with_a_doubt_and_below_the_limit_is_refused() {
        let at = |j2: f32| build::move_joints(0.0, j2, 30.0, 0.0);
        let mut check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        assert_eq!(check.check(&at(-4.0)).unwrap().doubt, None);
        let doubt = check.check(&at(-9.0)).unwrap().doubt.expect("below -5");
        let told = doubt_in_words(&doubt);
        assert!(
            told.contains("joint 2") && told.ends_with("below -5.0"),
            "{told}"
        );
        // Segments of a path are judged by their ends: from there to a position that is a little
        // lower.
        let [x, y, z] = check
            .arm()
            .map(|arm| [arm.pose.x, arm.pose.y, arm.pose.z])
            .unwrap();
        let path = build::path_to(x as f32 - 1.0, y as f32, z as f32);
        assert!(check.clone().check(&path).unwrap().doubt.is_some());
        assert_eq!(
            check.check(&at(0.0)).unwrap().doubt,
            None,
            "back to where all go"
        );
        let refused = check.check(&at(-14.0)).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Unreachable);
        // Limits measured on a single arm are certain.
        let model = ArmModel::MAGICIAN.with_lowest_j2(-9.5);
        let mut known = Preflight::at(JointAngles::HOME, ToolBias::SUCTION).model(model);
        assert_eq!(known.check(&at(-9.0)).unwrap().doubt, None);
        assert!(known.check(&at(-10.0)).is_err());
    }

    #[test]
    fn refusal_for_reach_names_an_unknown_tool_where_the_tool_decides() {
        for (tool, told) in [(ToolBias::NONE, true), (ToolBias::SUCTION, false)] {
            let mut check = Preflight::at(JointAngles::HOME, tool);
            for command in [
                build::move_to(400.0, 0.0, 20.0, 0.0),
                build::line_to(400.0, 0.0, 20.0, 0.0),
                build::jump_to(400.0, 0.0, 20.0, 0.0),
                build::path_to(400.0, 0.0, 20.0),
            ] {
                let error = check.check(&command).unwrap_err();
                assert_eq!(error.kind(), ErrorKind::Unreachable);
                assert_eq!(
                    error.message().contains(Alarm::TOOL_UNKNOWN),
                    told,
                    "{error}"
                );
                let mut acts = error.remedies().iter().map(|remedy| &remedy.act);
                let named = acts.any(|act| matches!(act, Act::Give(Setting::Tool, _)));
                assert_eq!(named, told, "{error}");
            }
            let error = check
                .check(&build::move_joints(200.0, 0.0, 0.0, 0.0))
                .unwrap_err();
            assert!(!error.message().contains(Alarm::TOOL_UNKNOWN), "{error}");
        }
    }
}
