//! The part of a profile that is the [`ArmModel`]: how it is written in a file.

use magician_motion::{
    ArmModel, CpSpeeds, JointAngles, JumpHeights, KinematicLimits, Limits, MotionLaw, Range, Speeds,
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
    pub controller: LimitSet,
    /// The bounds that every arm keeps to for certain.
    #[serde(deserialize_with = "certain")]
    pub certain: LimitSet,
    /// The range that the vendor guarantees.
    #[serde(deserialize_with = "guaranteed")]
    pub guaranteed: LimitSet,
}

/// Ten bounds: least and greatest of each, deg.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitSet {
    /// Base.
    pub j1: [f64; 2],
    /// Rear arm.
    pub j2: [f64; 2],
    /// Forearm.
    pub j3: [f64; 2],
    /// End servo.
    pub j4: [f64; 2],
    /// The coupling of rear arm and forearm.
    pub j2_minus_j3: [f64; 2],
}

/// A higher setting counts as this when a motion is planned (model section 6). Raised ceilings make the arm faster: the
/// real one was never seen to be.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ceilings {
    /// Of J1 to J4, deg/s.
    pub joint_velocity: [f64; 4],
    /// Of every joint, deg/s2.
    pub joint_acceleration: f64,
    /// Along a path, mm/s.
    pub linear_velocity: f64,
    /// Along a path, mm/s2.
    pub linear_acceleration: f64,
    /// Of r along a path, deg/s.
    pub rotation_velocity: f64,
    /// Of r along a path, deg/s2.
    pub rotation_acceleration: f64,
}

/// Homing (model section 11).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Homing {
    /// The home point until a host sets one, deg.
    pub joints: [f64; 4],
    /// Speed of the joint move to the home point, deg/s; no ratio scales it.
    pub velocity: [f64; 4],
    /// Its acceleration, deg/s2.
    pub acceleration: [f64; 4],
    /// Where the base stands when the switch of J1 closes, deg.
    pub switch: f64,
    /// Speed of the base towards the switch and off it again, deg/s. Its acceleration is that of J1 above.
    pub search: f64,
    /// How far the base backs off from the switch, deg.
    pub back_off: f64,
    /// Speeds at which it creeps on, each for half of the way back, deg/s.
    pub creep: [f64; 2],
}

/// Continuous paths (model section 8).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Paths {
    /// The interpolation period that limits the speed at corners, s.
    pub period: f64,
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

/// Jog speeds: deg/s, mm/s, percent.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct JogDefaults {
    pub joint_velocity: [f32; 4],
    pub joint_acceleration: [f32; 4],
    pub coordinate_velocity: [f32; 4],
    pub coordinate_acceleration: [f32; 4],
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub rail_velocity: f32,
    pub rail_acceleration: f32,
}

/// Point-to-point speeds and jump heights: deg/s, mm/s, percent, mm.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
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

/// Continuous-path speeds: mm/s, mm/s2, percent.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct CpDefaults {
    pub plan_acceleration: f32,
    pub junction_velocity: f32,
    pub acceleration: f32,
    pub real_time_track: bool,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
    pub hold_rotation: bool,
}

/// Arc speeds: mm/s, deg/s, percent.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ArcDefaults {
    pub linear_velocity: f32,
    pub linear_acceleration: f32,
    pub rotation_velocity: f32,
    pub rotation_acceleration: f32,
    pub velocity_ratio: f32,
    pub acceleration_ratio: f32,
}

/// The same, some of it only.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct SomeLimits {
    j1: Option<[f64; 2]>,
    j2: Option<[f64; 2]>,
    j3: Option<[f64; 2]>,
    j4: Option<[f64; 2]>,
    j2_minus_j3: Option<[f64; 2]>,
}

impl SomeLimits {
    fn over(self, base: LimitSet) -> LimitSet {
        LimitSet {
            j1: self.j1.unwrap_or(base.j1),
            j2: self.j2.unwrap_or(base.j2),
            j3: self.j3.unwrap_or(base.j3),
            j4: self.j4.unwrap_or(base.j4),
            j2_minus_j3: self.j2_minus_j3.unwrap_or(base.j2_minus_j3),
        }
    }
}

fn controller<'de, D: Deserializer<'de>>(deserializer: D) -> Result<LimitSet, D::Error> {
    SomeLimits::deserialize(deserializer).map(|some| some.over(BUILT_IN.limits.into()))
}

fn certain<'de, D: Deserializer<'de>>(deserializer: D) -> Result<LimitSet, D::Error> {
    SomeLimits::deserialize(deserializer).map(|some| some.over(BUILT_IN.certain.into()))
}

fn guaranteed<'de, D: Deserializer<'de>>(deserializer: D) -> Result<LimitSet, D::Error> {
    SomeLimits::deserialize(deserializer).map(|some| some.over(BUILT_IN.guaranteed.into()))
}

impl Default for LimitSets {
    fn default() -> Self {
        Self {
            in_force: LimitChoice::Controller,
            controller: BUILT_IN.limits.into(),
            certain: BUILT_IN.certain.into(),
            guaranteed: BUILT_IN.guaranteed.into(),
        }
    }
}

impl From<Limits> for LimitSet {
    fn from(limits: Limits) -> Self {
        let pair = |range: Range| [range.min, range.max];
        Self {
            j1: pair(limits.j1),
            j2: pair(limits.j2),
            j3: pair(limits.j3),
            j4: pair(limits.j4),
            j2_minus_j3: pair(limits.j2_minus_j3),
        }
    }
}

impl From<&LimitSet> for Limits {
    fn from(set: &LimitSet) -> Self {
        let range = |[min, max]: [f64; 2]| Range::new(min, max);
        Self {
            j1: range(set.j1),
            j2: range(set.j2),
            j3: range(set.j3),
            j4: range(set.j4),
            j2_minus_j3: range(set.j2_minus_j3),
        }
    }
}

impl Default for Ceilings {
    fn default() -> Self {
        let magician_motion::Ceilings {
            joint_velocity,
            joint_acceleration: [joint_acceleration, ..],
            linear_velocity,
            linear_acceleration,
            rotation_velocity,
            rotation_acceleration,
        } = BUILT_IN.ceilings;
        Self {
            joint_velocity,
            joint_acceleration,
            linear_velocity,
            linear_acceleration,
            rotation_velocity,
            rotation_acceleration,
        }
    }
}

impl Default for Homing {
    fn default() -> Self {
        let magician_motion::Homing {
            joints,
            velocity,
            acceleration,
            switch,
            search,
            back_off,
            creep,
        } = BUILT_IN.homing;
        Self {
            joints: joints.to_array(),
            velocity,
            acceleration,
            switch,
            search,
            back_off,
            creep,
        }
    }
}

impl Default for Paths {
    fn default() -> Self {
        let path = BUILT_IN.power_up.path;
        Self {
            period: path.period_s,
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

impl Default for JogDefaults {
    fn default() -> Self {
        let (jog, rail) = (BUILT_IN.power_up.jog, BUILT_IN.power_up.rail_jog);
        let space = |along: f64, round: f64| [along, along, along, round].map(wire);
        Self {
            joint_velocity: jog.joint_velocity.map(wire),
            joint_acceleration: jog.joint_acceleration.map(wire),
            coordinate_velocity: space(jog.linear_velocity, jog.rotation_velocity),
            coordinate_acceleration: space(jog.linear_acceleration, jog.rotation_acceleration),
            velocity_ratio: wire(jog.velocity_ratio),
            acceleration_ratio: wire(jog.acceleration_ratio),
            rail_velocity: wire(rail.velocity),
            rail_acceleration: wire(rail.acceleration),
        }
    }
}

impl Default for PtpDefaults {
    fn default() -> Self {
        let magician_motion::PowerUp {
            speeds, jump, rail, ..
        } = BUILT_IN.power_up;
        Self {
            joint_velocity: speeds.joint_velocity.map(wire),
            joint_acceleration: speeds.joint_acceleration.map(wire),
            linear_velocity: wire(speeds.linear_velocity),
            linear_acceleration: wire(speeds.linear_acceleration),
            rotation_velocity: wire(speeds.rotation_velocity),
            rotation_acceleration: wire(speeds.rotation_acceleration),
            velocity_ratio: wire(speeds.velocity_ratio),
            acceleration_ratio: wire(speeds.acceleration_ratio),
            jump_height: wire(jump.start),
            z_limit: wire(jump.z_limit),
            rail_velocity: wire(rail.velocity),
            rail_acceleration: wire(rail.acceleration),
        }
    }
}

impl Default for CpDefaults {
    fn default() -> Self {
        let path = BUILT_IN.power_up.path;
        Self {
            plan_acceleration: wire(path.plan_acceleration),
            junction_velocity: wire(path.junction_velocity),
            acceleration: 100.0, // VL 6, without effect
            real_time_track: path.real_time,
            velocity_ratio: 100.0,     // G, without effect
            acceleration_ratio: 100.0, // G, without effect
            hold_rotation: false,      // VL 8
        }
    }
}

impl Default for ArcDefaults {
    fn default() -> Self {
        let arc = BUILT_IN.power_up.arc;
        Self {
            linear_velocity: wire(arc.linear_velocity),
            linear_acceleration: wire(arc.linear_acceleration),
            rotation_velocity: wire(arc.rotation_velocity),
            rotation_acceleration: wire(arc.rotation_acceleration),
            velocity_ratio: wire(arc.velocity_ratio),
            acceleration_ratio: wire(arc.acceleration_ratio),
        }
    }
}

/// As the wire has it.
fn wire(value: f64) -> f32 {
    value as f32
}

impl Profile {
    /// The numbers by which this firmware plans motions.
    #[must_use]
    pub fn arm_model(&self) -> ArmModel {
        let (ceilings, home) = (&self.ceilings, &self.home);
        ArmModel {
            geometry: BUILT_IN.geometry(self.power_up.tool),
            limits: match self.limits.in_force {
                LimitChoice::Controller => (&self.limits.controller).into(),
                LimitChoice::Certain => (&self.limits.certain).into(),
                LimitChoice::Guaranteed => (&self.limits.guaranteed).into(),
            },
            certain: (&self.limits.certain).into(),
            guaranteed: (&self.limits.guaranteed).into(),
            ceilings: magician_motion::Ceilings {
                joint_velocity: ceilings.joint_velocity,
                joint_acceleration: [ceilings.joint_acceleration; 4],
                linear_velocity: ceilings.linear_velocity,
                linear_acceleration: ceilings.linear_acceleration,
                rotation_velocity: ceilings.rotation_velocity,
                rotation_acceleration: ceilings.rotation_acceleration,
            },
            law: MotionLaw::with_period_us((self.motion.period * 1e6).round() as u32),
            homing: magician_motion::Homing {
                joints: JointAngles::from(home.joints),
                velocity: home.velocity,
                acceleration: home.acceleration,
                switch: home.switch,
                search: home.search,
                back_off: home.back_off,
                creep: home.creep,
            },
            power_up: self.motion_at_power_up(),
        }
    }

    fn motion_at_power_up(&self) -> magician_motion::PowerUp {
        let Defaults {
            jog, ptp, cp, arc, ..
        } = &self.defaults;
        let speeds = Speeds {
            joint_velocity: ptp.joint_velocity.map(f64::from),
            joint_acceleration: ptp.joint_acceleration.map(f64::from),
            linear_velocity: ptp.linear_velocity.into(),
            linear_acceleration: ptp.linear_acceleration.into(),
            rotation_velocity: ptp.rotation_velocity.into(),
            rotation_acceleration: ptp.rotation_acceleration.into(),
            velocity_ratio: ptp.velocity_ratio.into(),
            acceleration_ratio: ptp.acceleration_ratio.into(),
        };
        let [along, _, _, round] = jog.coordinate_velocity.map(f64::from);
        let [along_acceleration, _, _, round_acceleration] =
            jog.coordinate_acceleration.map(f64::from);
        let rates = |velocity: f32, acceleration: f32| KinematicLimits {
            velocity: velocity.into(),
            acceleration: acceleration.into(),
        };
        magician_motion::PowerUp {
            joints: JointAngles::from(self.power_up.joints),
            speeds,
            arc: Speeds {
                linear_velocity: arc.linear_velocity.into(),
                linear_acceleration: arc.linear_acceleration.into(),
                rotation_velocity: arc.rotation_velocity.into(),
                rotation_acceleration: arc.rotation_acceleration.into(),
                velocity_ratio: arc.velocity_ratio.into(),
                acceleration_ratio: arc.acceleration_ratio.into(),
                ..speeds
            },
            jog: Speeds {
                joint_velocity: jog.joint_velocity.map(f64::from),
                joint_acceleration: jog.joint_acceleration.map(f64::from),
                linear_velocity: along,
                linear_acceleration: along_acceleration,
                rotation_velocity: round,
                rotation_acceleration: round_acceleration,
                velocity_ratio: jog.velocity_ratio.into(),
                acceleration_ratio: jog.acceleration_ratio.into(),
            },
            path: CpSpeeds {
                plan_acceleration: cp.plan_acceleration.into(),
                junction_velocity: cp.junction_velocity.into(),
                period_s: self.path.period,
                real_time: cp.real_time_track,
            },
            jump: JumpHeights::even(ptp.jump_height.into(), ptp.z_limit.into()),
            rail: rates(ptp.rail_velocity, ptp.rail_acceleration),
            rail_jog: rates(jog.rail_velocity, jog.rail_acceleration),
        }
    }
}
