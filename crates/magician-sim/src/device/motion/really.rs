//! Where the arm really is, beside where it is commanded to be, and what the world sees of it (model sections 11 and 12).

use magician_motion::JointAngles;

use super::Motion;
use crate::Micros;
use crate::device::Device;
use crate::world::{Course, Drawing, Posture};

/// No joint is further from where it is commanded to be, deg: a full turn.
const MOST_SLIP: f64 = 360.0;

impl Motion {
    /// Where the arm really is.
    pub(crate) fn posture(&self, now: Micros) -> Posture {
        self.really(now, self.commanded(now).joints)
    }

    /// Where the arm really is when it is commanded to be there.
    pub(crate) fn really(&self, now: Micros, commanded: JointAngles) -> Posture {
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
        Posture {
            joints: joints.into(),
            rail: self.rail.really(self.rail_at(now)),
        }
    }

    /// The joints are where they are commanded to be.
    pub(super) fn forget_slip(&mut self) {
        self.slip = [0.0; 4];
        self.base = 0.0;
    }

    /// J1 does not know where the base stands: it is so much further than its encoder says.
    pub(crate) fn forget_base(&mut self, base: f64) {
        self.slip = [base, 0.0, 0.0, 0.0];
        self.base = base;
    }

    /// By how much the base encoder and the sensors of J2 and J3 say that the joints are off (model section 12).
    pub(crate) fn lost(&self, now: Micros) -> [f64; 3] {
        let (really, commanded) = (self.posture(now).joints, self.commanded(now).joints);
        [
            really.j1 - self.base - commanded.j1,
            really.j2 - commanded.j2,
            really.j3 - commanded.j3,
        ]
    }

    fn stall(&mut self, now: Micros) {
        let [_, j2, j3, _] = self.posture(now).joints.to_array();
        if let Some(motion) = &mut self.under_way {
            motion.stalled.get_or_insert((now, [j2, j3]));
        }
    }
}

impl Device {
    /// Where the arm really is at the present instant.
    pub(crate) fn posture(&self) -> Posture {
        self.motion.posture(self.now)
    }

    /// Puts the commanded joints somewhere without a motion; the arm really stands where it stood.
    pub(crate) fn believe(&mut self, joints: JointAngles) {
        let really = self.posture().joints;
        self.place_at(joints);
        self.stand_at(really);
    }

    /// J2 and J3 are commanded to be where their sensors say that they are, and J1 where its encoder does.
    pub(crate) fn read_sensors(&mut self) {
        let really = self.posture().joints;
        self.be_moved(really);
    }

    /// Something else than its motors has brought the arm somewhere, and encoder and sensors see it. J1 stays as unsure
    /// as it was.
    pub(crate) fn be_moved(&mut self, really: JointAngles) {
        let base = self.motion.base;
        let j1 = really.j1 - base;
        self.place_at(JointAngles { j1, ..really });
        self.motion.forget_base(base);
        let Self {
            motion, world, now, ..
        } = self;
        let posture = |now| motion.posture(now);
        let there = Course::new(*now, *now, &posture);
        world.begin(&there);
        world.end(&there);
    }

    /// The arm at rest really stands there, whatever is commanded.
    pub(super) fn stand_at(&mut self, really: JointAngles) {
        let (really, commanded) = (really.to_array(), self.motion.rest.joints.to_array());
        for (slip, (really, commanded)) in self
            .motion
            .slip
            .iter_mut()
            .zip(really.into_iter().zip(commanded))
        {
            *slip = really - commanded;
        }
    }

    /// Shows the world what the arm is going to do from now on.
    pub(crate) fn show_course(&mut self) {
        if let Some(motion) = &mut self.motion.under_way {
            motion.shown = self.now;
        }
        let Self { motion, world, .. } = self;
        if let Some(under_way) = &motion.under_way {
            world.begin(&Course::new(under_way.shown, under_way.ends, &|now| {
                motion.posture(now)
            }));
        }
    }

    /// What pen and laser have left, with what the motion under way has added.
    pub(crate) fn drawing(&self) -> Drawing {
        let posture = |now| self.motion.posture(now);
        let course = (self.motion.under_way.as_ref())
            .map(|motion| Course::new(motion.shown, motion.ends, &posture));
        self.world.drawing_at(self.now, course.as_ref())
    }

    /// Tells the world what the arm has done up to now.
    pub(crate) fn end_course(&mut self) {
        let Self { motion, world, .. } = self;
        if let Some(under_way) = &motion.under_way {
            let to = self.now.min(under_way.ends);
            world.end(&Course::new(under_way.shown, to, &|now| {
                motion.posture(now)
            }));
        }
    }

    /// J2 and J3 stall: until the motion ends they stay where they are and lose their steps.
    pub(crate) fn stall(&mut self) {
        self.end_course();
        self.motion.stall(self.now);
        self.show_course();
    }

    /// A joint slips: from now on it stands elsewhere than commanded.
    pub(crate) fn slip(&mut self, joint: u8, degrees: f64) {
        if !degrees.is_finite() {
            return;
        }
        self.end_course();
        if let Some(slip) = usize::from(joint)
            .checked_sub(1)
            .and_then(|at| self.motion.slip.get_mut(at))
        {
            *slip = (*slip + degrees).clamp(-MOST_SLIP, MOST_SLIP);
        }
        self.show_course();
    }
}
