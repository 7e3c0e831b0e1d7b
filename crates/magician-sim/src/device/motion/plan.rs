//! What is planned when a command asks for motion, and the alarms that planning raises.

use magician_motion::{
    Crossing, Limits, MotionError, Move, MoveKind, Plan, Planner, Speeds, Target,
};
use magician_protocol::{Alarm, PoList};

use super::limits::alarm_of;
use super::{Outputs, Purpose};
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::event::Refusal;
use crate::fidelity::Assumption;

impl Device {
    pub(crate) fn planner(&self, speeds: Speeds) -> Planner {
        self.model.planner(self.tool(), speeds)
    }

    /// The planner for jogs and paths, which are told their rates one by one.
    pub(crate) fn planner_told_rates(&self) -> Planner {
        self.planner(self.model.power_up.speeds)
    }

    /// What the arm would do about a move from where it is, at the speeds set now.
    pub(crate) fn plan(&self, request: &Move) -> Result<Plan, MotionError> {
        self.planner(self.ptp_speeds()).plan(&self.arm(), request)
    }

    /// Begins a move. One that is under way is replaced: if it was the queue's, its command has finished. A move
    /// that cannot be planned is refused with an alarm and changes nothing. If the carriage on the rail has somewhere to
    /// go, both begin and end together (model section 7).
    pub(crate) fn move_arm(
        &mut self,
        id: u8,
        request: &Move,
        rail_to: Option<f64>,
        outputs: PoList,
    ) -> Step {
        let rail = match self.plan_rail(rail_to.unwrap_or(self.rail())) {
            Ok(course) => course,
            Err(alarm) => {
                self.raise(alarm);
                return self.refuse(id, Refusal::Unplannable);
            }
        };
        let planner = self.planner(self.ptp_speeds());
        match planner.plan_lasting(&self.arm(), request, rail.duration()) {
            Ok(plan) => {
                self.halt();
                let Plan {
                    trajectory,
                    crossing,
                } = plan;
                let alarm = alarm_on_the_way(request, crossing);
                let rail = rail
                    .along(trajectory.uncut_us(), self)
                    .stopped_with(crossing.map(|crossing| crossing.at_us));
                let outputs = Outputs::new(outputs, (&trajectory, &rail));
                self.begin_with_rail(Purpose::Move, trajectory, rail, alarm, outputs)
            }
            Err(error) => self.unplannable(id, &error),
        }
    }

    /// Begins a path in space that has been planned, as [`move_arm`](Self::move_arm) does.
    pub(crate) fn follow(&mut self, id: u8, plan: Result<Plan, MotionError>) -> Step {
        match plan {
            Ok(plan) => {
                self.halt();
                let alarm = plan.crossing.map(|crossing| alarm_on_a_path(&crossing));
                self.begin(Purpose::Move, plan.trajectory, alarm, Outputs::default())
            }
            Err(error) => self.unplannable(id, &error),
        }
    }

    /// A motion that cannot be planned.
    pub(crate) fn unplannable(&mut self, id: u8, error: &MotionError) -> Step {
        if self.allows(id, planning_assumption(error)) {
            self.raise(alarm_in_planning(error));
            self.refuse(id, Refusal::Unplannable)
        } else {
            Step::Done
        }
    }

    /// Brakes what moves; a motion that brakes already goes on doing so.
    pub(crate) fn brake(&mut self) {
        let Some(motion) = self.motion.under_way() else {
            return;
        };
        match motion.purpose {
            Purpose::Brake => {}
            purpose => {
                let (elapsed, factor) = (motion.elapsed(self.now), self.profile.stop.force_factor);
                let mut planner = self.planner(self.ptp_speeds());
                if let Purpose::Search(_) = purpose {
                    planner.limits = Limits::NONE;
                }
                let plan = planner.brake(&motion.trajectory, elapsed, factor);
                let rail = self.brake_rail(&motion.rail, elapsed);
                let alarm = plan.crossing.map(|crossing| alarm_at_limit(&crossing));
                // Its command finishes when the arm stands; the laser of a path is off at once.
                self.rest_here();
                self.actuators.burn(0.0);
                let none = Outputs::default();
                self.begin_with_rail(Purpose::Brake, plan.trajectory, rail, alarm, none);
            }
        }
    }
}

/// What the answer to a motion that cannot be planned rests on.
fn planning_assumption(error: &MotionError) -> Assumption {
    match error {
        MotionError::Speed { .. } => Assumption::NoSpeed,
        MotionError::Coincident | MotionError::Collinear => Assumption::ArcPoints,
        _ => Assumption::TargetChecked,
    }
}

/// What the end of a motion with an alarm rests on.
pub(super) fn ending_assumption(code: u8) -> Assumption {
    match code {
        Alarm::MoveInvCalc | Alarm::MoveInvLimit => Assumption::PathChecked,
        _ => Assumption::JointTargets,
    }
}

/// The alarm for a motion that is not begun.
pub(crate) fn alarm_in_planning(error: &MotionError) -> u8 {
    match error {
        MotionError::Limit { .. } => Alarm::PlanInvLimit,
        MotionError::Speed { .. } => Alarm::PlanSpeedInputParam,
        MotionError::Coincident => Alarm::PlanPushDataRepeat,
        MotionError::Collinear => Alarm::PlanArcInputParam,
        // Out of reach, and whatever else cannot be calculated.
        _ => Alarm::PlanInvCalc,
    }
}

/// The alarm for what stops a motion on its way: a move of joints runs into a limit, a path in space leaves the limits
/// or the reach (model section 15a).
pub(super) fn alarm_on_the_way(request: &Move, crossing: Option<Crossing>) -> Option<u8> {
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
pub(crate) fn alarm_on_a_path(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { .. } => Alarm::MoveInvLimit,
        _ => Alarm::MoveInvCalc,
    }
}

/// The alarm for what stops a motion of joints.
pub(crate) fn alarm_at_limit(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { bound, .. } => alarm_of(bound),
        _ => Alarm::MoveInvCalc,
    }
}
