//! Checks before a byte is sent, and how long things will take.

mod fence;
mod guards;
mod laser;
mod meeting;
mod motion;
mod numbers;
mod path;
mod place;
mod program;
mod rail;
mod readings;
mod retract;
mod speeds;
mod way;

use std::time::Duration;

use magician_model::tool_to_wire;
use magician_motion::{ArmModel, ArmState, Fence, JointAngles, Limits, MotionError, ToolBias};
use magician_protocol::{Flag, Set};

pub use guards::{Guards, refuse};
use laser::Laser;
pub use meeting::{Meeting, MovingTarget};
use motion::depends_on_tool;
pub use motion::doubt_in_words;
pub(crate) use numbers::check as check_numbers;
pub use numbers::check_power;
use path::Path;
pub use program::CheckedProgram;
pub use readings::{Needs, Readings, governs_motion, pose_of, state_at};
pub use retract::Lift;
pub use speeds::PathProfiles;
pub use way::Stopping;

use crate::Result;
use crate::message;

/// The time of what has no end that is known, in microseconds.
const FOREVER: u64 = u64::MAX;

/// Commands that this process has checked and planned.
#[cfg(feature = "counters")]
#[doc(hidden)]
pub static PLANNED: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);

/// Checks commands before a byte of them is sent: numbers that are none, speeds that are none,
/// targets out of reach, whole ways that leave it (the corners of a jump, an arc, each segment of a
/// path), and a laser left burning. [`Guards`] names what is refused. It also tells how long each
/// command will take.
///
/// It follows the arm: each command is checked from where the one before ends, at the speeds and with
/// the tool in force by then.
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
    /// Where the tip may be.
    fence: Option<Fence>,
    /// Whether a laser may be wired to the pins.
    laser_pins: bool,
    /// The settings in force by then.
    now: Readings,
    /// Where the arm is by then, when that is known.
    at: Option<ArmState>,
    /// Where the carriage on the rail is by then, when that is known, mm.
    rail: Option<f64>,
    /// Where homing leads, when that is known.
    home: Option<magician_motion::Pose>,
    /// The program has set it, so it does not depend on the tool.
    home_is_set: bool,
    laser: Laser,
    path: Path,
    /// How much of a period has passed by then, us: a motion begins with the period that its command comes in.
    into_period: u64,
    /// Where the command under check leaves what every arm keeps to for certain.
    doubt: Option<MotionError>,
}

/// What a command that passed the check will do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Step {
    /// How long the arm will be busy with it; [`Duration::MAX`] if it has no end that is known: a
    /// trigger, homing, a way from an unknown start.
    ///
    /// Exact but for segments of a continuous path. There the time is by how much it makes the path
    /// longer that would end with it: the sum is never less than the arm takes so far, and exact at
    /// the end of the path.
    pub time: Duration,
    /// How much of it belongs to the continuous path that this command ends, and had not been told before.
    pub path: Duration,
    /// Where the arm stands then, when that is known.
    pub end: Option<ArmState>,
    /// The laser may burn when it has ended.
    pub laser: bool,
    /// Bound of [`ArmModel::certain`] that the motion leaves: this arm may go there, and another one may stop with an
    /// alarm. `None` for a motion within those limits, or from an unknown start.
    pub doubt: Option<MotionError>,
}

impl Preflight {
    /// Starts from what the arm reports.
    #[must_use]
    pub fn new(readings: &Readings) -> Self {
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

    /// Starts from joint angles, with power-up settings.
    #[must_use]
    pub fn at(joints: JointAngles, tool: ToolBias) -> Self {
        Self::of_model(&ArmModel::MAGICIAN, joints, tool)
    }

    /// Starts from joint angles, for an arm of this model with its settings at power-up.
    #[must_use]
    pub fn of_model(model: &ArmModel, joints: JointAngles, tool: ToolBias) -> Self {
        let mut readings = Readings::at_power_up(model);
        readings.settings.tool = tool_to_wire(tool);
        let mut check = Self::new(&readings).model(*model);
        check.at = Some(ArmState::at_joints(&check.geometry(), &joints));
        check
    }

    /// Checks for another firmware than the known one.
    #[must_use]
    pub fn model(mut self, model: ArmModel) -> Self {
        self.model = model;
        self
    }

    /// The model of the arm that is checked for.
    #[must_use]
    pub fn arm_model(&self) -> &ArmModel {
        &self.model
    }

    /// Checks against other limits than the controller's, [`ArmModel::guaranteed`] for one.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.model.limits = limits;
        self.model.certain = limits;
        self
    }

    /// Puts the arm on a rail that is in use, its carriage at this place, mm.
    #[must_use]
    pub fn on_rail(mut self, at: f64) -> Self {
        self.now.settings.with_rail.with_l = Flag::ON;
        self.rail = Some(at);
        self
    }

    /// True if the arm stands on a rail that is in use, as far as the commands checked so far tell.
    #[must_use]
    pub fn is_on_rail(&self) -> bool {
        self.now.settings.has_rail()
    }

    /// Sets what is refused.
    #[must_use]
    pub fn guards(mut self, guards: Guards) -> Self {
        self.guards = guards;
        self
    }

    /// Tells the time of a continuous path only as far as it is settled, with later segments, and the rest of it with the
    /// command that ends it, or as [`rest`](Self::rest): the same sum for a third of the work, where nothing needs a
    /// single segment. A path under way counts as told.
    #[must_use]
    pub fn summing(mut self) -> Self {
        self.path = Path::lazy();
        self
    }

    /// What has not been told yet of the path under way, which is taken to end here.
    pub fn rest(&mut self) -> Duration {
        let rest = self.path.end();
        Duration::from_micros(self.moved_for(rest))
    }

    /// How much longer a motion takes that lasts so many whole periods.
    fn moved_for(&mut self, lasting: u64) -> u64 {
        match lasting {
            0 => 0,
            FOREVER => FOREVER,
            _ => lasting.saturating_sub(std::mem::take(&mut self.into_period)),
        }
    }

    /// The arm stands for so long.
    fn stood_for(&mut self, lasting: u64) -> u64 {
        let by_then = self.into_period.saturating_add(lasting);
        self.into_period = match self.model.law.period_us() {
            0 => 0,
            _ if lasting == FOREVER => 0,
            period => by_then % u64::from(period),
        };
        lasting
    }

    /// Where the arm is after the commands checked so far, when it is known.
    #[must_use]
    pub fn arm(&self) -> Option<&ArmState> {
        self.at.as_ref()
    }

    /// Checks the next command. One that is refused changes nothing: the next is checked from where
    /// this one would have begun.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) for what makes no sense or what a guard refuses,
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
                .told_by_place(command, error)
                .with_command(command.row().set_name);
            if self.now.settings.tool.is_zero() && depends_on_tool(command) {
                named.of_unknown_tool()
            } else {
                named
            }
        })?;
        self.laser = self.laser.after(command);
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

    /// Whether a program may end here.
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) if it leaves the laser burning.
    pub fn finish(&self) -> Result<()> {
        let why =
            message!("the laser would keep burning after the program: switch it off at the end");
        refuse(self.guards.laser && self.laser.burns(), "laser", why)
    }

    /// How long these commands take, one after the other from here on, on an arm whose queue never
    /// runs short: to the microsecond that of the virtual arm. [`Duration::MAX`] if one of them has no
    /// end that is known.
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
    /// As [`check`](Self::check).
    pub fn estimate(&self, commands: &[Set]) -> Result<Duration> {
        self.clone().sum(commands)
    }

    fn sum(&mut self, commands: &[Set]) -> Result<Duration> {
        let mut whole = self.clone().summing();
        let mut sum = Duration::ZERO;
        for (step, command) in commands.iter().enumerate() {
            let checked = whole.check(command);
            let checked = checked.map_err(|error| error.at_step(step))?;
            sum = sum.saturating_add(checked.time);
        }
        sum = sum.saturating_add(whole.rest());
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
        // Segments of a path, by their ends: from there to a place that is a little lower.
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
        // What is known of a single arm is certain.
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
