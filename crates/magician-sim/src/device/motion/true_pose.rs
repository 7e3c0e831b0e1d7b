//! True pose of the arm, its offset from the commanded one, and the world's view of a motion (model
//! sections 11 and 12).
//!
//! Steppers run open-loop, so the controller cannot know the difference. It shows in three places:
//! the world draws and collides with the true pose, LostStepCmd compares the sensors of J2 and J3,
//! and homing finds the true angle of the base.

use magician_motion::{Geometry, JointAngles};

use super::Motion;
use crate::world::{Drawing, JointState, TimedPath};
use crate::{ArmInstant, World};

/// Largest offset of a joint, deg: a full turn. It keeps repeated slips finite.
const MAX_SLIP: f64 = 360.0;

impl Motion {
    /// True pose at an instant, as of the last period.
    pub(crate) fn true_pose(&self, now: ArmInstant) -> JointState {
        self.true_pose_of(now, self.joints(now))
    }

    /// True pose of the motors, between the ends of two periods, too: the world's view.
    fn way(&self, now: ArmInstant) -> JointState {
        let (joints, rail) = self.motor_position(now);
        JointState {
            rail: self.rail.true_place(rail),
            ..self.true_pose_of(now, joints)
        }
    }

    /// True pose for commanded joints.
    pub(crate) fn true_pose_of(&self, now: ArmInstant, commanded: JointAngles) -> JointState {
        let mut joints = commanded.to_array();
        for (angle, slip) in joints.iter_mut().zip(self.slip) {
            *angle += slip;
        }
        let stalled = self.under_way.as_ref().and_then(|motion| motion.stalled);
        if let ([_, j2, j3, _], Some((since, [at2, at3]))) = (&mut joints, stalled)
            && now >= since
        {
            (*j2, *j3) = (at2, at3);
        }
        JointState {
            joints: joints.into(),
            rail: self.rail.true_place(self.rail_at(now)),
        }
    }

    /// Sets the unknown base angle: the true angle less the encoder's reading.
    fn forget_base(&mut self, base: f64) {
        self.slip = [base, 0.0, 0.0, 0.0];
        self.base = base;
    }

    /// Sets the offset of the carriage that the controller does not know.
    pub(crate) fn forget_rail(&mut self, slip: f64) {
        self.rail.slip = slip;
    }

    /// Makes the true position of the carriage known to the controller.
    pub(crate) fn find_rail(&mut self, now: ArmInstant) {
        self.rail.rest = self.true_pose(now).rail;
        self.rail.slip = 0.0;
    }

    /// Deviations seen by the base encoder and by the sensors of J2 and J3 (model section 12).
    pub(crate) fn lost(&self, now: ArmInstant) -> [f64; 3] {
        let (really, commanded) = (self.true_pose(now).joints, self.joints(now));
        [
            really.j1 - self.base - commanded.j1,
            really.j2 - commanded.j2,
            really.j3 - commanded.j3,
        ]
    }

    /// Applies power at these true joints: J1 reads its value of power-up, J2 and J3 their sensors.
    pub(crate) fn wake_at(&mut self, now: ArmInstant, geometry: &Geometry, really: JointAngles) {
        let j1 = self.joints(now).j1;
        self.place_at(geometry, JointAngles { j1, ..really });
        self.forget_base(really.j1 - j1);
    }

    /// References the base at its switch, and J2 and J3 by their sensors: no step counts as lost
    /// any more.
    pub(crate) fn set_base(&mut self, now: ArmInstant, geometry: &Geometry, switch: f64) {
        let really = self.true_pose(now).joints;
        let j1 = switch;
        self.place_at(geometry, JointAngles { j1, ..really });
        self.slip = [0.0; 4];
        self.base = 0.0;
        self.homed = true;
    }

    /// Sets the reported joints without a motion; the true ones stay.
    pub(crate) fn set_reported(
        &mut self,
        now: ArmInstant,
        geometry: &Geometry,
        joints: JointAngles,
    ) {
        let really = self.true_pose(now).joints;
        self.place_at(geometry, joints);
        self.stand_at(really);
    }

    /// Moves the arm by something other than its motors. Encoder and sensors follow; the base angle
    /// stays unknown.
    pub(crate) fn move_by_hand(
        &mut self,
        now: ArmInstant,
        geometry: &Geometry,
        really: JointAngles,
        world: &mut World,
    ) {
        let base = self.base;
        let j1 = really.j1 - base;
        self.place_at(geometry, JointAngles { j1, ..really });
        self.forget_base(base);
        // The world sees a motion of no duration, so that contacts and ink are updated.
        let pose = |now| self.true_pose(now);
        let there = TimedPath::new(now, now, &pose);
        world.begin(&there);
        world.end(&there);
    }

    /// Sets the true joints of an arm at rest, whatever is commanded.
    pub(super) fn stand_at(&mut self, really: JointAngles) {
        let (really, commanded) = (really.to_array(), self.rest.joints.to_array());
        let pairs = really.into_iter().zip(commanded);
        for (slip, (really, commanded)) in self.slip.iter_mut().zip(pairs) {
            *slip = really - commanded;
        }
    }

    /// Stalls J2 and J3: until the motion ends they stand still and lose their steps.
    pub(crate) fn stall(&mut self, now: ArmInstant, world: &mut World) {
        self.end_path(now, world);
        let [_, j2, j3, _] = self.true_pose(now).joints.to_array();
        if let Some(motion) = &mut self.under_way {
            // The first stall counts; a later one cannot move the joints again.
            motion.stalled.get_or_insert((now, [j2, j3]));
        }
        self.show_path(now, world);
    }

    /// Lets a joint slip: from now on its true angle differs.
    pub(crate) fn slip(&mut self, now: ArmInstant, joint: u8, degrees: f64, world: &mut World) {
        if !degrees.is_finite() {
            return;
        }
        self.end_path(now, world);
        let joint = usize::from(joint).checked_sub(1);
        if let Some(slip) = joint.and_then(|at| self.slip.get_mut(at)) {
            *slip = (*slip + degrees).clamp(-MAX_SLIP, MAX_SLIP);
        }
        self.show_path(now, world);
    }
}

/// The world's view of a motion.
impl Motion {
    /// Shows the world the motion from now on.
    pub(crate) fn show_path(&mut self, now: ArmInstant, world: &mut World) {
        if let Some(motion) = &mut self.under_way {
            motion.shown = now;
        }
        if let Some(motion) = &self.under_way {
            let pose = |now| self.way(now);
            world.begin(&TimedPath::new(motion.shown, motion.ends, &pose));
        }
    }

    /// Tells the world what the motion has done up to now.
    pub(crate) fn end_path(&self, now: ArmInstant, world: &mut World) {
        if let Some(motion) = &self.under_way {
            let to = now.min(motion.ends);
            let pose = |now| self.way(now);
            world.end(&TimedPath::new(motion.shown, to, &pose));
        }
    }

    /// Traces of pen and laser, with those of the running motion.
    pub(crate) fn drawing(&self, now: ArmInstant, world: &World) -> Drawing {
        let pose = |now| self.way(now);
        let path = (self.under_way.as_ref())
            .map(|motion| TimedPath::new(motion.shown, motion.ends, &pose));
        world.drawing_at(now, path.as_ref())
    }
}
