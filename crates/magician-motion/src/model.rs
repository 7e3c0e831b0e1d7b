//! The numbers of one firmware: geometry, limits, ceilings, homing and settings at power-up.

use crate::{
    CpSpeeds, Geometry, JogAxis, JointAngles, KinematicLimits, Limits, MotionLaw, Planner, PowerUp,
    Range, Speeds, ToolBias,
};

/// The numbers by which one firmware plans motions. The virtual arm, the host's checks before a
/// motion and the computation of reach use the same value.
///
/// A different firmware is described by changing single values:
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
    /// Links, and the tool bias at power-up.
    pub geometry: Geometry,
    /// Soft limits at which the controller stops a joint.
    pub limits: Limits,
    /// Joint limits that every arm is certain to reach. [`limits`](Self::limits) may be wider
    /// because some arms were seen to go further; a check warns about targets in between.
    pub certain: Limits,
    /// Joint limits guaranteed by the vendor: a stricter alternative.
    pub guaranteed: Limits,
    /// Highest speeds and accelerations with which a motion is planned.
    pub ceilings: Ceilings,
    /// Law of motion: periods or continuous time.
    pub law: MotionLaw,
    /// Homing sequence.
    pub homing: Homing,
    /// Continuous paths.
    pub path: Paths,
    /// The sliding rail, if the arm stands on one.
    pub rail: Rail,
    /// Settings at power-up.
    pub power_up: PowerUp,
}

/// Ceilings of speeds and accelerations. A higher setting counts as its ceiling when a motion is
/// planned (model section 6).
///
/// Raising a ceiling makes the virtual arm faster; no real arm was seen to exceed these.
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

/// Homing sequence: the base turns to its switch, backs off and creeps back, then all joints move
/// to the home point (model section 11).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Homing {
    /// Home point before a host sets one, deg.
    pub joints: JointAngles,
    /// Velocity of the move to the home point, deg/s. Ratios do not apply.
    pub velocity: [f64; 4],
    /// Acceleration of the move to the home point, deg/s2.
    pub acceleration: [f64; 4],
    /// Angle of the base at which its switch closes, deg.
    pub switch: f64,
    /// Velocity of the base towards the switch and off it again, deg/s. Its acceleration is that of
    /// J1 above.
    pub search: f64,
    /// Angle by which the base backs off from the switch, deg.
    pub back_off: f64,
    /// Velocities at which the base creeps back, each for half of the way, deg/s.
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
    /// Interpolation period that limits the speed at corners, s.
    pub period: f64,
}

/// The sliding rail (model section 12). The carriage is at 0 mm after homing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Rail {
    /// Travel of the carriage, mm; above 0.
    pub length: f64,
    /// Velocity of the carriage during homing, mm/s. Ratios do not apply.
    pub home_velocity: f64,
    /// Acceleration of the carriage during homing, mm/s2.
    pub home_acceleration: f64,
}

impl ArmModel {
    /// A Dobot Magician with firmware 3.6.14. Model sections 1, 4, 6, 8 and 11 rate each number by
    /// its source.
    pub const MAGICIAN: Self = Self {
        geometry: Geometry::magician(ToolBias::SUCTION),
        limits: Limits {
            j1: Range::new(-135.0, 135.0),
            // Half a degree below the lowest target of five public programs (-13.1, model section
            // 4). No mechanical stop was found by driving into it.
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
            // From the user guide; an older text lets J3 go to 95. The guide has no range for
            // J2 - J3, so the soft limit is used.
            j1: Range::new(-90.0, 90.0),
            j2: Range::new(0.0, 85.0),
            j3: Range::new(-10.0, 90.0),
            j4: Range::new(-90.0, 90.0),
            j2_minus_j3: Range::new(-70.0, 55.0),
        },
        ceilings: Ceilings {
            // The ratings with 250 g of payload (user guide), and 300 deg/s2, 300 mm/s and 400
            // mm/s2 from a third party's driver (model section 6).
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
            // -135 and 0.5 are choices: no source gives the switch or how far the base backs off
            // (model section 15a).
            switch: -135.0,
            search: 20.0,
            back_off: 0.5,
            creep: [1.0, 0.5],
        },
        path: Paths { period: 0.02 },
        rail: Rail {
            // The travel is the vendor's; both speeds are choices (model section 15a).
            length: 1000.0,
            home_velocity: 100.0,
            home_acceleration: 100.0,
        },
        power_up: PowerUp::MAGICIAN,
    };

    /// Returns the geometry with another tool bias.
    #[must_use]
    pub const fn geometry(&self, tool: ToolBias) -> Geometry {
        Geometry {
            rear_arm: self.geometry.rear_arm,
            forearm: self.geometry.forearm,
            tool,
        }
    }

    /// Returns this model with the given lower limit of J2, deg, as found for a single arm. A value
    /// above that of [`certain`](Self::certain) narrows both limits.
    #[must_use]
    pub const fn with_lowest_j2(mut self, degrees: f64) -> Self {
        self.limits.j2.min = degrees;
        self.certain.j2.min = degrees;
        self
    }

    /// Returns a planner for this tool bias and these speeds.
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
    /// Settings of continuous paths at power-up.
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
    /// Ceilings of a jog axis: those of its joint, or of a straight line.
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
    /// Ceilings of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.ceilings
    }
}

impl Default for Homing {
    /// Homing of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.homing
    }
}

impl Default for Paths {
    /// Paths of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.path
    }
}

impl Default for Rail {
    /// The vendor's rail.
    fn default() -> Self {
        ArmModel::MAGICIAN.rail
    }
}

impl Homing {
    /// Speeds of the move to the home point.
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
