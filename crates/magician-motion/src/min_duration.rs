//! Motions that wait for something slower.

use crate::{ArmState, MotionError, Move, Plan, Planner};

impl Planner {
    /// Plans a motion from rest as [`plan`](Self::plan) does, but one that takes no less than `least_us`: for moves
    /// that begin and end together with the rail (model section 7).
    ///
    /// A motion that is quicker is slowed to exactly `least_us`, all its segments by the same factor to the microsecond,
    /// by the profile that stretches an axis to the slowest: at the velocity set where that is needed, more gently
    /// accelerated. A limit on the way still ends it early. Where there is nothing to move the plan takes no time,
    /// whatever `least_us` is.
    ///
    /// # Errors
    ///
    /// As [`plan`](Self::plan).
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
