//! From three points to a trajectory round an arc (model section 9).

use crate::arc::Arc;
use crate::arc_segment::ArcSegment;
use crate::move_segment::MoveSegment;
use crate::{ArmState, MotionError, Plan, Planner, Pose, Trajectory, Unreachable};

impl Planner {
    /// Plans a circular arc from rest: from where the arm is through `via` to `to`, in the plane of the three points
    /// and in the sense that `via` fixes, less than once round (model section 9).
    ///
    /// The way round the arc keeps the linear speeds of [`speeds`](Self::speeds), into which the caller puts the set
    /// for arcs. Meanwhile r goes straight from its present value to `to.r` by the rotation speeds, each profile
    /// stretched to the longer one; `via.r` is ignored. The profile bounds velocity and acceleration along the arc and
    /// not the acceleration towards its centre, as the arm's own.
    ///
    /// `to` must be within reach and limits, and `via` too, but for J4. An arc that leaves them on the way ends there,
    /// and the plan says so in its [`crossing`](Plan::crossing); found by enclosures that pass over no crossing
    /// (none deeper than rounding errors, or 0.001 mm on an arc that hugs a limit all along).
    ///
    /// # Errors
    ///
    /// [`Unreachable::NotFinite`] for a point that is not one, [`MotionError::Coincident`] and
    /// [`MotionError::Collinear`] for points that make no circle, [`MotionError::Unreachable`] and
    /// [`MotionError::Limit`] for `to` or `via`, [`MotionError::Speed`] for a speed that the motion needs.
    pub fn arc(&self, from: &ArmState, via: &Pose, to: &Pose) -> Result<Plan, MotionError> {
        if !to.r.is_finite() {
            return Err(Unreachable::NotFinite.into());
        }
        let arc = Arc::through(&from.pose, via, to)?;
        let end = ArmState::at_pose(&self.geometry, to, &self.limits)?;
        self.check_place(via)?;
        self.round(from, &end, arc, arc.length())
    }

    /// Plans `count` full turns from rest on the circle through where the arm is, `via` and `to`, in the sense of the
    /// [`arc`](Self::arc) through them, back to exactly where they began (model section 9).
    ///
    /// r stays what it is all the way, so J4 turns against J1; the rotations of both poses are ignored. The whole is
    /// one motion, without a stop between turns. No turn at all is no motion, and then the points do not matter.
    ///
    /// # Errors
    ///
    /// As [`arc`](Self::arc).
    pub fn circle(
        &self,
        from: &ArmState,
        via: &Pose,
        to: &Pose,
        count: u32,
    ) -> Result<Plan, MotionError> {
        if count == 0 {
            let trajectory = Trajectory::at_rest(&self.geometry, from);
            return Ok(Plan::within(trajectory, &self.limits));
        }
        let arc = Arc::through(&from.pose, via, to)?;
        self.check_place(to)?;
        self.check_place(via)?;
        self.round(from, from, arc, arc.turn() * f64::from(count))
    }

    /// Whether the tool can be at a place, however it is turned there.
    fn check_place(&self, pose: &Pose) -> Result<(), MotionError> {
        let place = Pose { r: 0.0, ..*pose };
        self.geometry
            .inverse_within(&place, &self.limits.in_space())
            .map(|_| ())
    }

    fn round(
        &self,
        from: &ArmState,
        to: &ArmState,
        arc: Arc,
        way: f64,
    ) -> Result<Plan, MotionError> {
        from.check_invertible(&self.geometry)?;
        let [along, turning] = self.tool_profiles(way, to.pose.r - from.pose.r)?;
        let segment = MoveSegment::Arc(ArcSegment {
            from: *from,
            to: *to,
            arc,
            along,
            turning,
        });
        let trajectory = self.trajectory(from, [segment]);
        Ok(Plan::within(trajectory, &self.limits))
    }
}
