//! The part of a profile that is the [`ArmModel`]: which parts of it a file changes.

use magician_motion::{
    ArcDefaults, ArmModel, CpDefaults, JogDefaults, JointAngles, Limits, MotionLaw, PtpDefaults,
    Range,
};
use serde::{Deserialize, Deserializer, Serialize};

use super::Profile;
use super::sections::{LostStepDefaults, WifiDefaults};

/// Where the values come from that no file gives.
const BUILT_IN: ArmModel = ArmModel::MAGICIAN;

/// Which joint limits are in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LimitChoice {
    /// The controller's soft limits.
    Controller,
    /// The bounds that every arm keeps to for certain.
    Certain,
    /// The range that the vendor guarantees.
    Guaranteed,
}

/// The joint limits (model section 4).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LimitSets {
    /// Which set is in force.
    #[serde(rename = "use")]
    pub in_force: LimitChoice,
    /// The controller's soft limits.
    #[serde(deserialize_with = "controller")]
    pub controller: Limits,
    /// The bounds that every arm keeps to for certain.
    #[serde(deserialize_with = "certain")]
    pub certain: Limits,
    /// The range that the vendor guarantees.
    #[serde(deserialize_with = "guaranteed")]
    pub guaranteed: Limits,
}

/// How motions are computed (model section 7).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionRules {
    /// The period in which the controller changes the speed and then the place, s; 0 for continuous time.
    pub period: f64,
    /// What a jog of another axis does to the one under way.
    pub jog_axis_change: JogAxisChange,
    /// True if a segment of a continuous path that the arm cannot do is dropped without an alarm, and the index goes on.
    pub cp_drop_silently: bool,
}

/// What becomes of a jog when another axis is jogged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum JogAxisChange {
    /// The other axis takes over the speed with its sign, and then goes for its own.
    Carries,
    /// The jog under way slows down to rest first.
    Stops,
}

/// What a host reads before it has set anything (model section 6). Kept as the wire has it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Defaults {
    /// Jogging.
    pub jog: JogDefaults,
    /// Point to point.
    pub ptp: PtpDefaults,
    /// Continuous path.
    pub cp: CpDefaults,
    /// Arcs.
    pub arc: ArcDefaults,
    /// Lost steps.
    pub lost_step: LostStepDefaults,
    /// The Wi-Fi module.
    pub wifi: WifiDefaults,
}

/// The limits that a file changes.
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
    /// Reads the patch of a set, and what becomes of it.
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
    /// The set that is in force.
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
            jog_axis_change: JogAxisChange::Carries,
            cp_drop_silently: false,
        }
    }
}

impl Profile {
    /// The numbers by which this firmware plans motions.
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
