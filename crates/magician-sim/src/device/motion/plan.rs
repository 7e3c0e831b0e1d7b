//! Plans for commands that move the arm, and the alarms that planning raises.

use magician_motion::{
    ArmState, Crossing, Limits, LookAhead, MotionError, Move, MoveKind, Plan, Planner, Target,
    Trajectory,
};
use magician_protocol::{Alarm, PoList};

use super::limits::limit_alarm;
use super::{ArmView, MotionKind, Outputs, PlannedMotion, RailPath, Segment};
use crate::Micros;
use crate::fidelity::Assumption;

/// Reason why a motion cannot start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PlanError {
    /// The arm's part cannot be planned.
    Arm(MotionError),
    /// The target of the rail is NaN or infinite.
    RailPlace,
    /// The speed of the rail is invalid.
    RailSpeed,
}

impl PlanError {
    /// Alarm that reports the reason.
    pub(crate) fn alarm(&self) -> u8 {
        match self {
            Self::Arm(MotionError::Limit { .. }) => Alarm::PlanInvLimit,
            Self::Arm(MotionError::Speed { .. }) | Self::RailSpeed => Alarm::PlanSpeedInputParam,
            Self::Arm(MotionError::Coincident) => Alarm::PlanPushDataRepeat,
            Self::Arm(MotionError::Collinear) => Alarm::PlanArcInputParam,
            // Out of reach, or not computable for another reason.
            Self::Arm(_) | Self::RailPlace => Alarm::PlanInvCalc,
        }
    }

    /// Assumption behind the alarm; `None` for the rail.
    pub(crate) fn assumption(&self) -> Option<Assumption> {
        match self {
            Self::Arm(MotionError::Speed { .. }) => Some(Assumption::NoSpeed),
            Self::Arm(MotionError::Coincident | MotionError::Collinear) => {
                Some(Assumption::ArcPoints)
            }
            Self::Arm(_) => Some(Assumption::TargetChecked),
            Self::RailPlace | Self::RailSpeed => None,
        }
    }
}

impl From<MotionError> for PlanError {
    fn from(error: MotionError) -> Self {
        Self::Arm(error)
    }
}

impl PlannedMotion {
    /// Creates a motion of the arm alone; the carriage stands.
    pub(super) fn of_arm(
        view: &ArmView<'_>,
        kind: MotionKind,
        trajectory: Trajectory,
        alarm: Option<u8>,
    ) -> Self {
        Self {
            kind,
            trajectory,
            rail: RailPath::standing(view.rail()),
            alarm,
            outputs: Outputs::default(),
        }
    }
}

impl ArmView<'_> {
    /// Plans a move. If the carriage has to move, arm and carriage begin and end together (model
    /// section 7).
    pub(crate) fn plan_move(
        &self,
        request: &Move,
        rail_to: Option<f64>,
        outputs: PoList,
    ) -> Result<PlannedMotion, PlanError> {
        // The rail first: its duration is the minimum for the arm, and the arm's then for the rail.
        let rail = self.plan_rail(rail_to.unwrap_or(self.rail()))?;
        let planner = self.planner(self.settings.motion.speeds());
        let Plan {
            trajectory,
            crossing,
        } = planner.plan_with_min_duration(&self.arm(), request, rail.duration())?;
        let rail = rail
            .along(trajectory.uncut_us(), &self.settings.motion)
            .stopped_with(crossing.map(|crossing| crossing.at_us));
        Ok(PlannedMotion {
            kind: MotionKind::Move,
            outputs: Outputs::new(outputs, (&trajectory, &rail)),
            alarm: alarm_on_the_way(request, crossing),
            trajectory,
            rail,
        })
    }

    /// Wraps a planned path in space: an arc or a circle.
    pub(crate) fn plan_path(
        &self,
        plan: Result<Plan, MotionError>,
    ) -> Result<PlannedMotion, PlanError> {
        let plan = plan?;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        Ok(PlannedMotion::of_arm(
            self,
            MotionKind::Move,
            plan.trajectory,
            alarm,
        ))
    }

    /// Plans the ramp of a forced stop; `None` if nothing moves or it brakes already.
    pub(crate) fn plan_brake(&self) -> Option<PlannedMotion> {
        let motion = self.motion.under_way.as_ref()?;
        if motion.kind == MotionKind::Brake {
            return None;
        }
        let (elapsed, factor) = (
            motion.elapsed(self.now),
            self.firmware.profile.stop.force_factor,
        );
        // The PTP acceleration counts, whatever kind of motion is braked (model section 14).
        let mut planner = self.planner(self.settings.motion.speeds());
        // During the search for the switch the commanded J1 is unrelated to its limits.
        if let MotionKind::Search(_) = motion.kind {
            planner.limits = Limits::NONE;
        }
        let plan = planner.brake(&motion.trajectory, elapsed, factor);
        Some(PlannedMotion {
            kind: MotionKind::Brake,
            rail: self.brake_rail(&motion.rail, elapsed),
            alarm: plan.crossing.map(|crossing| alarm_at_limit(&crossing)),
            trajectory: plan.trajectory,
            outputs: Outputs::default(),
        })
    }

    /// Plans the last part of homing, a joint move.
    pub(super) fn plan_joint_move(
        &self,
        planner: &Planner,
        target: Target,
    ) -> Result<PlannedMotion, PlanError> {
        let request = Move {
            target,
            kind: MoveKind::Joint,
        };
        let plan = planner.plan(&self.arm(), &request)?;
        let alarm = alarm_on_the_way(&request, plan.crossing);
        Ok(PlannedMotion::of_arm(
            self,
            MotionKind::Move,
            plan.trajectory,
            alarm,
        ))
    }
}

/// The rail.
impl ArmView<'_> {
    /// Plans the carriage's way to a position, clamped to the ends of the rail without an alarm
    /// (model section 15a).
    fn plan_rail(&self, to: f64) -> Result<RailPath, PlanError> {
        if !to.is_finite() {
            return Err(PlanError::RailPlace);
        }
        let (from, to) = (self.rail(), to.clamp(0.0, self.motion.rail.length));
        RailPath::to_place(self.law(), from, to, self.settings.motion.rail())
            .ok_or(PlanError::RailSpeed)
    }

    /// Plans the carriage's part of a forced stop, in the time that it needs by itself. Model
    /// section 14 defines the forced stop for the arm's joints only.
    fn brake_rail(&self, path: &RailPath, elapsed: Micros) -> RailPath {
        let factor = self.firmware.profile.stop.force_factor;
        let rates = self.settings.motion.rail();
        let deceleration = rates.map_or(f64::INFINITY, |rates| factor * rates.acceleration);
        RailPath::slowing(
            self.law(),
            path.sample(elapsed),
            path.velocity(elapsed),
            deceleration,
            self.motion.rail.length,
        )
    }
}

/// Continuous paths.
impl ArmView<'_> {
    /// Look-ahead at the present settings.
    pub(crate) fn look_ahead(&self) -> Result<LookAhead, MotionError> {
        let model = &self.firmware.model;
        LookAhead::new(&self.settings.motion.cp(model), &model.ceilings, model.law)
    }

    /// Plans a segment from where the arm stands.
    pub(crate) fn plan_segment(
        &self,
        planner: &Planner,
        from: &ArmState,
        segment: Segment,
        [entry, exit]: [f64; 2],
    ) -> Result<PlannedMotion, PlanError> {
        let plan = planner.segment(from, segment.to(), entry, exit, segment.rates())?;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Ok(PlannedMotion::of_arm(self, kind, plan.trajectory, alarm))
    }

    /// Replans the rest of the running segment with another exit speed; `None` if that changes
    /// nothing or is impossible.
    pub(crate) fn replan_segment(&self, exit: f64) -> Option<PlannedMotion> {
        let motion = self.motion.under_way.as_ref()?;
        let segment = self.motion.segment()?;
        // A segment that ends at a limit has no exit speed to change.
        if motion.alarm.is_some() || exit == motion.trajectory.exit_speed() {
            return None;
        }
        let elapsed = motion.elapsed(self.now);
        let planner = self.planner_given_rates();
        let plan = planner.segment_rest(&motion.trajectory, elapsed, exit, segment.rates());
        let plan = plan.ok()??;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Some(PlannedMotion::of_arm(self, kind, plan.trajectory, alarm))
    }
}

/// Assumption behind an alarm at the end of a motion.
pub(crate) fn assumption_of_end(code: u8) -> Assumption {
    match code {
        Alarm::MoveInvCalc | Alarm::MoveInvLimit => Assumption::PathChecked,
        // Every other alarm of an end is a joint at its limit.
        _ => Assumption::JointTargets,
    }
}

/// Alarm for a crossing: a joint move runs into its limit, a path in space leaves the limits or the
/// reach (model section 15a).
fn alarm_on_the_way(request: &Move, crossing: Option<Crossing>) -> Option<u8> {
    let crossing = crossing?;
    let of_joints = matches!(
        request.target,
        Target::Joints(_) | Target::JointIncrement(_)
    ) && request.kind == MoveKind::Joint;
    Some(if of_joints {
        alarm_at_limit(&crossing)
    } else {
        alarm_on_a_path(&crossing)
    })
}

/// Alarm for a crossing on a path in space.
pub(super) fn alarm_on_a_path(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { .. } => Alarm::MoveInvLimit,
        // Out of reach; no other cause stops a path.
        _ => Alarm::MoveInvCalc,
    }
}

/// Alarm for a crossing in a motion of joints.
pub(super) fn alarm_at_limit(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { bound, .. } => limit_alarm(bound),
        // Joints meet no obstacle but limits; anything else gets the alarm of a path.
        _ => Alarm::MoveInvCalc,
    }
}
