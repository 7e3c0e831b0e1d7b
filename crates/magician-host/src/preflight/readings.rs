use magician_motion::{
    ArmModel, ArmState, CpSpeeds, JumpHeights, KinematicLimits, PowerUp, Speeds, ToolBias,
};
use magician_protocol::commands::{
    CpParams, EndEffectorLaser, EndEffectorParams, HomeParams, Pose, PtpCommonParams,
    PtpCoordinateParams, PtpJointParams, PtpJump2Params, PtpLParams,
};
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
    /// Tool bias, mm.
    pub tool: EndEffectorParams,
    /// Whether the laser burns.
    pub laser: EndEffectorLaser,
    /// Where homing ends.
    pub home: Option<HomeParams>,
    /// Speeds of the joints, deg/s and deg/s2.
    pub joint_speeds: PtpJointParams,
    /// Speeds of the tool on straight lines.
    pub line_speeds: PtpCoordinateParams,
    /// Share of the point-to-point speeds, percent.
    pub ratios: PtpCommonParams,
    /// Heights of jumps, mm.
    pub jump: PtpJump2Params,
    /// Speeds on continuous paths.
    pub path_speeds: CpParams,
    /// Whether the arm stands on a rail that is in use.
    pub with_rail: bool,
    /// Where on the rail, mm.
    pub rail: Option<f32>,
    /// Speeds on the rail, mm/s and mm/s2.
    pub rail_speeds: PtpLParams,
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
        let PowerUp {
            speeds,
            path,
            jump,
            rail,
            ..
        } = &model.power_up;
        let wire = |value: f64| value as f32;
        let tool = model.geometry.tool;
        Self {
            pose: None,
            tool: EndEffectorParams {
                x_bias: wire(tool.x),
                y_bias: wire(tool.y),
                z_bias: wire(tool.z),
            },
            laser: EndEffectorLaser {
                is_ctrl_enabled: Flag::OFF,
                is_on: Flag::OFF,
            },
            home: None,
            joint_speeds: PtpJointParams {
                velocity: speeds.joint_velocity.map(wire),
                acceleration: speeds.joint_acceleration.map(wire),
            },
            line_speeds: PtpCoordinateParams {
                xyz_velocity: wire(speeds.linear_velocity),
                r_velocity: wire(speeds.rotation_velocity),
                xyz_acceleration: wire(speeds.linear_acceleration),
                r_acceleration: wire(speeds.rotation_acceleration),
            },
            ratios: PtpCommonParams {
                velocity_ratio: wire(speeds.velocity_ratio),
                acceleration_ratio: wire(speeds.acceleration_ratio),
            },
            jump: PtpJump2Params {
                start_jump_height: wire(jump.start),
                end_jump_height: wire(jump.end),
                z_limit: wire(jump.z_limit),
            },
            path_speeds: CpParams {
                plan_acc: wire(path.plan_acceleration),
                junction_vel: wire(path.junction_velocity),
                // A host reads 100 there, which does nothing unless the host clocks the path.
                acc_or_period: 100.0,
                real_time_track: Flag::from(path.real_time),
            },
            with_rail: false,
            rail: None,
            rail_speeds: PtpLParams {
                velocity: wire(rail.velocity),
                acceleration: wire(rail.acceleration),
            },
        }
    }

    /// Whether a command sets one of them.
    fn are_set_by(command: &Set) -> bool {
        Self::default().note(command)
    }

    /// Follows a command, but for what moves; whether it sets one of them.
    pub(super) fn note(&mut self, command: &Set) -> bool {
        match command {
            Set::EndEffectorParams(tool) => self.tool = *tool,
            Set::HomeParams(home) => self.home = Some(*home),
            Set::PtpJointParams(speeds) => self.joint_speeds = *speeds,
            Set::PtpCoordinateParams(speeds) => self.line_speeds = *speeds,
            Set::PtpCommonParams(ratios) => self.ratios = *ratios,
            Set::PtpJump2Params(jump) => self.jump = *jump,
            // One height is both heights of the second set (model section 7).
            Set::PtpJumpParams(jump) => {
                self.jump = PtpJump2Params {
                    start_jump_height: jump.jump_height,
                    end_jump_height: jump.jump_height,
                    z_limit: jump.z_limit,
                }
            }
            Set::PtpLParams(speeds) => self.rail_speeds = *speeds,
            Set::CpParams(speeds) => self.path_speeds = *speeds,
            Set::SetDeviceWithL(rail) => self.with_rail = rail.with_l.is_on(),
            _ => return false,
        }
        true
    }

    pub(super) fn tool(&self) -> ToolBias {
        let EndEffectorParams {
            x_bias,
            y_bias,
            z_bias,
        } = self.tool;
        ToolBias::new(x_bias.into(), y_bias.into(), z_bias.into())
    }

    pub(super) fn jump_heights(&self) -> JumpHeights {
        JumpHeights {
            start: self.jump.start_jump_height.into(),
            end: self.jump.end_jump_height.into(),
            z_limit: self.jump.z_limit.into(),
        }
    }

    /// The speeds of point-to-point moves; the planner knows the arm's ceilings.
    pub(super) fn ptp_speeds(&self) -> Speeds {
        let (line, ratios) = (&self.line_speeds, &self.ratios);
        Speeds {
            joint_velocity: self.joint_speeds.velocity.map(f64::from),
            joint_acceleration: self.joint_speeds.acceleration.map(f64::from),
            linear_velocity: line.xyz_velocity.into(),
            linear_acceleration: line.xyz_acceleration.into(),
            rotation_velocity: line.r_velocity.into(),
            rotation_acceleration: line.r_acceleration.into(),
            velocity_ratio: ratios.velocity_ratio.into(),
            acceleration_ratio: ratios.acceleration_ratio.into(),
        }
    }

    /// The speeds of continuous paths.
    pub(super) fn cp_speeds(&self, model: &ArmModel) -> CpSpeeds {
        let (path, own) = (&self.path_speeds, &model.power_up.path);
        let real_time = path.real_time_track.is_on();
        CpSpeeds {
            plan_acceleration: path.plan_acc.into(),
            junction_velocity: path.junction_vel.into(),
            period_s: if real_time {
                f64::from(path.acc_or_period) / 1000.0
            } else {
                own.period_s
            },
            real_time,
        }
    }

    /// The speeds on the rail; nothing if one of them is none.
    pub(super) fn rail_rates(&self) -> Option<KinematicLimits> {
        let (rail, ratios) = (&self.rail_speeds, &self.ratios);
        let scaled = |value: f32, percent: f32| {
            // NaN is not above 0; f64::min would hide one.
            let sensible = value > 0.0 && percent > 0.0;
            sensible.then_some(f64::from(value) * f64::from(percent).min(100.0) / 100.0)
        };
        Some(KinematicLimits {
            velocity: scaled(rail.velocity, ratios.velocity_ratio)?,
            acceleration: scaled(rail.acceleration, ratios.acceleration_ratio)?,
        })
    }
}

/// Whether a command sets something that motions depend on: a reading, a jog's speed, or where the arm believes to be.
#[must_use]
pub fn governs_motion(command: &Set) -> bool {
    matches!(
        command,
        Set::JogJointParams(_)
            | Set::JogCoordinateParams(_)
            | Set::JogCommonParams(_)
            | Set::JogLParams(_)
            | Set::ResetPose(_)
    ) || Readings::are_set_by(command)
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
