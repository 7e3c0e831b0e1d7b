//! State of an arm before a program, as read from it.

use magician_model::MotionSettings;
use magician_motion::{ArmModel, ArmState, Ceilings};
use magician_protocol::commands::{EndEffectorLaser, HomeParams, Pose};
use magician_protocol::{Flag, Set};

/// State of an arm before a program: its pose, and the settings that decide how it moves.
///
/// The default is an arm right after power-up (model section 6), at an unknown pose.
/// `Arm::preflight` reads the fields that motions depend on, except the home point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Readings {
    /// Pose of the arm. `None` while it moves.
    pub pose: Option<Pose>,
    /// State of the laser.
    pub laser: EndEffectorLaser,
    /// Home point. `None` if not read.
    pub home: Option<HomeParams>,
    /// Position on the rail, mm. `None` if unknown.
    pub rail: Option<f32>,
    /// Tool, speeds, jump heights, and whether a rail is in use.
    pub settings: MotionSettings,
}

impl Default for Readings {
    fn default() -> Self {
        Self::at_power_up(&ArmModel::MAGICIAN)
    }
}

impl Readings {
    /// Settings of an arm of this model right after power-up, at an unknown pose.
    #[must_use]
    pub fn at_power_up(model: &ArmModel) -> Self {
        Self {
            pose: None,
            laser: EndEffectorLaser {
                is_ctrl_enabled: Flag::OFF,
                is_on: Flag::OFF,
            },
            home: None,
            rail: None,
            settings: MotionSettings::at_power_up(model),
        }
    }

    /// Applies a setting as an arm with these ceilings stores it. True if the command is such a
    /// setting.
    pub(super) fn note(&mut self, command: &Set, ceilings: &Ceilings) -> bool {
        match command {
            Set::HomeParams(home) => self.home = Some(*home),
            _ => return self.settings.apply_clamped(command, ceilings),
        }
        true
    }
}

/// True if a command changes a value that motions depend on: one of these readings, a jog's speed,
/// or the arm's estimate of its pose.
#[must_use]
pub fn governs_motion(command: &Set) -> bool {
    match command {
        Set::ResetPose(_) => true,
        // No motion uses the settings of arcs (model section 9).
        Set::ArcParams(_) | Set::ArcCommonParams(_) => false,
        Set::HomeParams(_) => true,
        _ => MotionSettings::default().apply(command),
    }
}

/// State of an arm that reports this pose.
#[must_use]
pub fn state_at(pose: &Pose) -> ArmState {
    ArmState {
        joints: pose.joint_angle.map(f64::from).into(),
        pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from).into(),
    }
}

/// Pose that an arm in this state reports.
#[must_use]
pub fn pose_of(state: &ArmState) -> Pose {
    let [x, y, z, r] = state.pose.to_array().map(|value| value as f32);
    Pose {
        x,
        y,
        z,
        r,
        joint_angle: state.joints.to_array().map(|value| value as f32),
    }
}

/// Additional readings that a program needs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// Home point.
    pub home: bool,
    /// Speeds of continuous paths.
    pub path: bool,
    /// The rail: whether it is in use, its speeds, and the position of the carriage.
    pub rail: bool,
}

impl Needs {
    /// Readings needed by any command.
    #[must_use]
    pub const fn all(rail: bool) -> Self {
        Self {
            home: true,
            path: true,
            rail,
        }
    }

    /// Readings needed by these commands.
    #[must_use]
    pub fn of(commands: &[Set]) -> Self {
        let mut needs = Self::default();
        for command in commands {
            match command {
                Set::HomeCmd(_) => needs.home = true,
                Set::CpCmd(_) | Set::CpLeCmd(_) => needs.path = true,
                Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_) => needs.rail = true,
                // Other commands need nothing beyond the usual readings.
                _ => {}
            }
        }
        needs
    }
}
