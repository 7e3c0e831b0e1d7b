//! Planning of arcs and circles through three points (model section 9).

use crate::arc::Arc;
use crate::arc_segment::ArcSegment;
use crate::move_segment::MoveSegment;
use crate::{ArmState, MotionError, Plan, Planner, Pose, Trajectory, Unreachable};

impl Planner {
    /// Plans a circular arc from rest, from the present pose through `via` to `to`.
    ///
    /// The arc lies in the plane of the three points, turns in the sense that `via` fixes, and is
    /// shorter than a full circle (model section 9).
    ///
    /// The length of the arc follows the linear speeds of [`speeds`](Self::speeds), where the
    /// caller puts the speeds of arcs. r goes from its present value to `to.r` at the rotation
    /// speeds; both profiles are stretched to the longer one, and `via.r` is ignored. As in the
    /// arm, the profile limits velocity and acceleration along the arc, but not the centripetal
    /// acceleration.
    ///
    /// `to` must be within reach and limits, and `via` too except for J4. An arc that leaves them
    /// on the way ends there, and the plan has a [`crossing`](Plan::crossing). The search misses no
    /// crossing deeper than rounding errors, or than 0.001 mm on an arc that follows a limit all
    /// along.
    ///
    /// # Errors
    ///
    /// [`Unreachable::NotFinite`] for a point that is NaN or infinite, [`MotionError::Coincident`]
    /// and [`MotionError::Collinear`] for points that make no circle, [`MotionError::Unreachable`]
    /// and [`MotionError::Limit`] for `to` or `via`, [`MotionError::Speed`] for an invalid speed
    /// that the motion needs.
    pub fn arc(&self, from: &ArmState, via: &Pose, to: &Pose) -> Result<Plan, MotionError> {
        if !to.r.is_finite() {
            return Err(Unreachable::NotFinite.into());
        }
        let arc = Arc::through(&from.pose, via, to)?;
        let end = ArmState::at_pose(&self.geometry, to, &self.limits)?;
        self.check_place(via)?;
        self.round(from, &end, arc, arc.length())
    }

    /// Plans `count` full turns from rest on the circle through the present pose, `via` and `to`.
    ///
    /// The turns have the sense of the [`arc`](Self::arc) through these points and end exactly
    /// where they began (model section 9).
    ///
    /// r stays constant, so J4 turns against J1; the rotations of both poses are ignored. All turns
    /// are one motion without stops. With a count of 0 nothing moves and the points are not
    /// checked.
    ///
    /// # Errors
    ///
    /// As for [`arc`](Self::arc).
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
        self.round(from, from, arc, arc.circumference() * f64::from(count))
    }

    /// Checks that the tool can be at a position, at any rotation.
    fn check_place(&self, pose: &Pose) -> Result<(), MotionError> {
        let place = Pose { r: 0.0, ..*pose };
        self.geometry
            .inverse_within(&place, &self.limits.without_j4())
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
