//! Homing: J1 finds its switch, then the arm moves to the home point (model section 11).
//!
//! J1 turns in the negative direction until its switch closes, backs off, and creeps back in two
//! steps. When the switch closes again, the angle of J1 is set. The switch is at a true angle of
//! the base, so an arm that does not know its base angle finds it. One command runs through all
//! stages. A stop, another motion or a reset ends it at any stage.

use magician_motion::{JointAngles, Limits, Move, MoveKind, Planner, Target};

use super::plan::PlanError;
use super::{ArmView, HomingStage, MotionKind, Outputs, PlannedMotion, RailPath};

/// Distance from the switch at which it counts as closed, deg: below the motor step of 0.01125 deg.
const AT_SWITCH: f64 = 1e-3;

impl ArmView<'_> {
    /// Returns the stage after a finished one; `None` when the switch has closed for the last time.
    ///
    /// The true angle decides, not the commanded one: a base that has slipped away from the switch
    /// continues, and a base that has slipped past it backs off and tries again.
    pub(crate) fn stage_after(&self, stage: HomingStage) -> Option<HomingStage> {
        let offset = self.motion.true_pose(self.now).joints.j1 - self.firmware.model.homing.switch;
        match stage {
            HomingStage::Seek if offset > AT_SWITCH => Some(HomingStage::Seek),
            HomingStage::Seek => Some(HomingStage::BackOff),
            HomingStage::BackOff => Some(HomingStage::Creep),
            HomingStage::Creep => Some(HomingStage::Touch),
            HomingStage::Touch if offset > AT_SWITCH => Some(HomingStage::Touch),
            HomingStage::Touch if offset < -AT_SWITCH => Some(HomingStage::BackOff),
            HomingStage::Touch => None,
        }
    }

    /// Plans one stage of the search. During the first stage the carriage also moves to the end of
    /// the rail, and the stage lasts until it has arrived.
    pub(crate) fn plan_search(&self, stage: HomingStage) -> Result<PlannedMotion, PlanError> {
        let rules = &self.firmware.model.homing;
        let [creep, touch] = rules.creep;
        let (target, velocity) = match stage {
            HomingStage::Seek => (rules.switch, rules.search),
            HomingStage::BackOff => (rules.switch + rules.back_off, rules.search),
            HomingStage::Creep => (rules.switch + rules.back_off / 2.0, creep),
            HomingStage::Touch => (rules.switch, touch),
        };
        // Relative to the true angle: before homing the commanded angle of J1 is unrelated to it.
        let increment = target - self.motion.true_pose(self.now).joints.j1;
        let request = Move {
            target: Target::JointIncrement(JointAngles::from([increment, 0.0, 0.0, 0.0])),
            kind: MoveKind::Joint,
        };
        let mut speeds = rules.speeds();
        // Only J1 moves, at the speed of the stage; the acceleration is that of the final move.
        speeds.joint_velocity[0] = velocity;
        // Limits refer to the commanded angle, so they mean nothing until J1 is referenced.
        let planner = Planner {
            limits: Limits::NONE,
            ..self.planner(speeds)
        };
        let plan = planner.plan(&self.arm(), &request)?;
        Ok(PlannedMotion {
            kind: MotionKind::Search(stage),
            trajectory: plan.trajectory,
            rail: self.plan_rail_home(),
            alarm: None,
            outputs: Outputs::default(),
        })
    }

    /// Plans the end of homing: a joint move to the home point, or to the default joints if none is
    /// set.
    pub(crate) fn plan_home_point(&self) -> Result<PlannedMotion, PlanError> {
        match self.settings.home_point() {
            Some(target) => self.plan_home(target),
            None => self.plan_home_joints(),
        }
    }

    /// Plans the end of homing without a home point.
    pub(crate) fn plan_home_joints(&self) -> Result<PlannedMotion, PlanError> {
        self.plan_home(Target::Joints(self.firmware.model.homing.joints))
    }

    fn plan_home(&self, target: Target) -> Result<PlannedMotion, PlanError> {
        let planner = self.planner(self.firmware.model.homing.speeds());
        self.plan_joint_move(&planner, target)
    }

    /// Plans the carriage's part of homing, to the end of the rail at 0.
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
