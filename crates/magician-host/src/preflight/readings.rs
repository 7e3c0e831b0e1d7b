//! What an arm reports before a program.

use magician_model::MotionSettings;
use magician_motion::{ArmModel, ArmState, Ceilings};
use magician_protocol::commands::{EndEffectorLaser, HomeParams, Pose};
use magician_protocol::{Flag, Set};

/// What an arm says of itself before a program: where it is, and what decides how it will move.
///
/// The default are the settings of an arm that has just been switched on (model section 6), at a place that
/// is not known. `Arm::preflight` reads all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Readings {
    /// Where the arm stands; nothing while it moves.
    pub pose: Option<Pose>,
    /// Whether the laser burns.
    pub laser: EndEffectorLaser,
    /// Where homing ends.
    pub home: Option<HomeParams>,
    /// Where on the rail, mm.
    pub rail: Option<f32>,
    /// Tool, speeds, heights of jumps, and whether a rail is in use.
    pub settings: MotionSettings,
}

impl Default for Readings {
    fn default() -> Self {
        Self::at_power_up(&ArmModel::MAGICIAN)
    }
}

impl Readings {
    /// The settings of an arm of this firmware that has just been switched on, at a place that is not known.
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

    /// Follows a command as an arm with these ceilings stores it, but for what moves; whether it sets one of them.
    pub(super) fn note(&mut self, command: &Set, ceilings: &Ceilings) -> bool {
        match command {
            Set::HomeParams(home) => self.home = Some(*home),
            _ => return self.settings.note_stored(command, ceilings),
        }
        true
    }
}

/// Whether a command sets something that motions depend on: a reading, a jog's speed, or where the arm believes to be.
#[must_use]
pub fn governs_motion(command: &Set) -> bool {
    match command {
        Set::ResetPose(_) => true,
        // No motion takes what is set for arcs (model section 9).
        Set::ArcParams(_) | Set::ArcCommonParams(_) => false,
        Set::HomeParams(_) => true,
        _ => MotionSettings::default().note(command),
    }
}

/// Where an arm stands that reports this pose.
#[must_use]
pub fn state_at(pose: &Pose) -> ArmState {
    ArmState {
        joints: pose.joint_angle.map(f64::from).into(),
        pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from).into(),
    }
}

/// What an arm reports that stands there.
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

/// What a program depends on besides what every program does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    /// Where homing leads.
    pub home: bool,
    /// Speeds on continuous paths.
    pub path: bool,
    /// The rail: whether it is in use, where the carriage is, its speeds.
    pub rail: bool,
}

impl Needs {
    /// All that any command depends on.
    #[must_use]
    pub const fn all(rail: bool) -> Self {
        Self {
            home: true,
            path: true,
            rail,
        }
    }

    /// What these commands depend on.
    #[must_use]
    pub fn of(commands: &[Set]) -> Self {
        let mut needs = Self::default();
        for command in commands {
            match command {
                Set::HomeCmd(_) => needs.home = true,
                Set::CpCmd(_) | Set::CpLeCmd(_) => needs.path = true,
                Set::PtpWithLCmd(_) | Set::PtpPoWithLCmd(_) => needs.rail = true,
                _ => {}
            }
        }
        needs
    }
}
