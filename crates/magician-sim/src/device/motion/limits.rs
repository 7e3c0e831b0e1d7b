//! Limit alarms of the joints, and the moment at which one drops because its joint is back inside
//! (model section 4).

use magician_motion::{Bound, JointAngles, Limits, Trajectory};
use magician_protocol::{Alarm, AlarmSet};

use super::Motion;
use crate::{ArmInstant, Micros};

/// Distance from a bound at which a joint counts as standing at it, deg. The motor step is 0.01125
/// deg, and the planner stops on the bound itself.
const LIMIT_PROXIMITY: f64 = 1e-6;

/// Alarm of a bound, 0x40 to 0x49. It is raised when a motion ends there.
pub(crate) fn limit_alarm(bound: Bound) -> u8 {
    match bound {
        Bound::J1Max => Alarm::LimitAxis1Pos,
        Bound::J1Min => Alarm::LimitAxis1Neg,
        Bound::J2Max => Alarm::LimitAxis2Pos,
        Bound::J2Min => Alarm::LimitAxis2Neg,
        Bound::J3Max => Alarm::LimitAxis3Pos,
        Bound::J3Min => Alarm::LimitAxis3Neg,
        Bound::J4Max => Alarm::LimitAxis4Pos,
        Bound::J4Min => Alarm::LimitAxis4Neg,
        Bound::J23Max => Alarm::LimitAxis23Pos,
        Bound::J23Min => Alarm::LimitAxis23Neg,
    }
}

/// True if the joints are at a bound or beyond it.
fn is_at(bound: Bound, limits: &Limits, joints: &JointAngles) -> bool {
    let (value, limit) = (bound.value(joints), limits.at(bound));
    if bound.is_upper() {
        value >= limit - LIMIT_PROXIMITY
    } else {
        value <= limit + LIMIT_PROXIMITY
    }
}

impl Motion {
    /// True if the cause of a limit alarm persists: a joint is at its limit.
    pub(crate) fn limit_stands(&self, now: ArmInstant, limits: &Limits, code: u8) -> bool {
        let joints = self.joints(now);
        Bound::ALL
            .into_iter()
            .any(|bound| limit_alarm(bound) == code && is_at(bound, limits, &joints))
    }

    /// Computes when the motion takes a joint back inside, among those whose limit alarm stands.
    pub(crate) fn watch_limits(&mut self, now: ArmInstant, limits: &Limits, standing: AlarmSet) {
        let Some(motion) = &mut self.under_way else {
            return;
        };
        let from = motion.elapsed(now);
        let leaving = |trajectory: &Trajectory| {
            let leaves = |bound: Bound| {
                let outside = |t| is_at(bound, limits, &trajectory.sample(t).joints);
                first_inside(from, trajectory.duration_us(), outside)
            };
            Bound::ALL
                .into_iter()
                .filter(|bound| standing.contains(limit_alarm(*bound)))
                .filter_map(leaves)
                .min()
        };
        motion.leaves_limit = leaving(&motion.trajectory).map(|t| motion.started.after_micros(t));
    }
}

/// Number of samples over a motion. Needed because a motion may leave the limits and return.
const SAMPLES: Micros = 64;

/// First microsecond after `from` that is inside, by sampling and bisection.
///
/// A motion that is inside for less than 1/64 of its time may be missed; the alarm then drops at
/// its end.
fn first_inside(from: Micros, to: Micros, outside: impl Fn(Micros) -> bool) -> Option<Micros> {
    let span = to.saturating_sub(from);
    let look = |step: Micros| from + span / SAMPLES * step + span % SAMPLES * step / SAMPLES;
    let first = (1..=SAMPLES).find(|step| !outside(look(*step)))?;
    let (mut out, mut inside) = (look(first - 1), look(first));
    while inside - out > 1 {
        let middle = out + (inside - out) / 2;
        if outside(middle) {
            out = middle;
        } else {
            inside = middle;
        }
    }
    Some(inside)
}
