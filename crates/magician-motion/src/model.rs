//! The numbers of one firmware: its measures, limits, ceilings, homing, and what it knows at power-up.

use crate::{
    CpSpeeds, Geometry, JointAngles, JumpHeights, KinematicLimits, Limits, MotionLaw, Planner,
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
    /// The settings at power-up.
    pub power_up: PowerUp,
}

/// A higher setting counts as this when a motion is planned (model section 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ceilings {
    /// Velocity of J1 to J4, deg/s.
    pub joint_velocity: [f64; 4],
    /// Acceleration of J1 to J4, deg/s2.
    pub joint_acceleration: [f64; 4],
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

/// What motions start from before a host has set anything (model section 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerUp {
    /// The joints that are reported before homing, deg.
    pub joints: JointAngles,
    /// Speeds from point to point.
    pub speeds: Speeds,
    /// Speeds on arcs; no joint moves by itself there.
    pub arc: Speeds,
    /// Speeds of jogging.
    pub jog: Speeds,
    /// Continuous paths, with the period of this firmware.
    pub path: CpSpeeds,
    /// Heights of jumps.
    pub jump: JumpHeights,
    /// Speed on the sliding rail, mm/s and mm/s2.
    pub rail: KinematicLimits,
    /// Speed of jogging on the rail, mm/s and mm/s2.
    pub rail_jog: KinematicLimits,
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
            joint_acceleration: [300.0; 4],
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
        power_up: PowerUp {
            joints: JointAngles::HOME,
            speeds: Speeds {
                joint_velocity: [200.0; 4],
                joint_acceleration: [200.0; 4],
                linear_velocity: 200.0,
                linear_acceleration: 200.0,
                rotation_velocity: 100.0,
                rotation_acceleration: 100.0,
                velocity_ratio: 50.0,
                acceleration_ratio: 50.0,
            },
            arc: Speeds {
                joint_velocity: [200.0; 4],
                joint_acceleration: [200.0; 4],
                linear_velocity: 200.0,
                linear_acceleration: 200.0,
                rotation_velocity: 200.0,
                rotation_acceleration: 200.0,
                velocity_ratio: 100.0,
                acceleration_ratio: 100.0,
            },
            jog: Speeds {
                joint_velocity: [15.0, 15.0, 15.0, 30.0],
                joint_acceleration: [50.0; 4],
                linear_velocity: 60.0,
                linear_acceleration: 60.0,
                rotation_velocity: 60.0,
                rotation_acceleration: 60.0,
                velocity_ratio: 50.0,
                acceleration_ratio: 50.0,
            },
            path: CpSpeeds {
                plan_acceleration: 100.0,
                junction_velocity: 100.0,
                period_s: 0.02,
                real_time: false,
            },
            jump: JumpHeights::even(20.0, 100.0),
            rail: KinematicLimits {
                velocity: 100.0,
                acceleration: 100.0,
            },
            rail_jog: KinematicLimits {
                velocity: 100.0,
                acceleration: 100.0,
            },
        },
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

impl Default for ArmModel {
    /// Firmware 3.6.14.
    fn default() -> Self {
        Self::MAGICIAN
    }
}

impl Default for Ceilings {
    /// Those of firmware 3.6.14.
    fn default() -> Self {
        ArmModel::MAGICIAN.ceilings
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
