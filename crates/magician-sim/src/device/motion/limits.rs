//! The joint limits as alarms (model section 4).

use magician_motion::{Bound, JointAngles, Limits};
use magician_protocol::Alarm;

/// A joint this close to a bound stands at it, deg; the arm's step is 0.01125.
const AT: f64 = 1e-6;

/// The alarm of a bound, 0x40 to 0x49.
pub(crate) fn alarm_of(bound: Bound) -> u8 {
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

/// Whether the joints stand at a bound or beyond it.
pub(crate) fn is_at(bound: Bound, limits: &Limits, joints: &JointAngles) -> bool {
    let (value, limit) = (bound.value(joints), limits.at(bound));
    if bound.is_upper() {
        value >= limit - AT
    } else {
        value <= limit + AT
    }
}
