//! Planning of continuous-path segments, and replanning of a running one (model section 8).

use crate::move_segment::{MoveSegment, SHORTEST_MOVE};
use crate::path_segment::PathSegment;
use crate::speeds::finite_speed;
use crate::velocity_profile::KinematicLimits;
use crate::{ArmState, MotionError, Plan, Planner, Pose, SpeedQuantity, Trajectory};

impl Planner {
    /// Plans one straight segment of a continuous path, ending exactly at `to` (x, y, z).
    ///
    /// Joint 4 does not move, so r changes with joint 1.
    ///
    /// The speed is `entry` at the start and `exit` at the end, or as much of it as can be reached.
    /// A segment too short to slow down to `exit` brakes harder than `rates` allow. The rates are
    /// limited to the ceilings; [`LookAhead`](crate::LookAhead) computes exit and rates. The
    /// segment must end within reach and limits. If it leaves them on the way it ends there, and
    /// the plan has a crossing. A segment shorter than 0.0001 mm takes no time.
    ///
    /// # Errors
    ///
    /// [`MotionError::Unreachable`] and [`MotionError::Limit`] for the end; [`MotionError::Speed`]
    /// for rates that are NaN, zero or negative, and for an entry or exit that is negative or not
    /// finite.
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
        let segment = MoveSegment::Path(path);
        let trajectory = Trajectory::of_segment(&self.geometry, self.law, from, segment);
        Ok(Plan::within(trajectory, &self.limits))
    }

    /// Replans the rest of a running segment from a time on, towards a new exit speed.
    ///
    /// The tool stays on the line of the segment however often it is replanned, and ends exactly at
    /// its end. The geometry is that of the segment. Returns `None` if no segment is under way at
    /// that time.
    ///
    /// # Errors
    ///
    /// [`MotionError::Speed`] as for [`segment`](Self::segment).
    pub fn segment_rest(
        &self,
        running: &Trajectory,
        at_us: u64,
        exit: f64,
        rates: KinematicLimits,
    ) -> Result<Option<Plan>, MotionError> {
        let rates = self.ceilings.linear(rates)?;
        let exit = finite_speed(SpeedQuantity::LinearVelocity, exit)?;
        let Some((MoveSegment::Path(path), t)) = running.under_way(at_us) else {
            return Ok(None);
        };
        let rest = path.rest(t, |length, entry| {
            self.law.segment(length, entry, exit, &rates)
        });
        let from = running.sample(at_us);
        let segment = MoveSegment::Path(rest);
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
    /// Speed of the tool along its path at a time, mm/s.
    ///
    /// From the end on: the exit speed of a segment; zero for any other motion, or if a limit ends
    /// the motion.
    #[must_use]
    pub fn path_speed(&self, t_us: u64) -> f64 {
        match self.under_way(t_us) {
            Some((MoveSegment::Path(path), t)) => path.along.velocity(t),
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

    /// Exit speed of a segment of a continuous path, mm/s, with which the next one begins. Zero for
    /// any other motion, or if a limit ends the motion.
    #[must_use]
    pub fn exit_speed(&self) -> f64 {
        match self.last_segment() {
            Some(MoveSegment::Path(path)) => path.along.exit(),
            _ => 0.0,
        }
    }
}
