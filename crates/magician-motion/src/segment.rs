//! One segment of a continuous path, planned and planned again while it is under way (model section 8).

use crate::move_segment::{MoveSegment, SHORTEST_MOVE};
use crate::path_segment::PathSegment;
use crate::speeds::finite_speed;
use crate::velocity_profile::KinematicLimits;
use crate::{ArmState, MotionError, Plan, Planner, Pose, SpeedQuantity, Trajectory};

impl Planner {
    /// Plans one straight segment of a continuous path, which ends exactly at `to` (x, y, z) while joint 4 stands
    /// still, so that r goes along with joint 1.
    ///
    /// The speed is `entry` at first and `exit` at the end, or what of it can be gained on the way; a segment too
    /// short to come down to `exit` brakes harder than `rates` allow. The rates count up to the ceilings.
    /// [`LookAhead`](crate::LookAhead) tells exit and rates. The segment must end within reach and limits; where it
    /// leaves them on the way it ends, and the plan tells where. One shorter than 0.0001 mm takes no time.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] and [`MotionError::Limit`] for the end, [`MotionError::Speed`] for rates that are
    /// NaN, zero or negative, and an entry or exit that is negative or not finite.
    pub fn segment(
        &self,
        from: &ArmState,
        to: [f64; 3],
        entry: f64,
        exit: f64,
        rates: KinematicLimits,
    ) -> Result<Plan, MotionError> {
        let rates = self.ceilings.linear(rates)?;
        let entry = finite_speed(SpeedQuantity::LinearVelocity, entry)?;
        let exit = finite_speed(SpeedQuantity::LinearVelocity, exit)?;
        from.check_invertible(&self.geometry)?;
        let [x, y, z] = to;
        let to = self.end_of_segment(from, Pose { x, y, z, r: 0.0 })?;
        let length = from.pose.distance_to(&to.pose);
        if length < SHORTEST_MOVE {
            let trajectory = Trajectory::at_rest(&self.geometry, &to);
            return Ok(Plan::within(trajectory, &self.limits));
        }
        let path = PathSegment {
            from: *from,
            to,
            length,
            done: 0.0,
            along: self.law.segment(length, entry, exit, &rates),
        };
        let segment = MoveSegment::Segment(path);
        let trajectory = Trajectory::of_segment(&self.geometry, self.law, from, segment);
        Ok(Plan::within(trajectory, &self.limits))
    }

    /// Plans the rest of a segment under way, from its place and speed at a time on, towards a new exit speed. The
    /// tool stays on the segment's own line, whatever the number of times that it is planned again, and ends exactly
    /// where the segment does; the measures are the segment's own. Nothing if no segment is under way at that time.
    ///
    /// # Errors
    ///
    /// [`MotionError::Speed`] as [`segment`](Self::segment).
    pub fn segment_rest(
        &self,
        running: &Trajectory,
        at_us: u64,
        exit: f64,
        rates: KinematicLimits,
    ) -> Result<Option<Plan>, MotionError> {
        let rates = self.ceilings.linear(rates)?;
        let exit = finite_speed(SpeedQuantity::LinearVelocity, exit)?;
        let Some((MoveSegment::Segment(path), t)) = running.under_way(at_us) else {
            return Ok(None);
        };
        let rest = path.rest(t, |length, entry| {
            self.law.segment(length, entry, exit, &rates)
        });
        let from = running.sample(at_us);
        let segment = MoveSegment::Segment(rest);
        let trajectory = Trajectory::of_segment(running.geometry(), self.law, &from, segment);
        Ok(Some(Plan::within(trajectory, &self.limits)))
    }

    fn end_of_segment(&self, from: &ArmState, mut pose: Pose) -> Result<ArmState, MotionError> {
        let mut joints = self.geometry.inverse(&pose)?;
        joints.j4 = from.joints.j4;
        self.limits.check(&joints)?;
        pose.r = joints.j1 + joints.j4;
        Ok(ArmState { joints, pose })
    }
}

impl Trajectory {
    /// The speed of the tool along its path at a time, mm/s. From the end on it is that of the end: the exit speed of
    /// a segment, zero for any other motion and for one that a limit ends.
    #[must_use]
    pub fn path_speed(&self, t_us: u64) -> f64 {
        match self.under_way(t_us) {
            Some((MoveSegment::Segment(path), t)) => path.along.velocity(t),
            Some(_) => {
                let rate = self.tool_velocity(t_us);
                rate.distance_to(&Pose {
                    r: rate.r,
                    ..Pose::default()
                })
            }
            None => self.exit_speed(),
        }
    }

    /// The speed with which a segment of a continuous path ends, mm/s: what the next one begins with. Zero for any
    /// other motion, and for one that a limit ends.
    #[must_use]
    pub fn exit_speed(&self) -> f64 {
        match self.last_segment() {
            Some(MoveSegment::Segment(path)) => path.along.exit(),
            _ => 0.0,
        }
    }
}
