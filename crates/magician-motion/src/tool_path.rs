//! Search for limits along motions whose tool follows a path in space while r has its own profile.

use crate::crossing::{CrossingTimes, first_violation};
use crate::velocity_profile::{CORNERS, VelocityProfile};
use crate::{ArmState, Bound, Geometry, JointAngles, Limits, MotionError, Pose, wrist};

/// Most times between which a path is smooth.
pub(crate) const MAX_CORNERS: usize = 2 * CORNERS + 1;

/// Returns the corners of both profiles of a path, and one more time.
pub(crate) fn moments(
    along: &VelocityProfile,
    turning: &VelocityProfile,
    more: f64,
) -> [f64; MAX_CORNERS] {
    let mut moments = [more; MAX_CORNERS];
    let corners = along.corners().into_iter().chain(turning.corners());
    for (slot, corner) in moments.iter_mut().zip(corners) {
        *slot = corner;
    }
    moments
}

/// Path of a tool, as the search for limits needs it.
pub(crate) trait ToolPath {
    fn start(&self) -> &ArmState;

    fn pose_at(&self, t: f64) -> Pose;

    /// Time for which the path must be followed, seconds: to its end, or until it repeats itself.
    fn horizon(&self) -> f64;

    /// Reports every time at which the path may pass a bound of `strict`, or of `wide` where it
    /// differs, or leave the reach.
    fn spatial_cuts(
        &self,
        geometry: &Geometry,
        strict: &Limits,
        wide: &Limits,
        report: &mut impl FnMut(f64),
    );

    /// Upper and lower bound of J4 on the whole path; `None` if not known without a search.
    fn j4_extremes(&self, geometry: &Geometry) -> (Option<f64>, Option<f64>);

    /// Times between which [`j4_rates`](Self::j4_rates) holds, in any order.
    fn corners(&self, geometry: &Geometry) -> [f64; MAX_CORNERS];

    /// Bounds of the rate of J4 between two times without a corner in between, deg/s.
    fn j4_rates(&self, geometry: &Geometry, a: f64, b: f64) -> (f64, f64);

    /// State at `t`. The path is known to be in reach, so the joints follow from the pose.
    fn state_at(&self, geometry: &Geometry, t: f64) -> ArmState {
        let pose = self.pose_at(t);
        let joints = geometry.inverse_at_edge(&pose);
        ArmState {
            pose,
            joints: joints.unwrap_or(self.start().joints),
        }
    }

    /// Returns the time at which the path first leaves limits or reach, seconds, and the cause.
    fn first_crossing(&self, geometry: &Geometry, limits: &Limits) -> Option<(f64, MotionError)>
    where
        Self: Sized,
    {
        let spatial = limits.without_j4();
        let horizon = self.horizon();
        let found = spatial_crossing(
            geometry,
            &spatial,
            horizon,
            |t| self.pose_at(t),
            |wide, report| self.spatial_cuts(geometry, &spatial, wide, &mut |t| report(t)),
        );
        let end = found.map_or(horizon, |(t, _)| t);
        let whole = found.is_none();
        wrist::first_crossing(self, geometry, limits, end, whole)
            .map(|t| (t, self.j4_violation(geometry, limits, t)))
            .or(found)
    }

    fn j4_violation(&self, geometry: &Geometry, limits: &Limits, t: f64) -> MotionError {
        let value = self.state_at(geometry, t).joints.j4;
        if value - limits.j4.min < limits.j4.max - value {
            limits.violation(Bound::J4Min, value)
        } else {
            limits.violation(Bound::J4Max, value)
        }
    }
}

/// Returns the first time at which a path leaves the reach or one of the `spatial` limits, which
/// must leave J4 free.
///
/// `pose_at` gives the pose of the tool. `cuts` reports every time at which the path may pass a
/// bound, given the limits widened to the start of the path.
pub(crate) fn spatial_crossing(
    geometry: &Geometry,
    spatial: &Limits,
    horizon: f64,
    pose_at: impl Fn(f64) -> Pose,
    cuts: impl FnOnce(&Limits, &mut dyn FnMut(f64)),
) -> Option<(f64, MotionError)> {
    let start = match geometry.inverse(&pose_at(0.0)) {
        Ok(joints) => joints,
        Err(error) => return Some((0.0, error)),
    };
    let mut moments = CrossingTimes::new();
    cuts(&spatial.widened_to(&start), &mut |t| moments.add(t));
    let (t, error) = first_violation(spatial, &start, moments, horizon, |t| {
        geometry.inverse(&pose_at(t))
    })?;
    let passed = geometry.inverse_at_edge(&pose_at(t));
    Some((
        t,
        passed.map_or(error, |at| on_its_side(spatial, &at, error)),
    ))
}

/// Restates a violation of J1 with the bound that the base really passed. Behind the arm J1 is half
/// a turn to either side, and the sampled point may have come out on the other side.
fn on_its_side(limits: &Limits, passing: &JointAngles, error: MotionError) -> MotionError {
    let (other, turn) = match error {
        MotionError::Limit {
            bound: Bound::J1Min,
            ..
        } => (Bound::J1Max, 360.0),
        MotionError::Limit {
            bound: Bound::J1Max,
            ..
        } => (Bound::J1Min, -360.0),
        _ => return error,
    };
    match error {
        MotionError::Limit { value, limit, .. }
            if libm::fabs(passing.j1 - limits.at(other)) < libm::fabs(passing.j1 - limit) =>
        {
            limits.violation(other, value + turn)
        }
        error => error,
    }
}
