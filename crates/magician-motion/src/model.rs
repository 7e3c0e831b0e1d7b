//! The numbers of one firmware: its measures, limits, ceilings, homing, and what it knows at power-up.

use crate::{
    CpSpeeds, Geometry, JogAxis, JointAngles, KinematicLimits, Limits, MotionLaw, Planner, PowerUp,
    Range, Speeds, ToolBias,
};

/// The numbers by which one firmware plans motions. Simulator, check and reach take the same value.
///
/// A firmware that differs is the known one with other values:
///
/// ```
/// use magician_motion::{ArmModel, Speeds};
///
/// let mut faster = ArmModel::MAGICIAN;
/// faster.ceilings.linear_velocity = 500.0;
/// let planner = faster.planner(faster.geometry.tool, Speeds::default());
/// assert_eq!(planner.ceilings.linear_velocity, 500.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmModel {
    /// The links, and the tool bias in force at power-up.
    pub geometry: Geometry,
    /// The joint limits at which the controller stops.
    pub limits: Limits,
    /// The joint limits that every arm keeps to for certain. Where [`limits`](Self::limits) are wider, arms were seen to go
    /// there, and another one may not: a check warns.
    pub certain: Limits,
    /// The joint limits that the vendor guarantees: a stricter choice.
    pub guaranteed: Limits,
    /// The highest speeds and accelerations that a motion is planned with.
    pub ceilings: Ceilings,
    /// How motions are computed.
    pub law: MotionLaw,
    /// Homing.
    pub homing: Homing,
    /// Continuous paths.
    pub path: Paths,
    /// The sliding rail, for an arm that stands on one.
    pub rail: Rail,
    /// The settings at power-up.
    pub power_up: PowerUp,
}

/// The ceiling of each speed: what slows a move that is set faster. A higher setting counts as its ceiling when a motion
/// is planned (model section 6). Raised ceilings make the arm faster: the real one was never seen to be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Ceilings {
    /// Velocity of J1 to J4, deg/s.
    pub joint_velocity: [f64; 4],
    /// Acceleration of every joint, deg/s2.
    pub joint_acceleration: f64,
    /// Velocity along a path, mm/s.
    pub linear_velocity: f64,
    /// Acceleration along a path, mm/s2.
    pub linear_acceleration: f64,
    /// Velocity of r along a path, deg/s.
    pub rotation_velocity: f64,
    /// Acceleration of r along a path, deg/s2.
    pub rotation_acceleration: f64,
}

/// Homing: the base turns to its switch, backs off, creeps back, then all joints go to the home point (model section 11).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Homing {
    /// The home point until a host sets one, deg.
    pub joints: JointAngles,
    /// Velocity of the move to the home point, deg/s; no ratio scales it.
    pub velocity: [f64; 4],
    /// Its acceleration, deg/s2.
    pub acceleration: [f64; 4],
    /// The angle of the base at which its switch closes, deg.
    pub switch: f64,
    /// Velocity of the base towards the switch and off it again, deg/s; its acceleration is that of J1 above.
    pub search: f64,
    /// How far the base backs off from the switch, deg.
    pub back_off: f64,
    /// Velocities at which it creeps back, each for half of the way, deg/s.
    pub creep: [f64; 2],
}

/// Continuous paths (model section 8).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Paths {
    /// The interpolation period that limits the speed at corners, s.
    pub period: f64,
}

/// The sliding rail (model section 12). Its carriage is at 0 mm after homing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Rail {
    /// How far the carriage can go, mm; above 0.
    pub length: f64,
    /// How fast it homes, mm/s; no ratio scales it.
    pub home_velocity: f64,
    /// Its acceleration when it homes, mm/s2.
    pub home_acceleration: f64,
}

impl ArmModel {
    /// A Dobot Magician with firmware 3.6.14 (model sections 1, 4, 6, 8 and 11, which say how sure each number is).
    pub const MAGICIAN: Self = Self {
        geometry: Geometry::magician(ToolBias::SUCTION),
        limits: Limits {
            j1: Range::new(-135.0, 135.0),
            // Half a degree beyond the lowest that a public program asks for; no stop was found by driving into it.
            j2: Range::new(-13.5, 90.0),
            j3: Range::new(-15.0, 90.0),
            j4: Range::new(-150.0, 150.0),
            j2_minus_j3: Range::new(-70.0, 55.0),
        },
        certain: Limits {
            j1: Range::new(-135.0, 135.0),
            j2: Range::new(-5.0, 90.0),
            j3: Range::new(-15.0, 90.0),
            j4: Range::new(-150.0, 150.0),
            j2_minus_j3: Range::new(-70.0, 55.0),
        },
        guaranteed: Limits {
            j1: Range::new(-90.0, 90.0),
            j2: Range::new(0.0, 85.0),
            j3: Range::new(-10.0, 90.0),
            j4: Range::new(-90.0, 90.0),
            j2_minus_j3: Range::new(-70.0, 55.0),
        },
        ceilings: Ceilings {
            joint_velocity: [320.0, 320.0, 320.0, 480.0],
            joint_acceleration: 300.0,
            linear_velocity: 300.0,
            linear_acceleration: 400.0,
            rotation_velocity: 480.0,
            rotation_acceleration: 300.0,
        },
        law: MotionLaw::MAGICIAN,
        homing: Homing {
            joints: JointAngles::HOME,
            velocity: [30.0, 50.0, 50.0, 50.0],
            acceleration: [30.0, 50.0, 50.0, 50.0],
            switch: -135.0,
            search: 20.0,
            back_off: 0.5,
            creep: [1.0, 0.5],
        },
        path: Paths { period: 0.02 },
        rail: Rail {
            length: 1000.0,
            home_velocity: 100.0,
            home_acceleration: 100.0,
        },
        power_up: PowerUp::MAGICIAN,
    };

    /// The measures with this tool bias in force.
    #[must_use]
    pub const fn geometry(&self, tool: ToolBias) -> Geometry {
        Geometry {
            rear_arm: self.geometry.rear_arm,
            forearm: self.geometry.forearm,
            tool,
        }
    }

    /// The same arm with this lower limit of J2, deg: what is known of a single arm. Above that of
    /// [`certain`](Self::certain) it narrows both.
    #[must_use]
    pub const fn with_lowest_j2(mut self, degrees: f64) -> Self {
        self.limits.j2.min = degrees;
        self.certain.j2.min = degrees;
        self
    }

    /// Plans motions with this tool bias, at these speeds.
    #[must_use]
    pub const fn planner(&self, tool: ToolBias, speeds: Speeds) -> Planner {
        Planner {
            geometry: self.geometry(tool),
            limits: self.limits,
            ceilings: self.ceilings,
            law: self.law,
            speeds,
        }
    }
}

impl ArmModel {
    /// The settings of continuous paths at power-up.
    #[must_use]
    pub fn cp_speeds(&self) -> CpSpeeds {
        let cp = &self.power_up.cp;
        CpSpeeds {
            plan_acceleration: cp.plan_acceleration.into(),
            junction_velocity: cp.junction_velocity.into(),
            period_s: self.path.period,
            real_time: cp.real_time_track,
        }
    }
}

impl Default for ArmModel {
    /// Firmware 3.6.14.
    fn default() -> Self {
        Self::MAGICIAN
    }
}

impl Ceilings {
    /// The ceilings of a jog's axis: of the joint that it turns, or of the line that it goes along.
    #[must_use]
    pub const fn of_axis(&self, axis: JogAxis) -> KinematicLimits {
        let [j1, j2, j3, j4] = self.joint_velocity;
        let (velocity, acceleration) = match axis {
            JogAxis::J1 => (j1, self.joint_acceleration),
            JogAxis::J2 => (j2, self.joint_acceleration),
            JogAxis::J3 => (j3, self.joint_acceleration),
            JogAxis::J4 => (j4, self.joint_acceleration),
            JogAxis::X | JogAxis::Y | JogAxis::Z => {
                (self.linear_velocity, self.linear_acceleration)
            }
            JogAxis::R => (self.rotation_velocity, self.rotation_acceleration),
        };
        KinematicLimits {
            velocity,
            acceleration,
        }
    }
}

impl Default for Ceilings {
    /// Those of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.ceilings
    }
}

impl Default for Homing {
    /// That of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.homing
    }
}

impl Default for Paths {
    /// Those of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.path
    }
}

impl Default for Rail {
    /// That of the vendor.
    fn default() -> Self {
        ArmModel::MAGICIAN.rail
    }
}

impl Homing {
    /// The speeds of the move to the home point.
    #[must_use]
    pub fn speeds(&self) -> Speeds {
        Speeds {
            joint_velocity: self.velocity,
            joint_acceleration: self.acceleration,
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
            ..Speeds::default()
        }
    }
}
