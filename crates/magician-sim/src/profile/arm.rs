//! The part of a profile that becomes an [`ArmModel`].

use magician_motion::{
    ArcDefaults, ArmModel, CpDefaults, JogDefaults, JointAngles, Limits, MotionLaw, PtpDefaults,
    Range,
};
use serde::{Deserialize, Deserializer, Serialize};

use super::Profile;
use super::sections::{LostStepDefaults, WifiDefaults};

/// Values for everything that a file leaves out.
const BUILT_IN: ArmModel = ArmModel::MAGICIAN;

/// Set of joint limits in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LimitChoice {
    /// Soft limits of the controller.
    Controller,
    /// Limits that every arm is certain to reach.
    Certain,
    /// Range guaranteed by the vendor.
    Guaranteed,
}

/// Joint limits (model section 4).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LimitSets {
    /// Set in force.
    #[serde(rename = "use")]
    pub in_force: LimitChoice,
    /// Soft limits of the controller.
    #[serde(deserialize_with = "controller")]
    pub controller: Limits,
    /// Limits that every arm is certain to reach.
    #[serde(deserialize_with = "certain")]
    pub certain: Limits,
    /// Range guaranteed by the vendor.
    #[serde(deserialize_with = "guaranteed")]
    pub guaranteed: Limits,
}

/// Law of motion (model section 7).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionRules {
    /// Control period, s; 0 for continuous time. Once per period the controller changes the speed
    /// and then the position.
    pub period: f64,
    /// Effect of a jog of another axis on the running jog.
    pub jog_axis_change: JogAxisChange,
    /// True if an impossible segment of a continuous path is dropped without an alarm and the queue
    /// index still advances (model section 8).
    pub cp_drop_silently: bool,
}

/// Effect of a jog of another axis on the running jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum JogAxisChange {
    /// The new axis takes over the signed speed, then ramps to its own (model section 10).
    Carries,
    /// The running jog slows down to rest first.
    Stops,
}

/// Settings that a host reads before it has set any (model section 6), in the precision of the
/// protocol.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Defaults {
    /// Jogs.
    pub jog: JogDefaults,
    /// Point-to-point moves.
    pub ptp: PtpDefaults,
    /// Continuous paths.
    pub cp: CpDefaults,
    /// Arcs.
    pub arc: ArcDefaults,
    /// Lost steps.
    pub lost_step: LostStepDefaults,
    /// Wi-Fi module.
    pub wifi: WifiDefaults,
}

/// Joint limits given by a file.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct LimitsPatch {
    j1: Option<Range>,
    j2: Option<Range>,
    j3: Option<Range>,
    j4: Option<Range>,
    j2_minus_j3: Option<Range>,
}

impl LimitsPatch {
    /// Reads a patch of joint limits and applies it to `base`.
    fn over<'de, D: Deserializer<'de>>(base: Limits, from: D) -> Result<Limits, D::Error> {
        let patch = Self::deserialize(from)?;
        Ok(Limits {
            j1: patch.j1.unwrap_or(base.j1),
            j2: patch.j2.unwrap_or(base.j2),
            j3: patch.j3.unwrap_or(base.j3),
            j4: patch.j4.unwrap_or(base.j4),
            j2_minus_j3: patch.j2_minus_j3.unwrap_or(base.j2_minus_j3),
        })
    }
}

fn controller<'de, D: Deserializer<'de>>(from: D) -> Result<Limits, D::Error> {
    LimitsPatch::over(BUILT_IN.limits, from)
}

fn certain<'de, D: Deserializer<'de>>(from: D) -> Result<Limits, D::Error> {
    LimitsPatch::over(BUILT_IN.certain, from)
}

fn guaranteed<'de, D: Deserializer<'de>>(from: D) -> Result<Limits, D::Error> {
    LimitsPatch::over(BUILT_IN.guaranteed, from)
}

impl LimitSets {
    /// Limits of the set in force.
    fn limits(&self) -> Limits {
        match self.in_force {
            LimitChoice::Controller => self.controller,
            LimitChoice::Certain => self.certain,
            LimitChoice::Guaranteed => self.guaranteed,
        }
    }
}

impl Default for LimitSets {
    fn default() -> Self {
        Self {
            in_force: LimitChoice::Controller,
            controller: BUILT_IN.limits,
            certain: BUILT_IN.certain,
            guaranteed: BUILT_IN.guaranteed,
        }
    }
}

impl Default for MotionRules {
    fn default() -> Self {
        Self {
            period: f64::from(BUILT_IN.law.period_us()) / 1e6,
            // Measured: a recorded arm carries its speed over to the new axis (model section 10).
            jog_axis_change: JogAxisChange::Carries,
            // One arm was seen to drop segments silently. The vendor's code for the sibling arm
            // (VL) raises an alarm.
            cp_drop_silently: false,
        }
    }
}

impl Profile {
    /// Numbers with which this firmware plans motions.
    #[must_use]
    pub fn arm_model(&self) -> ArmModel {
        let Defaults {
            jog, ptp, cp, arc, ..
        } = &self.defaults;
        ArmModel {
            geometry: BUILT_IN.geometry(self.power_up.tool),
            limits: self.limits.limits(),
            certain: self.limits.certain,
            guaranteed: self.limits.guaranteed,
            ceilings: self.ceilings,
            law: MotionLaw::with_period_us((self.motion.period * 1e6).round() as u32),
            homing: self.home,
            path: self.path,
            rail: self.rail,
            power_up: magician_motion::PowerUp {
                joints: JointAngles::from(self.power_up.joints),
                jog: *jog,
                ptp: *ptp,
                cp: *cp,
                arc: *arc,
            },
        }
    }
}
