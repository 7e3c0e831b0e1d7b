//! Settings at power-up, before a host has set anything (model section 6).

use crate::{ArmModel, JointAngles, JumpHeights, Speeds};

/// Settings at power-up. Values that a host can set are in the protocol's `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerUp {
    /// Joints reported before homing, deg.
    pub joints: JointAngles,
    /// Jogging.
    pub jog: JogDefaults,
    /// Point to point.
    pub ptp: PtpDefaults,
    /// Continuous paths.
    pub cp: CpDefaults,
    /// Arcs.
    pub arc: ArcDefaults,
}

/// Jog speeds at power-up: deg/s, mm/s, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[allow(missing_docs)]
pub struct JogDefaults {
    pub joint_velocity: [f32; 4],
    pub joint_acceleration: [f32; 4],
    /// For x, y, z and r.
    pub coordinate_velocity: [f32; 4],
    pub coordinate_acceleration: [f32; 4],
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub rail_velocity: f32,
    pub rail_acceleration: f32,
}

/// Point-to-point speeds and jump heights at power-up: deg/s, mm/s, percent, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[allow(missing_docs)]
pub struct PtpDefaults {
    pub joint_velocity: [f32; 4],
    pub joint_acceleration: [f32; 4],
    pub linear_velocity: f32,
    pub linear_acceleration: f32,
    pub rotation_velocity: f32,
    pub rotation_acceleration: f32,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub jump_height: f32,
    pub z_limit: f32,
    pub rail_velocity: f32,
    pub rail_acceleration: f32,
}

/// Continuous-path speeds at power-up: mm/s, mm/s2, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[allow(missing_docs)]
pub struct CpDefaults {
    pub plan_acceleration: f32,
    pub junction_velocity: f32,
    /// Without effect, unless `real_time_track` is set: then the period of the path, ms.
    pub acceleration: f32,
    pub real_time_track: bool,
    /// Without effect, like the two below.
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub hold_rotation: bool,
}

/// Arc speeds at power-up: mm/s, deg/s, percent. The arm stores them, but moves at the
/// point-to-point speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[allow(missing_docs)]
pub struct ArcDefaults {
    pub linear_velocity: f32,
    pub linear_acceleration: f32,
    pub rotation_velocity: f32,
    pub rotation_acceleration: f32,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
}

impl PowerUp {
    /// Firmware 3.6.14. Model section 6 rates each value; those of the rail are choices.
    pub(crate) const MAGICIAN: Self = Self {
        joints: JointAngles::HOME,
        jog: JogDefaults {
            joint_velocity: [15.0, 15.0, 15.0, 30.0],
            joint_acceleration: [50.0; 4],
            coordinate_velocity: [60.0; 4],
            coordinate_acceleration: [60.0; 4],
            velocity_ratio: 50.0,
            acceleration_ratio: 50.0,
            rail_velocity: 100.0,
            rail_acceleration: 100.0,
        },
        ptp: PtpDefaults {
            joint_velocity: [200.0; 4],
            joint_acceleration: [200.0; 4],
            linear_velocity: 200.0,
            linear_acceleration: 200.0,
            rotation_velocity: 100.0,
            rotation_acceleration: 100.0,
            velocity_ratio: 50.0,
            acceleration_ratio: 50.0,
            jump_height: 20.0,
            z_limit: 100.0,
            rail_velocity: 100.0,
            rail_acceleration: 100.0,
        },
        cp: CpDefaults {
            plan_acceleration: 100.0,
            junction_velocity: 100.0,
            acceleration: 100.0,
            real_time_track: false,
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
            hold_rotation: false,
        },
        arc: ArcDefaults {
            linear_velocity: 200.0,
            linear_acceleration: 200.0,
            rotation_velocity: 200.0,
            rotation_acceleration: 200.0,
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
        },
    };

    /// Point-to-point speeds.
    #[must_use]
    pub const fn speeds(&self) -> Speeds {
        let ptp = &self.ptp;
        Speeds {
            joint_velocity: wide(ptp.joint_velocity),
            joint_acceleration: wide(ptp.joint_acceleration),
            linear_velocity: ptp.linear_velocity as f64,
            linear_acceleration: ptp.linear_acceleration as f64,
            rotation_velocity: ptp.rotation_velocity as f64,
            rotation_acceleration: ptp.rotation_acceleration as f64,
            velocity_ratio: ptp.velocity_ratio as f64,
            acceleration_ratio: ptp.acceleration_ratio as f64,
        }
    }

    /// Heights of jumps.
    #[must_use]
    pub const fn jump(&self) -> JumpHeights {
        JumpHeights::even(self.ptp.jump_height as f64, self.ptp.z_limit as f64)
    }
}

/// `f64::from` of each value, usable in constants.
const fn wide([a, b, c, d]: [f32; 4]) -> [f64; 4] {
    [a as f64, b as f64, c as f64, d as f64]
}

macro_rules! impl_magician_default {
    ($($part:ident: $type:ident),+) => {$(
        impl Default for $type {
            /// Firmware 3.6.14.
            fn default() -> Self {
                ArmModel::MAGICIAN.power_up.$part
            }
        }
    )+};
}

impl_magician_default! { jog: JogDefaults, ptp: PtpDefaults, cp: CpDefaults, arc: ArcDefaults }
