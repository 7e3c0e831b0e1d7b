//! First crossing of a limit, given all times at which one is possible.

use crate::{JointAngles, Limits, MotionError};

/// Times at which a motion may cross a bound. Stored in place, sorted on demand.
#[derive(Clone, Debug)]
pub(crate) struct CrossingTimes {
    times: [f64; Self::CAPACITY],
    count: usize,
}

impl CrossingTimes {
    /// Above the largest number of times at which a path can cut the boundaries of the workspace,
    /// 248. An arc meets fifteen circles: the bounds of J2, J3 and J2 - J3, each as configured and
    /// as widened to the start, and the edges of reach. Each circle has at most eight cuts, each
    /// reported at most twice. The planes of J1 have eight more.
    const CAPACITY: usize = 256;

    pub(crate) fn new() -> Self {
        Self {
            times: [0.0; Self::CAPACITY],
            count: 0,
        }
    }

    /// Adds a time. Only positive finite values count; others are ignored.
    pub(crate) fn add(&mut self, time: f64) {
        if time > 0.0
            && time.is_finite()
            && let Some(slot) = self.times.get_mut(self.count)
        {
            *slot = time;
            self.count += 1;
        }
    }

    /// Returns the times in order.
    pub(crate) fn sorted(&mut self) -> &[f64] {
        let times = self.times.get_mut(..self.count).unwrap_or_default();
        times.sort_unstable_by(f64::total_cmp);
        times
    }
}

/// Returns the start of the first span between `moments` in which the limits are violated, and the
/// error.
///
/// The moments include every passing of a bound, so a span is inside or outside as a whole and its
/// middle decides. A bound that the start violates is widened to the start until the motion has
/// come back within it: a motion back into the limits is allowed (model section 4).
pub(crate) fn first_violation(
    limits: &Limits,
    start: &JointAngles,
    mut moments: CrossingTimes,
    duration: f64,
    joints_at: impl Fn(f64) -> Result<JointAngles, MotionError>,
) -> Option<(f64, MotionError)> {
    let mut in_force = limits.widened_to(start);
    let mut from = 0.0;
    let inner = moments.sorted().iter().copied().filter(|t| *t < duration);
    for to in inner.chain([duration]) {
        if to > from {
            let joints = match joints_at(0.5 * (from + to)) {
                Ok(joints) => joints,
                Err(error) => return Some((from, error)),
            };
            if let Err(error) = in_force.check(&joints) {
                return Some((from, as_set(limits, error)));
            }
            in_force = in_force.narrowed_at(limits, &joints);
            from = to;
        }
    }
    None
}

/// Restates a violation of a widened bound with the bound as configured.
fn as_set(limits: &Limits, error: MotionError) -> MotionError {
    match error {
        MotionError::Limit { bound, value, .. } => limits.violation(bound, value),
        error => error,
    }
}
