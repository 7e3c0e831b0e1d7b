//! What is planned when a command asks for motion, and the alarms that planning raises.

use magician_motion::{
    ArmState, Crossing, Limits, LookAhead, MotionError, Move, MoveKind, Plan, Planner, Target,
    Trajectory,
};
use magician_protocol::{Alarm, PoList};

use super::limits::limit_alarm;
use super::{ArmView, MotionKind, Outputs, RailPath, Segment, Start};
use crate::Micros;
use crate::fidelity::Assumption;

/// Why a motion is not begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoPlan {
    /// The arm has no way there.
    Arm(MotionError),
    /// The carriage on the rail has none: its place is no number.
    RailPlace,
    /// The carriage has no speed.
    RailSpeed,
}

impl NoPlan {
    /// The alarm that says so.
    pub(crate) fn alarm(&self) -> u8 {
        match self {
            Self::Arm(MotionError::Limit { .. }) => Alarm::PlanInvLimit,
            Self::Arm(MotionError::Speed { .. }) | Self::RailSpeed => Alarm::PlanSpeedInputParam,
            Self::Arm(MotionError::Coincident) => Alarm::PlanPushDataRepeat,
            Self::Arm(MotionError::Collinear) => Alarm::PlanArcInputParam,
            // Out of reach, and whatever else cannot be calculated.
            Self::Arm(_) | Self::RailPlace => Alarm::PlanInvCalc,
        }
    }

    /// What the alarm rests on; that of the carriage rests on nothing that is counted.
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

impl From<MotionError> for NoPlan {
    fn from(error: MotionError) -> Self {
        Self::Arm(error)
    }
}

impl Start {
    /// A motion of the arm alone: the carriage stays where it is.
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
    /// A move. If the carriage on the rail has somewhere to go, both begin and end together (model
    /// section 7).
    pub(crate) fn plan_move(
        &self,
        request: &Move,
        rail_to: Option<f64>,
        outputs: PoList,
    ) -> Result<Start, NoPlan> {
        let rail = self.plan_rail(rail_to.unwrap_or(self.rail()))?;
        let planner = self.planner(self.settings.motion.speeds());
        let Plan {
            trajectory,
            crossing,
        } = planner.plan_with_min_duration(&self.arm(), request, rail.duration())?;
        let rail = rail
            .along(trajectory.uncut_us(), &self.settings.motion)
            .stopped_with(crossing.map(|crossing| crossing.at_us));
        Ok(Start {
            kind: MotionKind::Move,
            outputs: Outputs::new(outputs, (&trajectory, &rail)),
            alarm: alarm_on_the_way(request, crossing),
            trajectory,
            rail,
        })
    }

    /// A path in space that has been planned: an arc, a circle.
    pub(crate) fn plan_path(&self, plan: Result<Plan, MotionError>) -> Result<Start, NoPlan> {
        let plan = plan?;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        Ok(Start::of_arm(
            self,
            MotionKind::Move,
            plan.trajectory,
            alarm,
        ))
    }

    /// The end of a forced stop; `None` where nothing moves, or it brakes already.
    pub(crate) fn plan_brake(&self) -> Option<Start> {
        let motion = self.motion.under_way.as_ref()?;
        if motion.kind == MotionKind::Brake {
            return None;
        }
        let (elapsed, factor) = (
            motion.elapsed(self.now),
            self.firmware.profile.stop.force_factor,
        );
        let mut planner = self.planner(self.settings.motion.speeds());
        if let MotionKind::Search(_) = motion.kind {
            planner.limits = Limits::NONE;
        }
        let plan = planner.brake(&motion.trajectory, elapsed, factor);
        Some(Start {
            kind: MotionKind::Brake,
            rail: self.brake_rail(&motion.rail, elapsed),
            alarm: plan.crossing.map(|crossing| alarm_at_limit(&crossing)),
            trajectory: plan.trajectory,
            outputs: Outputs::default(),
        })
    }

    /// The last part of homing, a joint move to a point.
    pub(super) fn plan_joint_move(
        &self,
        planner: &Planner,
        target: Target,
    ) -> Result<Start, NoPlan> {
        let request = Move {
            target,
            kind: MoveKind::Joint,
        };
        let plan = planner.plan(&self.arm(), &request)?;
        let alarm = alarm_on_the_way(&request, plan.crossing);
        Ok(Start::of_arm(
            self,
            MotionKind::Move,
            plan.trajectory,
            alarm,
        ))
    }
}

/// The carriage on the rail.
impl ArmView<'_> {
    /// The carriage's way to a place, which the ends of the rail bound without an alarm (model
    /// section 15a).
    fn plan_rail(&self, to: f64) -> Result<RailPath, NoPlan> {
        if !to.is_finite() {
            return Err(NoPlan::RailPlace);
        }
        let (from, to) = (self.rail(), to.clamp(0.0, self.motion.rail.length));
        RailPath::to_place(self.law(), from, to, self.settings.motion.rail())
            .ok_or(NoPlan::RailSpeed)
    }

    /// The carriage's end of an emergency stop: by itself, in the time that it needs (model section
    /// 14 says it of the arm's joints only).
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
    /// The law of segments at the speeds that are set now.
    pub(crate) fn look_ahead(&self) -> Result<LookAhead, MotionError> {
        let model = &self.firmware.model;
        LookAhead::new(&self.settings.motion.cp(model), &model.ceilings, model.law)
    }

    /// A segment from where the arm is.
    pub(crate) fn plan_segment(
        &self,
        planner: &Planner,
        from: &ArmState,
        segment: Segment,
        [entry, exit]: [f64; 2],
    ) -> Result<Start, NoPlan> {
        let plan = planner.segment(from, segment.to(), entry, exit, segment.rates())?;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Ok(Start::of_arm(self, kind, plan.trajectory, alarm))
    }

    /// The rest of the segment under way with another speed at its end; `None` where that changes
    /// nothing or cannot be.
    pub(crate) fn replan_segment(&self, exit: f64) -> Option<Start> {
        let motion = self.motion.under_way.as_ref()?;
        let segment = self.motion.segment()?;
        if motion.alarm.is_some() || exit == motion.trajectory.exit_speed() {
            return None;
        }
        let elapsed = motion.elapsed(self.now);
        let planner = self.planner_given_rates();
        let plan = planner.segment_rest(&motion.trajectory, elapsed, exit, segment.rates());
        let plan = plan.ok()??;
        let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
        let kind = MotionKind::Segment(segment);
        Some(Start::of_arm(self, kind, plan.trajectory, alarm))
    }
}

/// What the end of a motion with an alarm rests on.
pub(crate) fn assumption_of_end(code: u8) -> Assumption {
    match code {
        Alarm::MoveInvCalc | Alarm::MoveInvLimit => Assumption::PathChecked,
        _ => Assumption::JointTargets,
    }
}

/// The alarm for what stops a motion on its way: a move of joints runs into a limit, a path in
/// space leaves the limits or the reach (model section 15a).
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

/// The alarm for what stops a path in space.
pub(super) fn alarm_on_a_path(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { .. } => Alarm::MoveInvLimit,
        _ => Alarm::MoveInvCalc,
    }
}

/// The alarm for what stops a motion of joints.
pub(super) fn alarm_at_limit(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { bound, .. } => limit_alarm(bound),
        _ => Alarm::MoveInvCalc,
    }
}
