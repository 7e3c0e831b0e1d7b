//! Motions with a minimum duration, for moves that share their time with the rail.

use crate::{ArmState, MotionError, Move, Plan, Planner};

impl Planner {
    /// Plans a motion from rest like [`plan`](Self::plan), with a duration of at least `least_us`.
    ///
    /// For moves that begin and end together with the rail (model section 7).
    ///
    /// A faster motion is stretched to exactly `least_us`, all segments by the same factor to the
    /// microsecond. Each axis keeps its velocity limit and accelerates more gently, as when it is
    /// stretched to the slowest axis. A limit on the way still ends the motion early. If nothing
    /// moves the plan takes no time.
    ///
    /// # Errors
    ///
    /// As for [`plan`](Self::plan).
    pub fn plan_with_min_duration(
        &self,
        from: &ArmState,
        request: &Move,
        least_us: u64,
    ) -> Result<Plan, MotionError> {
        let trajectory = self.fastest(from, request)?.lasting(least_us);
        Ok(Plan::within(trajectory, &self.limits))
    }
}
