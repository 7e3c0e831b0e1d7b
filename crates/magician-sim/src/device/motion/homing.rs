//! Homing: J1 looks for its switch, then the arm goes to the home point (model section 11).
//!
//! J1 turns negative until its switch closes, backs off, and creeps on in two steps; where the
//! switch closes again J1 is set. The switch stands where the base really is, so an arm that does
//! not know its base angle finds it. The command runs through every stage; a stop, another motion
//! or a reset ends it at whichever it is.

use magician_motion::{JointAngles, Limits, Move, MoveKind, Planner, Target};

use super::plan::NoPlan;
use super::{ArmView, MotionKind, Outputs, RailPath, Stage, Start};

/// The base at the switch: closer than the arm's step of 0.01125 deg.
const AT_SWITCH: f64 = 1e-3;

impl ArmView<'_> {
    /// What comes after a stage; `None` when the switch has closed for the last time. The switch is
    /// felt, not counted: a base that has slipped away from it goes on, and one that has slipped
    /// past it tries again.
    pub(crate) fn stage_after(&self, stage: Stage) -> Option<Stage> {
        let off = self.motion.true_pose(self.now).joints.j1 - self.firmware.model.homing.switch;
        match stage {
            Stage::Seek if off > AT_SWITCH => Some(Stage::Seek),
            Stage::Seek => Some(Stage::BackOff),
            Stage::BackOff => Some(Stage::Creep),
            Stage::Creep => Some(Stage::Touch),
            Stage::Touch if off > AT_SWITCH => Some(Stage::Touch),
            Stage::Touch if off < -AT_SWITCH => Some(Stage::BackOff),
            Stage::Touch => None,
        }
    }

    /// The first stage takes the carriage on the rail to its end, and lasts until it is there.
    pub(crate) fn plan_search(&self, stage: Stage) -> Result<Start, NoPlan> {
        let rules = &self.firmware.model.homing;
        let [creep, touch] = rules.creep;
        let (target, velocity) = match stage {
            Stage::Seek => (rules.switch, rules.search),
            Stage::BackOff => (rules.switch + rules.back_off, rules.search),
            Stage::Creep => (rules.switch + rules.back_off / 2.0, creep),
            Stage::Touch => (rules.switch, touch),
        };
        let way = target - self.motion.true_pose(self.now).joints.j1;
        let request = Move {
            target: Target::JointIncrement(JointAngles::from([way, 0.0, 0.0, 0.0])),
            kind: MoveKind::Joint,
        };
        let mut speeds = rules.speeds();
        speeds.joint_velocity[0] = velocity;
        let planner = Planner {
            limits: Limits::NONE,
            ..self.planner(speeds)
        };
        let plan = planner.plan(&self.arm(), &request)?;
        Ok(Start {
            kind: MotionKind::Search(stage),
            trajectory: plan.trajectory,
            rail: self.plan_rail_home(),
            alarm: None,
            outputs: Outputs::default(),
        })
    }

    /// The end of homing: a joint move to the home point that was set, or else to the joints at
    /// which homing ends.
    pub(crate) fn plan_home_point(&self) -> Result<Start, NoPlan> {
        match self.settings.home_point() {
            Some(target) => self.plan_home(target),
            None => self.plan_home_joints(),
        }
    }

    /// The end of homing when no home point is set.
    pub(crate) fn plan_home_joints(&self) -> Result<Start, NoPlan> {
        self.plan_home(Target::Joints(self.firmware.model.homing.joints))
    }

    fn plan_home(&self, target: Target) -> Result<Start, NoPlan> {
        let planner = self.planner(self.firmware.model.homing.speeds());
        self.plan_joint_move(&planner, target)
    }

    /// The carriage's part of homing, for a motion that begins now: to the end of the rail where it
    /// is 0.
    fn plan_rail_home(&self) -> RailPath {
        if self.settings.motion.has_rail() {
            RailPath::home(
                self.law(),
                self.motion.true_pose(self.now).rail,
                &self.firmware.model.rail,
            )
        } else {
            RailPath::standing(self.rail())
        }
    }
}
