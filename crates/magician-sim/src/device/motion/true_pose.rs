//! Where the arm really is, beside where it is commanded to be, and what the world sees of it
//! (model sections 11 and 12).

use magician_motion::{Geometry, JointAngles};

use super::Motion;
use crate::world::{Drawing, JointState, TimedPath};
use crate::{ArmInstant, World};

/// No joint is further from where it is commanded to be, deg: a full turn.
const MOST_SLIP: f64 = 360.0;

impl Motion {
    /// Where the arm really is.
    pub(crate) fn true_pose(&self, now: ArmInstant) -> JointState {
        self.true_pose_of(now, self.joints(now))
    }

    /// Where the arm really is on its way, between the ends of two periods as well: what the world
    /// sees.
    fn way(&self, now: ArmInstant) -> JointState {
        let (joints, rail) = self.on_the_way(now);
        JointState {
            rail: self.rail.true_place(rail),
            ..self.true_pose_of(now, joints)
        }
    }

    /// Where the arm really is when it is commanded to be there.
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

    /// J1 does not know where the base stands: it is so much further than its encoder says.
    fn forget_base(&mut self, base: f64) {
        self.slip = [base, 0.0, 0.0, 0.0];
        self.base = base;
    }

    /// The carriage on the rail stands so much further than the controller knows.
    pub(crate) fn forget_rail(&mut self, slip: f64) {
        self.rail.slip = slip;
    }

    /// From now on the controller knows where the carriage really is.
    pub(crate) fn find_rail(&mut self, now: ArmInstant) {
        self.rail.rest = self.true_pose(now).rail;
        self.rail.slip = 0.0;
    }

    /// By how much the base encoder and the sensors of J2 and J3 say that the joints are off (model
    /// section 12).
    pub(crate) fn lost(&self, now: ArmInstant) -> [f64; 3] {
        let (really, commanded) = (self.true_pose(now).joints, self.joints(now));
        [
            really.j1 - self.base - commanded.j1,
            really.j2 - commanded.j2,
            really.j3 - commanded.j3,
        ]
    }

    /// Power comes while the arm really stands somewhere: J1 reads what it reads at power-up, J2
    /// and J3 what their sensors say.
    pub(crate) fn wake_at(&mut self, now: ArmInstant, geometry: &Geometry, really: JointAngles) {
        let j1 = self.joints(now).j1;
        self.place_at(geometry, JointAngles { j1, ..really });
        self.forget_base(really.j1 - j1);
    }

    /// The base stands at its switch, and J2 and J3 are where their sensors say: no step counts as
    /// lost any more.
    pub(crate) fn set_base(&mut self, now: ArmInstant, geometry: &Geometry, switch: f64) {
        let really = self.true_pose(now).joints;
        let j1 = switch;
        self.place_at(geometry, JointAngles { j1, ..really });
        self.slip = [0.0; 4];
        self.base = 0.0;
        self.homed = true;
    }

    /// Sets the joints that are reported without a motion; the arm really stands where it stood.
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

    /// Something else than its motors has brought the arm somewhere, and encoder and sensors see
    /// it. J1 stays as unsure as it was.
    pub(crate) fn be_moved(
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
        let pose = |now| self.true_pose(now);
        let there = TimedPath::new(now, now, &pose);
        world.begin(&there);
        world.end(&there);
    }

    /// The arm at rest really stands there, whatever is commanded.
    pub(super) fn stand_at(&mut self, really: JointAngles) {
        let (really, commanded) = (really.to_array(), self.rest.joints.to_array());
        let pairs = really.into_iter().zip(commanded);
        for (slip, (really, commanded)) in self.slip.iter_mut().zip(pairs) {
            *slip = really - commanded;
        }
    }

    /// J2 and J3 stall: until the motion ends they stay where they are and lose their steps.
    pub(crate) fn stall(&mut self, now: ArmInstant, world: &mut World) {
        self.end_path(now, world);
        let [_, j2, j3, _] = self.true_pose(now).joints.to_array();
        if let Some(motion) = &mut self.under_way {
            motion.stalled.get_or_insert((now, [j2, j3]));
        }
        self.show_path(now, world);
    }

    /// A joint slips: from now on it stands elsewhere than commanded.
    pub(crate) fn slip(&mut self, now: ArmInstant, joint: u8, degrees: f64, world: &mut World) {
        if !degrees.is_finite() {
            return;
        }
        self.end_path(now, world);
        let joint = usize::from(joint).checked_sub(1);
        if let Some(slip) = joint.and_then(|at| self.slip.get_mut(at)) {
            *slip = (*slip + degrees).clamp(-MOST_SLIP, MOST_SLIP);
        }
        self.show_path(now, world);
    }
}

/// What the world is told of a motion.
impl Motion {
    /// Shows the world what the arm is going to do from now on.
    pub(crate) fn show_path(&mut self, now: ArmInstant, world: &mut World) {
        if let Some(motion) = &mut self.under_way {
            motion.shown = now;
        }
        if let Some(motion) = &self.under_way {
            let pose = |now| self.way(now);
            world.begin(&TimedPath::new(motion.shown, motion.ends, &pose));
        }
    }

    /// Tells the world what the arm has done up to now.
    pub(crate) fn end_path(&self, now: ArmInstant, world: &mut World) {
        if let Some(motion) = &self.under_way {
            let to = now.min(motion.ends);
            let pose = |now| self.way(now);
            world.end(&TimedPath::new(motion.shown, to, &pose));
        }
    }

    /// What pen and laser have left, with what the motion under way has added.
    pub(crate) fn drawing(&self, now: ArmInstant, world: &World) -> Drawing {
        let pose = |now| self.way(now);
        let path = (self.under_way.as_ref())
            .map(|motion| TimedPath::new(motion.shown, motion.ends, &pose));
        world.drawing_at(now, path.as_ref())
    }
}
