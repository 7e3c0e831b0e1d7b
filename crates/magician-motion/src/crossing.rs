//! The first crossing of a limit, given every moment at which there may be one.

use crate::{JointAngles, Limits, MotionError};

/// Moments of a motion at which something may change, in order, kept in place.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    times: [f64; Self::CAPACITY],
    count: usize,
}

impl Moments {
    /// More than the boundaries of the workspace can cut a path. On an arc fifteen circles (the bounds of J2, J3 and
    /// J2 - J3, each also where the start lies beyond it, and the edges of reach) have at most eight cuts each,
    /// reported twice at worst, and the planes of J1 eight.
    const CAPACITY: usize = 256;

    pub(crate) fn new() -> Self {
        Self {
            times: [0.0; Self::CAPACITY],
            count: 0,
        }
    }

    /// Adds a moment; one that is not a positive number is nothing.
    pub(crate) fn add(&mut self, time: f64) {
        if time > 0.0
            && time.is_finite()
            && let Some(slot) = self.times.get_mut(self.count)
        {
            *slot = time;
            self.count += 1;
        }
    }

    /// The moments in order.
    pub(crate) fn sorted(&mut self) -> &[f64] {
        let times = self.times.get_mut(..self.count).unwrap_or_default();
        times.sort_unstable_by(f64::total_cmp);
        times
    }
}

/// The first of the spans between `moments` in which the limits are violated: when it begins, and how.
///
/// The moments hold every passing of a bound, so a span is inside or outside as a whole and its middle speaks for it.
/// A bound that the start violates is let out to where the start is until the motion has come back within.
pub(crate) fn first_violation(
    limits: &Limits,
    start: &JointAngles,
    mut moments: Moments,
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

/// A violation of a bound let out, told with the bound as it is set.
fn as_set(limits: &Limits, error: MotionError) -> MotionError {
    match error {
        MotionError::Limit { bound, value, .. } => limits.violation(bound, value),
        error => error,
    }
}
