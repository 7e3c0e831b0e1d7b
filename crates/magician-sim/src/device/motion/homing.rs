//! Homing: J1 looks for its switch, then the arm goes to the home point (model section 11).
//!
//! J1 turns negative until its switch closes, backs off, and creeps on in two steps; where the switch closes again J1 is
//! set. The switch stands where the base really is, so an arm that does not know its base angle finds it. The command
//! runs through every stage; a stop, another motion or a reset ends it at whichever it is.

use magician_motion::{JointAngles, Limits, MotionError, Move, MoveKind, Plan, Planner, Target};
use magician_protocol::Writable;
use magician_protocol::commands::HomeCmd;

use super::plan::alarm_on_the_way;
use super::{Outputs, Purpose};
use crate::device::Device;
use crate::device::dispatch::Step;
use crate::event::{Event, Refusal};
use crate::fidelity::Assumption;

/// A part of the search for the switch of J1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Fast, to the switch.
    Seek,
    /// Off the switch again.
    BackOff,
    /// Slowly, half of the way back.
    Creep,
    /// Slower still, until the switch closes.
    Touch,
}

/// The base at the switch: closer than the arm's step of 0.01125 deg.
const AT_SWITCH: f64 = 1e-3;

impl Device {
    /// Begins homing. Until J1 is set the arm is not homed, even if it was before.
    pub(crate) fn home(&mut self) -> Step {
        self.halt();
        self.homed = false;
        // A base that stands at its switch already has nothing to seek.
        self.search_on(Stage::Seek)
    }

    /// The first stage takes the carriage on the rail to its end, and lasts until it is there.
    fn search(&mut self, stage: Stage) -> Step {
        let rules = &self.model.homing;
        let [creep, touch] = rules.creep;
        let (target, velocity) = match stage {
            Stage::Seek => (rules.switch, rules.search),
            Stage::BackOff => (rules.switch + rules.back_off, rules.search),
            Stage::Creep => (rules.switch + rules.back_off / 2.0, creep),
            Stage::Touch => (rules.switch, touch),
        };
        let way = target - self.posture().joints.j1;
        let request = Move {
            target: Target::JointIncrement(JointAngles::from([way, 0.0, 0.0, 0.0])),
            kind: MoveKind::Joint,
        };
        let mut speeds = self.model.homing.speeds();
        speeds.joint_velocity[0] = velocity;
        let planner = Planner {
            limits: Limits::NONE,
            ..self.planner(speeds)
        };
        match planner.plan(&self.arm(), &request) {
            Ok(plan) => {
                let (purpose, rail) = (Purpose::Search(stage), self.home_rail());
                self.begin_with_rail(purpose, plan.trajectory, rail, None, Outputs::default())
            }
            Err(error) => self.unplannable(HomeCmd::ROW.id, &error),
        }
    }

    /// What comes after a stage. The switch is felt, not counted: a base that has slipped away from it goes on, and
    /// one that has slipped past it tries again.
    pub(super) fn search_on(&mut self, stage: Stage) -> Step {
        let off = self.posture().joints.j1 - self.model.homing.switch;
        match stage {
            Stage::Seek if off > AT_SWITCH => self.search(Stage::Seek),
            Stage::Seek => self.search(Stage::BackOff),
            Stage::BackOff => self.search(Stage::Creep),
            Stage::Creep => self.search(Stage::Touch),
            Stage::Touch if off > AT_SWITCH => self.search(Stage::Touch),
            Stage::Touch if off < -AT_SWITCH => self.search(Stage::BackOff),
            Stage::Touch => {
                self.set_base();
                self.go_home()
            }
        }
    }

    /// The base stands at its switch, and J2 and J3 are where their sensors say: no step counts as lost any more.
    fn set_base(&mut self) {
        let really = self.posture().joints;
        let j1 = self.model.homing.switch;
        self.place_at(JointAngles { j1, ..really });
        self.motion.forget_slip();
        self.homed = true;
    }

    /// The end of homing: a joint move to the home point. One out of reach is passed over for the joints at which homing
    /// ends when none is set: the vendor's own demonstration sets such a point and goes on (model section 15a).
    fn go_home(&mut self) -> Step {
        let usual = Target::Joints(self.model.homing.joints);
        let target = self.home_point().unwrap_or(usual);
        let planned = match self.plan_home(target) {
            Err(MotionError::Unreachable(_) | MotionError::Limit { .. }) if target != usual => {
                let id = HomeCmd::ROW.id;
                if !self.allows(id, Assumption::HomeOutOfReach) {
                    return self.refuse(id, Refusal::Unplannable);
                }
                self.log.push(Event::HomeOutOfReach);
                self.plan_home(usual)
            }
            planned => planned,
        };
        match planned {
            Ok((plan, alarm)) => {
                self.begin(Purpose::Move, plan.trajectory, alarm, Outputs::default())
            }
            Err(error) => self.unplannable(HomeCmd::ROW.id, &error),
        }
    }

    /// The joint move to a home point, and the alarm that ends it on the way.
    fn plan_home(&self, target: Target) -> Result<(Plan, Option<u8>), MotionError> {
        let request = Move {
            target,
            kind: MoveKind::Joint,
        };
        let plan = (self.planner(self.model.homing.speeds())).plan(&self.arm(), &request)?;
        let alarm = alarm_on_the_way(&request, plan.crossing);
        Ok((plan, alarm))
    }
}
