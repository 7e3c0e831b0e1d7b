//! The planner: from a request to a trajectory (model section 7).
//!
//! A plan is made in three steps: resolve the target (increments count from the start), choose a
//! velocity profile for each axis and stretch all of them to the slowest, then search the whole
//! motion for limits and cut it at the first one. Targets in space are checked before anything
//! moves; targets in joints are not, as on the real arm, which runs to the limit and stops there
//! (model section 4).

use crate::axis_motion::AxisMotion;
use crate::joint_segment::JointSegment;
use crate::jump::Corners;
use crate::line_segment::LineSegment;
use crate::move_segment::{MoveSegment, SHORTEST_MOVE};
use crate::velocity_profile::{KinematicLimits, VelocityProfile};
use crate::{
    ArmState, Ceilings, Geometry, JointAngles, JumpHeights, Limits, MotionError, MotionLaw, Pose,
    Speeds, Trajectory, Transfer, Unreachable,
};

/// Target of a motion. Increments count from where the motion starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// An absolute pose.
    Pose(Pose),
    /// Absolute joint angles.
    Joints(JointAngles),
    /// An increment of x, y, z and r.
    PoseIncrement(Pose),
    /// An increment of each joint.
    JointIncrement(JointAngles),
}

/// Path on which a motion reaches its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveKind {
    /// All joints together, with common start and end (`MOVJ`).
    Joint,
    /// The tool moves on a straight line while r turns (`MOVL`).
    Line,
    /// Up, across and down, with a stop at both corners (`JUMP`).
    Jump(JumpHeights, Transfer),
}

/// A point-to-point motion.
///
/// The ten modes of the protocol are ten pairs of target and kind (model section 7): 0 pose, jump
/// with joint transfer; 1 pose, joint; 2 pose, line; 3 joints, jump with joint transfer; 4 joints,
/// joint; 5 joints, line; 6 joint increment, joint; 7 pose increment, line; 8 pose increment,
/// joint; 9 pose, jump with line transfer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Target of the motion.
    pub target: Target,
    /// Path to the target.
    pub kind: MoveKind,
}

/// Point at which a limit or the edge of reach ends a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Time of the end, microseconds from the start of the motion. 0 if the start is beyond a limit
    /// already and the motion leads further out.
    pub at_us: u64,
    /// Share of the path done by then, 0 to 1.
    pub progress: f64,
    /// The obstacle: the edge of reach ([`MotionError::Unreachable`]) or a bound
    /// ([`MotionError::Limit`]).
    pub cause: MotionError,
}

/// Result of planning a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Motion of the arm: up to the target, or up to the crossing.
    pub trajectory: Trajectory,
    /// The limit that stops the motion before its target; `None` if it arrives.
    pub crossing: Option<Crossing>,
}

impl Plan {
    pub(crate) fn within(trajectory: Trajectory, limits: &Limits) -> Self {
        match trajectory.first_crossing(limits) {
            None => Self {
                trajectory,
                crossing: None,
            },
            Some((at_us, cause, end)) => {
                let cut = trajectory.cut(at_us, end);
                Self {
                    trajectory: cut,
                    crossing: Some(Crossing {
                        at_us: cut.duration_us(),
                        progress: trajectory.curve_progress(at_us),
                        cause,
                    }),
                }
            }
        }
    }
}

/// Everything that a plan depends on besides start and request. Made by
/// [`ArmModel::planner`](crate::ArmModel::planner).
///
/// ```
/// use magician_motion::{ArmModel, ArmState, JointAngles, Move, MoveKind, Pose, Target, ToolBias};
///
/// let model = ArmModel::MAGICIAN;
/// let planner = model.planner(ToolBias::NONE, model.power_up.speeds());
/// let home = ArmState::at_joints(&planner.geometry, &JointAngles::HOME);
/// let there = Pose::new(200.0, 50.0, 20.0, 0.0);
/// let request = Move { target: Target::Pose(there), kind: MoveKind::Line };
/// let plan = planner.plan(&home, &request)?;
/// assert_eq!(plan.crossing, None); // no limit is in the way
/// assert_eq!(plan.trajectory.end().pose, there);
/// # Ok::<(), magician_motion::MotionError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Planner {
    /// Geometry with the tool bias in force.
    pub geometry: Geometry,
    /// Joint limits in force.
    pub limits: Limits,
    /// Ceilings of the speeds.
    pub ceilings: Ceilings,
    /// Law of motion.
    pub law: MotionLaw,
    /// Speed settings.
    pub speeds: Speeds,
}

impl Planner {
    /// Joins segments into a trajectory. Each begins when the one before has ended.
    pub(crate) fn trajectory(
        &self,
        from: &ArmState,
        segments: impl IntoIterator<Item = MoveSegment>,
    ) -> Trajectory {
        Trajectory::of_segments(&self.geometry, self.law, from, segments)
    }

    /// Plans a motion from rest.
    ///
    /// Targets in space and the corners of a jump must be within reach and limits, and are checked
    /// here. A line or a jump with valid ends may still cross a limit or the edge of reach on the
    /// way, and a target given in joints is not checked at all. Such a plan ends at the limit and
    /// says so in its [`crossing`](Plan::crossing). A motion shorter than 0.0001 mm and degrees
    /// takes no time and always succeeds.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] and [`MotionError::Limit`] for the target or a corner of a
    /// jump; [`MotionError::Speed`] for an invalid speed that the motion needs.
    pub fn plan(&self, from: &ArmState, request: &Move) -> Result<Plan, MotionError> {
        let trajectory = self.fastest(from, request)?;
        Ok(Plan::within(trajectory, &self.limits))
    }

    /// Plans the forced stop at a time within a motion (model section 14).
    ///
    /// The joints brake at `factor` times the acceleration in force (the arm uses 2): J1 to J3
    /// together over the longest time that one of them needs, J4 at once. If the acceleration is
    /// invalid or the factor is not positive, the arm stops at once. A motion that brakes close to
    /// a limit may still run into it; the plan then has a crossing.
    #[must_use]
    pub fn brake(&self, motion: &Trajectory, at_us: u64, factor: f64) -> Plan {
        let deceleration = |joint| match self.speeds.joint(joint, &self.ceilings) {
            Ok(rates) if factor > 0.0 => factor * rates.acceleration,
            // An infinite deceleration stops the arm at once: a forced stop must never fail.
            _ => f64::INFINITY,
        };
        let braked = motion.braked(self.law, at_us, [0, 1, 2].map(deceleration));
        Plan::within(braked, &self.limits)
    }

    /// Plans the requested motion without a check for limits on the way.
    pub(crate) fn fastest(
        &self,
        from: &ArmState,
        request: &Move,
    ) -> Result<Trajectory, MotionError> {
        let target = self.resolve(from, &request.target)?;
        match request.kind {
            MoveKind::Joint => self.plan_joint(from, &target),
            MoveKind::Line => self.plan_line(from, &target),
            MoveKind::Jump(heights, transfer) => self.plan_jump(from, &target, &heights, transfer),
        }
    }

    fn resolve(&self, from: &ArmState, target: &Target) -> Result<Destination, MotionError> {
        let destination = match target {
            Target::Pose(pose) => Destination::Pose(*pose),
            Target::PoseIncrement(by) => Destination::Pose(from.pose.offset_by(by)),
            Target::Joints(joints) => Destination::joints(&self.geometry, joints),
            Target::JointIncrement(by) => {
                Destination::joints(&self.geometry, &from.joints.offset_by(by))
            }
        };
        if destination.is_finite() {
            Ok(destination)
        } else {
            Err(Unreachable::NotFinite.into())
        }
    }

    fn plan_joint(&self, from: &ArmState, to: &Destination) -> Result<Trajectory, MotionError> {
        if to.is_reached(from) {
            return Ok(self.arrival(from, to));
        }
        let to = match to {
            Destination::Joints(state) => *state,
            Destination::Pose(_) => self.check(to)?,
        };
        let segment = self.joint_segment(from, &to)?;
        Ok(self.trajectory(from, [segment]))
    }

    fn plan_line(&self, from: &ArmState, to: &Destination) -> Result<Trajectory, MotionError> {
        if Destination::Pose(to.pose()).is_reached(from) {
            return Ok(self.arrival(from, to));
        }
        let segment = self.line_segment(from, &self.check(to)?)?;
        Ok(self.trajectory(from, [segment]))
    }

    fn plan_jump(
        &self,
        from: &ArmState,
        to: &Destination,
        heights: &JumpHeights,
        transfer: Transfer,
    ) -> Result<Trajectory, MotionError> {
        let to = self.check(to)?;
        let corners = Corners::between(&self.geometry, &from.pose, &to.pose, heights)?;
        let segments = self.jump_segments(from, &to, &corners, transfer)?;
        let segments = self.lower_corners(from, &to, corners, transfer, segments);
        Ok(self.trajectory(from, segments))
    }

    /// Lowers the corners of a jump if its joint transfer would swing the tool above the ceiling.
    ///
    /// If the ends of the jump leave no room for that, straight lines replace the legs, provided
    /// that they stay within the limits. Both are choices: the vendor's code does not look at the
    /// swing (model section 7).
    fn lower_corners(
        &self,
        from: &ArmState,
        to: &ArmState,
        corners: Corners,
        transfer: Transfer,
        segments: [MoveSegment; 3],
    ) -> [MoveSegment; 3] {
        let overshoot = |segments: &[MoveSegment; 3]| {
            segments
                .iter()
                .filter_map(|segment| segment.overshoot(&self.geometry, corners.ceiling))
                .fold(0.0, f64::max)
        };
        let (mut lower, mut lower_segments) = (corners, segments);
        // If one corner is at its floor already, lowering the other converges slowly. After eight
        // rounds the steps grow.
        let steps = (0..MAX_LOWERINGS).map(|round| match round {
            0..8 => 1.0,
            _ => f64::from(round - 6),
        });
        for step in steps {
            let overshoot = overshoot(&lower_segments);
            if overshoot <= 0.0 {
                return lower_segments;
            }
            let Some(next) = lower.lowered(step * overshoot) else {
                break;
            };
            let Ok(next_segments) = self.jump_segments(from, to, &next, transfer) else {
                break;
            };
            (lower, lower_segments) = (next, next_segments);
        }
        match self.jump_segments(from, to, &corners.straight(), Transfer::Line) {
            Ok(straight) if self.is_clear(from, straight) => straight,
            _ => lower_segments,
        }
    }

    fn is_clear(&self, from: &ArmState, segments: [MoveSegment; 3]) -> bool {
        self.trajectory(from, segments)
            .first_crossing(&self.limits)
            .is_none()
    }

    fn jump_segments(
        &self,
        from: &ArmState,
        to: &ArmState,
        corners: &Corners,
        transfer: Transfer,
    ) -> Result<[MoveSegment; 3], MotionError> {
        let lift = self.check(&Destination::Pose(corners.lift))?;
        let descent = self.check(&Destination::Pose(corners.descent))?;
        Ok([
            self.move_segment(from, &lift, corners.lift_is_straight)?,
            self.move_segment(&lift, &descent, transfer == Transfer::Line)?,
            self.move_segment(&descent, to, corners.descent_is_straight)?,
        ])
    }

    /// Solves a destination and checks it against the limits.
    fn check(&self, destination: &Destination) -> Result<ArmState, MotionError> {
        match destination {
            Destination::Pose(pose) => ArmState::at_pose(&self.geometry, pose, &self.limits),
            Destination::Joints(state) => {
                self.limits.check(&state.joints)?;
                // Limits may be configured wider than the inverse can follow.
                state.check_invertible(&self.geometry)?;
                Ok(*state)
            }
        }
    }

    /// Returns a motion of zero duration, for a destination at which the arm already stands. It
    /// ends exactly on the destination if that is within the limits.
    fn arrival(&self, from: &ArmState, to: &Destination) -> Trajectory {
        let end = self.check(to).unwrap_or(*from);
        Trajectory::at_rest(&self.geometry, &end)
    }

    fn move_segment(
        &self,
        from: &ArmState,
        to: &ArmState,
        straight: bool,
    ) -> Result<MoveSegment, MotionError> {
        if straight {
            self.line_segment(from, to)
        } else {
            self.joint_segment(from, to)
        }
    }

    fn joint_segment(&self, from: &ArmState, to: &ArmState) -> Result<MoveSegment, MotionError> {
        let mut sweeps = to.joints.to_array();
        for (sweep, start) in sweeps.iter_mut().zip(from.joints.to_array()) {
            *sweep -= start;
        }
        let lengths = sweeps.map(libm::fabs);
        let [s1, s2, s3, s4] = sweeps;
        let [p1, p2, p3, p4] = synchronised(self.law, lengths, |joint| {
            self.speeds.joint(joint, &self.ceilings)
        })?;
        Ok(MoveSegment::Joints(JointSegment {
            from: *from,
            to: *to,
            axes: [
                AxisMotion::new(s1, p1),
                AxisMotion::new(s2, p2),
                AxisMotion::new(s3, p3),
                AxisMotion::new(s4, p4),
            ],
        }))
    }

    /// Returns the profiles of a tool that moves `distance` mm along its path while r turns by
    /// `turn` degrees.
    pub(crate) fn tool_profiles(
        &self,
        distance: f64,
        turn: f64,
    ) -> Result<[VelocityProfile; 2], MotionError> {
        synchronised(self.law, [distance, libm::fabs(turn)], |axis| match axis {
            0 => self.speeds.linear(&self.ceilings),
            _ => self.speeds.rotation(&self.ceilings),
        })
    }

    fn line_segment(&self, from: &ArmState, to: &ArmState) -> Result<MoveSegment, MotionError> {
        from.check_invertible(&self.geometry)?;
        let distance = from.pose.distance_to(&to.pose);
        let [along, turning] = self.tool_profiles(distance, to.pose.r - from.pose.r)?;
        Ok(MoveSegment::Line(LineSegment {
            from: *from,
            to: *to,
            along,
            turning,
        }))
    }
}

/// Most rounds of lowering the corners of a jump. Usually a few suffice; the bound keeps planning
/// time finite for extreme settings.
const MAX_LOWERINGS: u32 = 32;

/// Clamp for joint targets, degrees. It is beyond any limit and keeps differences of angles finite.
const MAX_TARGET_ANGLE: f64 = 1e9;

/// A resolved target: increments are added up.
enum Destination {
    Pose(Pose),
    Joints(ArmState),
}

impl Destination {
    fn joints(geometry: &Geometry, joints: &JointAngles) -> Self {
        let clamped = joints.to_array().map(|angle| {
            // NaN stays NaN, and infinity must not become a finite angle: both are refused later.
            if angle.is_finite() {
                angle.clamp(-MAX_TARGET_ANGLE, MAX_TARGET_ANGLE)
            } else {
                angle
            }
        });
        Self::Joints(ArmState::at_joints(geometry, &clamped.into()))
    }

    fn pose(&self) -> Pose {
        match self {
            Self::Pose(pose) => *pose,
            Self::Joints(state) => state.pose,
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Pose(pose) => pose.is_finite(),
            Self::Joints(state) => state.joints.is_finite(),
        }
    }

    /// True if the remaining distance is too short to count as a motion.
    fn is_reached(&self, from: &ArmState) -> bool {
        match self {
            Self::Pose(pose) => {
                from.pose.distance_to(pose) < SHORTEST_MOVE
                    && libm::fabs(pose.r - from.pose.r) < SHORTEST_MOVE
            }
            Self::Joints(state) => {
                let (from, to) = (from.joints.to_array(), state.joints.to_array());
                let mut sweeps = from.iter().zip(to).map(|(from, to)| libm::fabs(to - from));
                sweeps.all(|sweep| sweep < SHORTEST_MOVE)
            }
        }
    }
}

/// Returns profiles that start and end together: the slowest axis sets the duration, the others are
/// stretched to it.
///
/// An axis that hardly moves needs no valid speed; it gets the gentlest profile.
fn synchronised<const N: usize>(
    law: MotionLaw,
    lengths: [f64; N],
    rates: impl Fn(usize) -> Result<KinematicLimits, MotionError>,
) -> Result<[VelocityProfile; N], MotionError> {
    let mut duration: f64 = 0.0;
    let mut allowed: [Option<KinematicLimits>; N] = [None; N];
    for (axis, (slot, length)) in allowed.iter_mut().zip(lengths).enumerate() {
        *slot = match rates(axis) {
            Ok(rates) => Some(rates),
            Err(error) if length >= SHORTEST_MOVE => return Err(error),
            Err(_) => None,
        };
        if let Some(rates) = slot {
            duration = duration.max(rates.least_time(length));
        }
    }
    // Below the shortest move nothing moves at all (model section 7).
    if lengths.iter().all(|length| *length < SHORTEST_MOVE) {
        duration = 0.0;
    }
    let mut profiles = [VelocityProfile::default(); N];
    for (profile, (length, rates)) in profiles.iter_mut().zip(lengths.into_iter().zip(allowed)) {
        *profile = match rates {
            Some(rates) if duration > 0.0 => law.rest_to_rest_in(length, &rates, duration),
            _ => law.triangle(length, duration),
        };
    }
    Ok(profiles)
}
