//! What is planned when a command asks for motion, and the alarms that planning raises.

use magician_motion::{
    Crossing, MotionError, Move, MoveKind, Plan, Planner, Speeds, Target, Trajectory,
};
use magician_protocol::commands::HomeCmd;
use magician_protocol::{Alarm, PoList, Writable};

use super::limits::alarm_of;
use super::{Outputs, Purpose};
use crate::convert::micros;
use crate::core::Core;
use crate::dispatch::Step;
use crate::event::Refusal;

impl Core {
    pub(crate) fn planner(&self, speeds: Speeds) -> Planner {
        Planner {
            geometry: self.geometry(),
            limits: self.profile.limits_in_force(),
            speeds,
        }
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
                    .along(trajectory.duration_us(), self)
                    .stopped_with(crossing.map(|crossing| crossing.at_us));
                let outputs = Outputs::new(outputs, (&trajectory, &rail));
                self.begin_with_rail(Purpose::Move, trajectory, rail, 0, alarm, outputs)
            }
            Err(error) => self.unplannable(id, &error),
        }
    }

    /// A motion that cannot be planned.
    pub(crate) fn unplannable(&mut self, id: u8, error: &MotionError) -> Step {
        self.raise(alarm_in_planning(error));
        self.refuse(id, Refusal::Unplannable)
    }

    /// Brakes what moves; a motion that brakes already goes on doing so.
    pub(crate) fn brake(&mut self) {
        let Some(motion) = self.motion.under_way() else {
            return;
        };
        match motion.purpose {
            Purpose::Brake => {}
            Purpose::Search => self.halt(),
            Purpose::Move | Purpose::RailJog => {
                let (elapsed, factor) = (motion.elapsed(self.now), self.profile.stop.force_factor);
                let planner = self.planner(self.ptp_speeds());
                let plan = planner.brake(&motion.trajectory, elapsed, factor);
                let rail = self.brake_rail(&motion.rail, elapsed);
                let alarm = plan.crossing.map(|crossing| alarm_at_limit(&crossing));
                // Its command finishes when the arm stands.
                self.rest_here();
                let none = Outputs::default();
                self.begin_with_rail(Purpose::Brake, plan.trajectory, rail, 0, alarm, none);
            }
        }
    }

    /// Begins homing: first the search for the switch of J1, which finds the reference, then the joint move to the
    /// home point. The carriage on the rail homes during the search, which lasts until it has.
    pub(crate) fn home(&mut self) -> Step {
        self.halt();
        let (waits, rail) = (self.arm_at_rest(), self.home_rail());
        let lasting = micros(self.profile.home.search);
        let none = Outputs::default();
        self.begin_with_rail(Purpose::Search, waits, rail, lasting, None, none)
    }

    /// No motion of the arm.
    pub(super) fn arm_at_rest(&self) -> Trajectory {
        Trajectory::at_rest(&self.geometry(), &self.arm())
    }

    /// Homing has found its reference: now to the home point.
    pub(super) fn leave_switch(&mut self) -> Step {
        self.homed = true;
        let request = Move {
            target: self.home_point(),
            kind: MoveKind::Joint,
        };
        let planner = self.planner(self.homing_speeds());
        match planner.plan(&self.arm(), &request) {
            Ok(plan) => {
                let alarm = alarm_on_the_way(&request, plan.crossing);
                self.begin(Purpose::Move, plan.trajectory, alarm, Outputs::default())
            }
            Err(error) => self.unplannable(HomeCmd::ROW.id, &error),
        }
    }
}

/// The alarm for a motion that is not begun.
pub(crate) fn alarm_in_planning(error: &MotionError) -> u8 {
    match error {
        MotionError::Limit { .. } => Alarm::PlanInvLimit,
        MotionError::Speed { .. } => Alarm::PlanSpeedInputParam,
        // Out of reach, and whatever else cannot be calculated.
        _ => Alarm::PlanInvCalc,
    }
}

/// The alarm for what stops a motion on its way: a move of joints runs into a limit, a path in space leaves the limits
/// or the reach (model section 15a).
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
