//! Jogging: one axis moves until the host stops it or a limit does (model section 10).

use crate::axis_motion::AxisMotion;
use crate::joint_segment::JointSegment;
use crate::line_segment::LineSegment;
use crate::move_segment::MoveSegment;
use crate::velocity_profile::{KinematicLimits, VelocityProfile};
use crate::{
    ArmState, Ceilings, Crossing, MotionError, Plan, Planner, Pose, Range, SpeedQuantity, Speeds,
    Trajectory,
};

/// Axis that a jog moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogAxis {
    /// The base.
    J1,
    /// The rear arm.
    J2,
    /// The forearm.
    J3,
    /// The end servo.
    J4,
    /// The tool along x, r kept.
    X,
    /// The tool along y, r kept.
    Y,
    /// The tool along z, r kept.
    Z,
    /// The tool's rotation: joint 4 alone.
    R,
}

/// A jog: axis and direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Jog {
    /// Axis that moves.
    pub axis: JogAxis,
    /// True if the value of the axis grows.
    pub positive: bool,
}

impl Jog {
    /// Returns the jog of an axis by number, from 0: J1 to J4, or x, y, z and r. `None` for any
    /// other number.
    #[must_use]
    pub fn numbered(is_joint: bool, number: usize, positive: bool) -> Option<Self> {
        let axes = if is_joint {
            [JogAxis::J1, JogAxis::J2, JogAxis::J3, JogAxis::J4]
        } else {
            [JogAxis::X, JogAxis::Y, JogAxis::Z, JogAxis::R]
        };
        let axis = *axes.get(number)?;
        Some(Self { axis, positive })
    }
}

/// Length of a joint jog without a limit in its way, degrees.
const UNLIMITED_TRAVEL: f64 = 1e9;
/// Highest entry speed accepted, mm/s or deg/s. Far above any speed of the arm; it keeps lengths
/// finite.
const MAX_ENTRY_SPEED: f64 = 1e6;
/// Extra length beyond a limit, mm or degrees, so that the limit ends the motion before its length
/// does.
const LIMIT_OVERSHOOT: f64 = 1.0;
/// Distance from a limit at which the arm counts as standing at it, mm or degrees.
const AT_LIMIT: f64 = 1e-6;

impl JogAxis {
    /// Index from 0 of the joint that moves alone; `None` for a straight line.
    fn joint(self) -> Option<usize> {
        match self {
            Self::J1 => Some(0),
            Self::J2 => Some(1),
            Self::J3 => Some(2),
            Self::J4 | Self::R => Some(3),
            Self::X | Self::Y | Self::Z => None,
        }
    }

    /// Value of this axis, mm or degrees.
    #[must_use]
    pub fn value(self, state: &ArmState) -> f64 {
        match self {
            Self::J1 => state.joints.j1,
            Self::J2 => state.joints.j2,
            Self::J3 => state.joints.j3,
            Self::J4 => state.joints.j4,
            Self::X => state.pose.x,
            Self::Y => state.pose.y,
            Self::Z => state.pose.z,
            // A jog of R turns J4 alone (model section 10).
            Self::R => state.joints.j4,
        }
    }

    /// Returns the pose moved by `by` mm along a straight axis.
    fn moved(self, pose: &Pose, by: f64) -> Pose {
        let mut moved = *pose;
        match self {
            Self::X => moved.x += by,
            Self::Y => moved.y += by,
            Self::Z => moved.z += by,
            Self::J1 | Self::J2 | Self::J3 | Self::J4 | Self::R => {}
        }
        moved
    }

    fn velocity_quantity(self) -> SpeedQuantity {
        match self {
            Self::J1 => SpeedQuantity::JointVelocity(1),
            Self::J2 => SpeedQuantity::JointVelocity(2),
            Self::J3 => SpeedQuantity::JointVelocity(3),
            Self::J4 => SpeedQuantity::JointVelocity(4),
            Self::X | Self::Y | Self::Z => SpeedQuantity::LinearVelocity,
            Self::R => SpeedQuantity::RotationVelocity,
        }
    }
}

impl Speeds {
    /// Velocity and acceleration of a jog at these settings: each value up to its ceiling, times
    /// its ratio up to 100 % (model section 6).
    ///
    /// Pass an acceleration ratio of 100: the arm does not scale the acceleration of jogs.
    ///
    /// # Errors
    ///
    /// [`MotionError::Speed`] for a value that is NaN, zero or negative.
    pub fn jog(&self, axis: JogAxis, ceilings: &Ceilings) -> Result<KinematicLimits, MotionError> {
        match axis.joint() {
            Some(_) if axis == JogAxis::R => self.rotation(ceilings),
            Some(joint) => self.joint(joint, ceilings),
            None => self.linear(ceilings),
        }
    }
}

impl Ceilings {
    /// Limits the rates of a jog to the ceilings.
    fn jog(&self, axis: JogAxis, rates: KinematicLimits) -> Result<KinematicLimits, MotionError> {
        match axis.joint() {
            Some(_) if axis == JogAxis::R => self.rotation(rates),
            Some(joint) => self.joint(joint, rates),
            None => self.linear(rates),
        }
    }
}

impl Planner {
    /// Plans a jog that runs until a limit stops it; the limit is the plan's
    /// [`crossing`](Plan::crossing).
    ///
    /// The jog begins with the velocity `entry` of its axis (0 at rest; mm/s or deg/s, signed) and
    /// ramps to `rates.velocity`. If the entry points the other way, it first comes to rest. A jog
    /// that starts at or beyond a limit and leads further out takes no time. A joint without a
    /// limit turns by 1e9 degrees. The rates are limited to the ceilings; [`Speeds::jog`] computes
    /// them from settings.
    ///
    /// ```
    /// use magician_motion::{ArmModel, ArmState, Jog, JogAxis, JointAngles, ToolBias};
    ///
    /// let model = ArmModel::MAGICIAN;
    /// let planner = model.planner(ToolBias::NONE, model.power_up.speeds());
    /// let home = ArmState::at_joints(&planner.geometry, &JointAngles::HOME);
    /// let up = Jog { axis: JogAxis::Z, positive: true };
    /// let rates = planner.speeds.jog(up.axis, &planner.ceilings)?;
    /// let jog = planner.jog(&home, up, rates, 0.0)?;
    /// assert!(jog.crossing.is_some()); // it would run into a limit
    ///
    /// // The key is released after half a second.
    /// let stop = planner.jog_stop(&jog.trajectory, 500_000, rates.acceleration);
    /// assert!(stop.trajectory.end().pose.z > home.pose.z && stop.crossing.is_none());
    /// # Ok::<(), magician_motion::MotionError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`MotionError::Speed`] for rates that are NaN, zero or negative, and for an entry faster
    /// than any arm; [`MotionError::Limit`] for a straight jog from joint angles that inverse
    /// kinematics cannot reproduce.
    pub fn jog(
        &self,
        from: &ArmState,
        jog: Jog,
        rates: KinematicLimits,
        entry: f64,
    ) -> Result<Plan, MotionError> {
        let rates = self.ceilings.jog(jog.axis, rates)?;
        if libm::fabs(entry) > MAX_ENTRY_SPEED || entry.is_nan() {
            return Err(MotionError::Speed {
                quantity: jog.axis.velocity_quantity(),
                value: entry,
            });
        }
        if jog.axis.joint().is_none() {
            from.check_invertible(&self.geometry)?;
        }
        let sign = if jog.positive { 1.0 } else { -1.0 };
        let forwards = sign * entry;
        let (turn, remaining_speed) = if forwards < 0.0 {
            self.law.reversal(-forwards, rates.acceleration)
        } else {
            (VelocityProfile::default(), -forwards)
        };
        let braking =
            (turn.duration() > 0.0).then(|| self.jog_segment(from, jog.axis, -sign, turn));
        let start = braking.map_or(*from, |segment| segment.end());
        let forwards = -remaining_speed;
        // Room to slow down from an entry above the target velocity. Otherwise the end of the
        // length would force harder braking.
        let slowing = 0.5 * forwards * forwards / rates.acceleration;
        let length = self.travel_beyond_limits(&start, jog.axis, sign) + slowing;
        let profile = self.law.run(length, forwards, &rates);
        let running = self.jog_segment(&start, jog.axis, sign, profile);
        let whole = self.trajectory(from, braking.into_iter().chain([running]));
        let plan = Plan::within(whole, &self.limits);
        // At rest at a limit, the profile would still produce a microscopic motion. The arm refuses
        // such a jog (model section 10).
        Ok(match plan.crossing {
            Some(crossing) if entry == 0.0 && crossing.progress * length < AT_LIMIT => Plan {
                trajectory: Trajectory::at_rest(&self.geometry, from),
                crossing: Some(Crossing {
                    at_us: 0,
                    progress: 0.0,
                    ..crossing
                }),
            },
            _ => plan,
        })
    }

    /// Plans the stop of a jog at a time within it, along its own path at `deceleration` (mm/s2 or
    /// deg/s2).
    ///
    /// A limit may stop it earlier. If the deceleration is not positive, the arm stops at once. A
    /// motion other than a jog stops as in [`brake`](Self::brake), with this deceleration for every
    /// joint. The geometry is that of the jog.
    #[must_use]
    pub fn jog_stop(&self, jog: &Trajectory, at_us: u64, deceleration: f64) -> Plan {
        let from = jog.sample(at_us);
        let own = Self {
            geometry: *jog.geometry(),
            ..*self
        };
        let trajectory = match jog.under_way(at_us) {
            Some((segment, t)) if deceleration > 0.0 => match segment {
                MoveSegment::Joints(segment) => {
                    let axes = segment
                        .axes
                        .map(|axis| AxisMotion::stopping(own.law, axis.velocity(t), deceleration));
                    let segment = JointSegment::following(&own.geometry, &from, axes);
                    own.trajectory(&from, [MoveSegment::Joints(segment)])
                }
                MoveSegment::Line(segment) if segment.turning.length() == 0.0 => {
                    let rate = segment.tool_rate_at(t);
                    own.line_stop(&from, &rate, deceleration)
                }
                // A move was under way and not a jog: its path may curve, so stop joint by joint.
                _ => jog.braked(own.law, at_us, [deceleration; 3]),
            },
            _ => Trajectory::at_rest(&own.geometry, &from),
        };
        Plan::within(trajectory, &self.limits)
    }

    fn line_stop(&self, from: &ArmState, rate: &Pose, deceleration: f64) -> Trajectory {
        let speed = rate.distance_to(&Pose {
            r: rate.r,
            ..Pose::default()
        });
        let profile = self.law.stop(speed, deceleration);
        if profile.length() <= 0.0 {
            return Trajectory::at_rest(&self.geometry, from);
        }
        let along = |place: f64, rate: f64| place + rate / speed * profile.length();
        let to = Pose {
            x: along(from.pose.x, rate.x),
            y: along(from.pose.y, rate.y),
            z: along(from.pose.z, rate.z),
            r: from.pose.r,
        };
        let segment = self.straight(from, to, profile);
        self.trajectory(from, [segment])
    }

    fn jog_segment(
        &self,
        from: &ArmState,
        axis: JogAxis,
        sign: f64,
        profile: VelocityProfile,
    ) -> MoveSegment {
        let Some(joint) = axis.joint() else {
            let to = axis.moved(&from.pose, sign * profile.length());
            return self.straight(from, to, profile);
        };
        let mut axes = [AxisMotion::at_rest(); 4];
        if let Some(moving) = axes.get_mut(joint) {
            *moving = AxisMotion::new(sign, profile);
        }
        MoveSegment::Joints(JointSegment::following(&self.geometry, from, axes))
    }

    /// Returns a straight line that may lead out of reach; the plan is cut there.
    // The joints of an end out of reach are never sampled.
    fn straight(&self, from: &ArmState, to: Pose, along: VelocityProfile) -> MoveSegment {
        let joints = self.geometry.inverse(&to).unwrap_or(from.joints);
        MoveSegment::Line(LineSegment {
            from: *from,
            to: ArmState { joints, pose: to },
            along,
            turning: VelocityProfile::default(),
        })
    }

    /// Length along the axis that ends beyond its limit, or beyond the reach of the links.
    fn travel_beyond_limits(&self, from: &ArmState, axis: JogAxis, sign: f64) -> f64 {
        let limits = &self.limits;
        let (angle, Range { min, max }) = match axis {
            JogAxis::J1 => (from.joints.j1, limits.j1),
            JogAxis::J2 => (from.joints.j2, limits.j2),
            JogAxis::J3 => (from.joints.j3, limits.j3),
            JogAxis::J4 | JogAxis::R => (from.joints.j4, limits.j4),
            JogAxis::X | JogAxis::Y | JogAxis::Z => {
                return self.reach(&from.pose) + LIMIT_OVERSHOOT;
            }
        };
        let room = if sign > 0.0 { max - angle } else { angle - min };
        // A NaN limit or angle leaves no room.
        let room = if room > 0.0 {
            room.min(UNLIMITED_TRAVEL)
        } else {
            0.0
        };
        room + LIMIT_OVERSHOOT
    }

    /// Distance beyond which no point is in reach.
    fn reach(&self, from: &Pose) -> f64 {
        let tool = self.geometry.tool;
        let bias = Pose::new(tool.x, tool.y, tool.z, 0.0);
        let origin = Pose::default();
        let arm = self.geometry.rear_arm + self.geometry.forearm + bias.distance_to(&origin);
        arm + from.distance_to(&origin)
    }
}

impl Trajectory {
    /// Velocity of a jog axis at a time, signed, mm/s or deg/s: the entry speed of a jog that takes
    /// over then. Zero from the end of the motion on.
    #[must_use]
    pub fn velocity_along(&self, axis: JogAxis, t_us: u64) -> f64 {
        let [j1, j2, j3, j4] = self.joint_velocities(t_us);
        match axis {
            JogAxis::J1 => j1,
            JogAxis::J2 => j2,
            JogAxis::J3 => j3,
            JogAxis::J4 | JogAxis::R => j4,
            JogAxis::X => self.tool_velocity(t_us).x,
            JogAxis::Y => self.tool_velocity(t_us).y,
            JogAxis::Z => self.tool_velocity(t_us).z,
        }
    }

    /// Velocity of the tool at a time, mm/s, and of r, deg/s; zero from the end of the motion on.
    #[must_use]
    pub fn tool_velocity(&self, t_us: u64) -> Pose {
        match self.under_way(t_us) {
            Some((segment, t)) => segment.tool_rate(self.geometry(), t),
            None => Pose::default(),
        }
    }
}
