//! Settings that motions depend on, and the speeds, heights and bias derived from them (model
//! section 6).

use magician_motion::{
    ArmModel, Ceilings, CpSpeeds, JogAxis, JumpHeights, KinematicLimits, MotionError, PowerUp,
    Speeds, ToolBias,
};
use magician_protocol::commands::{
    ArcCommonParams, ArcParams, CpParams, EndEffectorParams, JogCommonParams, JogCoordinateParams,
    JogJointParams, JogLParams, PtpCommonParams, PtpCoordinateParams, PtpJointParams,
    PtpJump2Params, PtpJumpParams, PtpLParams, SetDeviceWithL,
};
use magician_protocol::{Flag, Set};

use crate::ceilings::as_stored;

/// Settings that motions depend on, each bit for bit as on the wire. Speeds and heights are
/// computed from them on request.
///
/// ```
/// use magician_model::MotionSettings;
/// use magician_motion::{ArmModel, JogAxis};
/// use magician_protocol::commands::PtpJumpParams;
/// use magician_protocol::Set;
///
/// let model = ArmModel::MAGICIAN;
/// let mut settings = MotionSettings::at_power_up(&model);
/// // The jog ratio at power-up is 50 %.
/// assert_eq!(settings.jog(JogAxis::X, &model.ceilings)?.velocity, 30.0);
///
/// assert!(settings.apply(&Set::from(PtpJumpParams { jump_height: 15.0, z_limit: 90.0 })));
/// assert_eq!(settings.jump().end, 15.0);
/// # Ok::<(), magician_motion::MotionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionSettings {
    /// Tool bias, mm.
    pub tool: EndEffectorParams,
    /// Jog speeds of the joints, deg/s and deg/s2.
    pub jog_joint: JogJointParams,
    /// Jog speeds of x, y, z and r.
    pub jog_coordinate: JogCoordinateParams,
    /// Ratios of jogs, percent.
    pub jog_common: JogCommonParams,
    /// Jog speeds of the carriage on the rail, mm/s and mm/s2.
    pub jog_rail: JogLParams,
    /// Speeds of the joints in point-to-point moves, deg/s and deg/s2.
    pub ptp_joint: PtpJointParams,
    /// Speeds of the tool on straight lines.
    pub ptp_coordinate: PtpCoordinateParams,
    /// Jump height as last set by the command with one height, mm.
    pub ptp_jump: PtpJumpParams,
    /// Jump heights in force, mm.
    pub ptp_jump2: PtpJump2Params,
    /// Ratios of point-to-point moves, percent.
    pub ptp_common: PtpCommonParams,
    /// Speeds of the carriage on the rail, mm/s and mm/s2.
    pub ptp_rail: PtpLParams,
    /// Speeds of continuous paths.
    pub cp: CpParams,
    /// Speeds of arcs. The arm stores them, but no motion uses them (model section 9).
    pub arc: ArcParams,
    /// Ratios of arcs. The arm stores them, but no motion uses them (model section 9).
    pub arc_common: ArcCommonParams,
    /// On if the arm stands on a rail that is in use.
    pub rail_setting: SetDeviceWithL,
}

impl MotionSettings {
    /// Settings of an arm of this model right after power-up.
    #[must_use]
    pub fn at_power_up(model: &ArmModel) -> Self {
        let PowerUp {
            joints: _,
            jog,
            ptp,
            cp,
            arc,
        } = &model.power_up;
        let ptp_jump = PtpJumpParams {
            jump_height: ptp.jump_height,
            z_limit: ptp.z_limit,
        };
        Self {
            tool: tool_to_wire(model.geometry.tool),
            jog_joint: JogJointParams {
                velocity: jog.joint_velocity,
                acceleration: jog.joint_acceleration,
            },
            jog_coordinate: JogCoordinateParams {
                velocity: jog.coordinate_velocity,
                acceleration: jog.coordinate_acceleration,
            },
            jog_common: JogCommonParams {
                velocity_ratio: jog.velocity_ratio,
                acceleration_ratio: jog.acceleration_ratio,
            },
            jog_rail: JogLParams {
                velocity: jog.rail_velocity,
                acceleration: jog.rail_acceleration,
            },
            ptp_joint: PtpJointParams {
                velocity: ptp.joint_velocity,
                acceleration: ptp.joint_acceleration,
            },
            ptp_coordinate: PtpCoordinateParams {
                xyz_velocity: ptp.linear_velocity,
                r_velocity: ptp.rotation_velocity,
                xyz_acceleration: ptp.linear_acceleration,
                r_acceleration: ptp.rotation_acceleration,
            },
            ptp_jump,
            ptp_jump2: both_heights(&ptp_jump),
            ptp_common: PtpCommonParams {
                velocity_ratio: ptp.velocity_ratio,
                acceleration_ratio: ptp.acceleration_ratio,
            },
            ptp_rail: PtpLParams {
                velocity: ptp.rail_velocity,
                acceleration: ptp.rail_acceleration,
            },
            cp: CpParams {
                plan_acc: cp.plan_acceleration,
                junction_vel: cp.junction_velocity,
                acc_or_period: cp.acceleration,
                real_time_track: Flag::from(cp.real_time_track),
            },
            arc: ArcParams {
                xyz_velocity: arc.linear_velocity,
                r_velocity: arc.rotation_velocity,
                xyz_acceleration: arc.linear_acceleration,
                r_acceleration: arc.rotation_acceleration,
            },
            arc_common: ArcCommonParams {
                velocity_ratio: arc.velocity_ratio,
                acceleration_ratio: arc.acceleration_ratio,
            },
            rail_setting: SetDeviceWithL {
                with_l: Flag::OFF,
                version: None,
            },
        }
    }

    /// Applies a command. True if it sets one of these settings.
    pub fn apply(&mut self, command: &Set) -> bool {
        match command {
            Set::EndEffectorParams(set) => self.tool = *set,
            Set::JogJointParams(set) => self.jog_joint = *set,
            Set::JogCoordinateParams(set) => self.jog_coordinate = *set,
            Set::JogCommonParams(set) => self.jog_common = *set,
            Set::JogLParams(set) => self.jog_rail = *set,
            Set::PtpJointParams(set) => self.ptp_joint = *set,
            Set::PtpCoordinateParams(set) => self.ptp_coordinate = *set,
            Set::PtpJump2Params(set) => self.ptp_jump2 = *set,
            Set::PtpJumpParams(set) => {
                self.ptp_jump = *set;
                self.ptp_jump2 = both_heights(set);
            }
            Set::PtpCommonParams(set) => self.ptp_common = *set,
            Set::PtpLParams(set) => self.ptp_rail = *set,
            Set::CpParams(set) => self.cp = *set,
            Set::ArcParams(set) => self.arc = *set,
            Set::ArcCommonParams(set) => self.arc_common = *set,
            Set::SetDeviceWithL(set) => self.rail_setting = *set,
            // Not a setting of motion.
            _ => return false,
        }
        true
    }

    /// Applies a command as an arm with these ceilings stores it. True if it sets one of these
    /// settings.
    pub fn apply_clamped(&mut self, command: &Set, ceilings: &Ceilings) -> bool {
        self.apply(&as_stored(command, ceilings))
    }

    /// Tool bias, mm.
    #[must_use]
    pub fn tool(&self) -> ToolBias {
        let EndEffectorParams {
            x_bias,
            y_bias,
            z_bias,
        } = self.tool;
        ToolBias::new(x_bias.into(), y_bias.into(), z_bias.into())
    }

    /// True if the arm stands on a rail that is in use.
    #[must_use]
    pub fn has_rail(&self) -> bool {
        self.rail_setting.with_l.is_on()
    }

    /// Speeds of point-to-point moves as set. The planner applies the ceilings.
    #[must_use]
    pub fn speeds(&self) -> Speeds {
        let (joint, space, ratio) = (&self.ptp_joint, &self.ptp_coordinate, &self.ptp_common);
        Speeds {
            joint_velocity: joint.velocity.map(f64::from),
            joint_acceleration: joint.acceleration.map(f64::from),
            linear_velocity: space.xyz_velocity.into(),
            linear_acceleration: space.xyz_acceleration.into(),
            rotation_velocity: space.r_velocity.into(),
            rotation_acceleration: space.r_acceleration.into(),
            velocity_ratio: ratio.velocity_ratio.into(),
            acceleration_ratio: ratio.acceleration_ratio.into(),
        }
    }

    /// Speeds of arcs and circles: the point-to-point speeds, whatever was set for arcs (model
    /// section 9).
    #[must_use]
    pub fn arc_speeds(&self) -> Speeds {
        self.speeds()
    }

    /// Heights of jumps.
    #[must_use]
    pub fn jump(&self) -> JumpHeights {
        let heights = &self.ptp_jump2;
        JumpHeights {
            start: heights.start_jump_height.into(),
            end: heights.end_jump_height.into(),
            z_limit: heights.z_limit.into(),
        }
    }

    /// Speeds of continuous paths. The period is the firmware's own unless the host clocks the path
    /// (`real_time_track`).
    #[must_use]
    pub fn cp(&self, model: &ArmModel) -> CpSpeeds {
        let real_time = self.cp.real_time_track.is_on();
        CpSpeeds {
            plan_acceleration: self.cp.plan_acc.into(),
            junction_velocity: self.cp.junction_vel.into(),
            period_s: if real_time {
                // The same field is a period in ms in this mode.
                f64::from(self.cp.acc_or_period) / 1000.0
            } else {
                model.path.period
            },
            real_time,
        }
    }

    /// Speed and acceleration of jogging an axis, each clamped to its ceiling. The ratio scales the
    /// velocity alone.
    ///
    /// # Errors
    /// [`MotionError::Speed`] for a value or a ratio that is NaN, zero or negative.
    pub fn jog(&self, axis: JogAxis, ceilings: &Ceilings) -> Result<KinematicLimits, MotionError> {
        let set = self.jog_setting(axis);
        let speeds = Speeds {
            joint_velocity: [set.velocity; 4],
            joint_acceleration: [set.acceleration; 4],
            linear_velocity: set.velocity,
            linear_acceleration: set.acceleration,
            rotation_velocity: set.velocity,
            rotation_acceleration: set.acceleration,
            velocity_ratio: self.jog_common.velocity_ratio.into(),
            acceleration_ratio: 100.0,
        };
        speeds.jog(axis, ceilings)
    }

    /// Deceleration of a stopping jog, clamped to its ceiling. Neither ratio nor velocity affects
    /// it. Zero, negative or NaN if the setting is.
    #[must_use]
    pub fn jog_deceleration(&self, axis: JogAxis, ceilings: &Ceilings) -> f64 {
        let (set, ceiling) = (self.jog_setting(axis), ceilings.of_axis(axis));
        // f64::min would replace a NaN by the ceiling.
        if set.acceleration > ceiling.acceleration {
            ceiling.acceleration
        } else {
            set.acceleration
        }
    }

    fn jog_setting(&self, axis: JogAxis) -> KinematicLimits {
        let (joint, space) = (&self.jog_joint, &self.jog_coordinate);
        let ([v1, v2, v3, v4], [a1, a2, a3, a4]) = (joint.velocity, joint.acceleration);
        let ([vx, vy, vz, vr], [ax, ay, az, ar]) = (space.velocity, space.acceleration);
        let (velocity, acceleration) = match axis {
            JogAxis::J1 => (v1, a1),
            JogAxis::J2 => (v2, a2),
            JogAxis::J3 => (v3, a3),
            JogAxis::J4 => (v4, a4),
            JogAxis::X => (vx, ax),
            JogAxis::Y => (vy, ay),
            JogAxis::Z => (vz, az),
            JogAxis::R => (vr, ar),
        };
        KinematicLimits {
            velocity: velocity.into(),
            acceleration: acceleration.into(),
        }
    }

    /// Speed and acceleration of moves on the rail. `None` if a value or ratio is NaN, zero or
    /// negative.
    #[must_use]
    pub fn rail(&self) -> Option<KinematicLimits> {
        let (set, ratios) = (&self.ptp_rail, &self.ptp_common);
        Some(KinematicLimits {
            velocity: scaled(set.velocity, ratios.velocity_ratio)?,
            acceleration: scaled(set.acceleration, ratios.acceleration_ratio)?,
        })
    }

    /// Speed and acceleration of jogs on the rail. `None` if a value or the ratio is NaN, zero or
    /// negative.
    #[must_use]
    pub fn rail_jog(&self) -> Option<KinematicLimits> {
        let set = &self.jog_rail;
        Some(KinematicLimits {
            velocity: scaled(set.velocity, self.jog_common.velocity_ratio)?,
            // The acceleration of a jog has no ratio.
            acceleration: scaled(set.acceleration, 100.0)?,
        })
    }
}

impl Default for MotionSettings {
    /// Settings at power-up of firmware 3.6.14.
    fn default() -> Self {
        Self::at_power_up(&ArmModel::MAGICIAN)
    }
}

/// Tool bias as a host sets it, rounded to `f32` as on the wire.
#[must_use]
pub fn tool_to_wire(tool: ToolBias) -> EndEffectorParams {
    EndEffectorParams {
        x_bias: tool.x as f32,
        y_bias: tool.y as f32,
        z_bias: tool.z as f32,
    }
}

/// The command with one height sets both heights (model section 7).
const fn both_heights(set: &PtpJumpParams) -> PtpJump2Params {
    PtpJump2Params {
        start_jump_height: set.jump_height,
        end_jump_height: set.jump_height,
        z_limit: set.z_limit,
    }
}

/// Value times ratio in percent, clamped to 100 %. `None` if either is NaN, zero or negative.
fn scaled(value: f32, percent: f32) -> Option<f64> {
    // Both comparisons are false for NaN, which f64::min would hide.
    let sensible = value > 0.0 && percent > 0.0;
    sensible.then_some(f64::from(value) * (f64::from(percent).min(100.0) / 100.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: ArmModel = ArmModel::MAGICIAN;

    fn after(commands: &[Set]) -> MotionSettings {
        let mut settings = MotionSettings::at_power_up(&MODEL);
        for command in commands {
            assert!(settings.apply(command), "{command:?}");
        }
        settings
    }

    fn ratios(velocity_ratio: f32, acceleration_ratio: f32) -> Set {
        Set::from(PtpCommonParams {
            velocity_ratio,
            acceleration_ratio,
        })
    }

    fn jog_ratio(velocity_ratio: f32) -> Set {
        Set::from(JogCommonParams {
            velocity_ratio,
            acceleration_ratio: 10.0,
        })
    }

    #[test]
    fn power_up_settings_match_model() {
        let settings = MotionSettings::at_power_up(&MODEL);
        assert_eq!(settings.speeds(), MODEL.power_up.speeds());
        assert_eq!(settings.arc_speeds(), MODEL.power_up.speeds());
        assert_eq!(settings.jump(), MODEL.power_up.jump());
        assert_eq!(settings.cp(&MODEL), MODEL.cp_speeds());
        assert_eq!(settings.tool().x, f64::from(MODEL.geometry.tool.x as f32));
        assert!(!settings.has_rail());
    }

    #[test]
    fn single_jump_height_sets_both_heights() {
        let one = PtpJumpParams {
            jump_height: 12.0,
            z_limit: 80.0,
        };
        let two = PtpJump2Params {
            start_jump_height: 5.0,
            end_jump_height: 7.0,
            z_limit: 90.0,
        };
        assert_eq!(after(&[one.into()]).jump(), JumpHeights::even(12.0, 80.0));
        let settings = after(&[one.into(), two.into()]);
        assert_eq!((settings.jump().start, settings.jump().end), (5.0, 7.0));
        assert_eq!(settings.ptp_jump, one);
    }

    #[test]
    fn host_that_clocks_a_path_sets_its_period() {
        let mut cp = MotionSettings::default().cp;
        (cp.acc_or_period, cp.real_time_track) = (8.0, Flag::ON);
        let speeds = after(&[cp.into()]).cp(&MODEL);
        assert_eq!((speeds.period_s, speeds.real_time), (0.008, true));
    }

    #[test]
    fn rail_speed_scales_by_ratio_and_refuses_nan_zero_negative() {
        let rail = PtpLParams {
            velocity: 80.0,
            acceleration: 60.0,
        };
        let at = |velocity, acceleration| after(&[rail.into(), ratios(velocity, acceleration)]);
        let rates = at(25.0, 300.0).rail();
        let expected = KinematicLimits {
            velocity: 20.0,
            acceleration: 60.0,
        };
        assert_eq!(rates, Some(expected));
        for invalid in [0.0, -1.0, f32::NAN] {
            assert_eq!(at(invalid, 50.0).rail(), None);
            assert_eq!(after(&[jog_ratio(invalid)]).rail_jog(), None);
        }
        // The acceleration of a jog has no ratio.
        let jog = after(&[jog_ratio(50.0)]).rail_jog();
        assert_eq!(
            jog.map(|rates| [rates.velocity, rates.acceleration]),
            Some([50.0, 100.0])
        );
    }

    #[test]
    fn jog_has_the_speed_of_its_axis_up_to_the_ceiling_and_then_the_ratio() {
        let space = JogCoordinateParams {
            velocity: [40.0, 50.0, 900.0, 20.0],
            acceleration: [1.0, 2.0, 900.0, 4.0],
        };
        let settings = after(&[space.into(), jog_ratio(50.0)]);
        let jog = |axis| settings.jog(axis, &MODEL.ceilings).expect("a speed");
        assert_eq!(jog(JogAxis::Y).velocity, 25.0);
        assert_eq!(jog(JogAxis::R).acceleration, 4.0);
        assert_eq!(
            [jog(JogAxis::Z).velocity, jog(JogAxis::Z).acceleration],
            [150.0, 400.0]
        );
        // The deceleration of a stop does not depend on the ratio.
        let without = after(&[space.into(), jog_ratio(0.0)]);
        assert!(without.jog(JogAxis::Z, &MODEL.ceilings).is_err());
        assert_eq!(without.jog_deceleration(JogAxis::Z, &MODEL.ceilings), 400.0);
        // Store the setting as the arm would.
        let mut stored = MotionSettings::default();
        stored.apply_clamped(&space.into(), &MODEL.ceilings);
        assert_eq!(stored.jog_coordinate.velocity, [40.0, 50.0, 300.0, 20.0]);
    }
}
