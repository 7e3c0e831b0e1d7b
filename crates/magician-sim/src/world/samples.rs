//! Sampling of a path, and bisection of the changes on it.
//!
//! The tool moves about a millimetre between two samples, and every change between two samples is
//! bisected to its microsecond. A change that begins and ends between two samples is missed.

use super::ObjectPose;
use crate::{ArmInstant, Micros};

/// Most samples of a path; it bounds the cost of one motion.
const MAX_SAMPLES: u64 = 2048;
/// Distance between two samples, mm.
const STRIDE: f64 = 1.0;
/// Distance that a corner of a held object moves per degree of rotation, mm. The value is that of
/// an object of 60 mm.
const MM_PER_DEGREE: f64 = 0.5;
/// Spacing of the samples that measure the length of a path, us: the arm cannot move there and back
/// within 5 ms.
const COARSE: Micros = 5_000;
/// Fewest of these samples.
const COARSE_FEWEST: u64 = 4;
/// Most of these samples. Above 320 ms of path their spacing exceeds [`COARSE`].
const COARSE_MOST: u64 = 64;

/// Sample times of a path: evenly spaced, both ends included.
#[derive(Clone, Copy)]
pub(super) struct SampleTimes {
    pub(super) from: ArmInstant,
    span: Micros,
    pub(super) count: u64,
}

impl SampleTimes {
    pub(super) fn at(&self, nth: u64) -> ArmInstant {
        let (whole, part) = (self.span / self.count, self.span % self.count);
        self.from
            .after_micros(whole * nth + part * nth / self.count)
    }

    /// Chooses the number of samples by the length of the tool's path.
    pub(super) fn along(
        from: ArmInstant,
        to: ArmInstant,
        tip: impl Fn(ArmInstant) -> ObjectPose,
    ) -> Self {
        let span = to.micros_since(from);
        let coarse = Self {
            from,
            span,
            count: (span / COARSE).clamp(COARSE_FEWEST, COARSE_MOST),
        };
        let mut length = 0.0;
        let mut last = tip(from);
        for nth in 1..=coarse.count {
            let next = tip(coarse.at(nth));
            let [x, y, z] = [next.x - last.x, next.y - last.y, next.z - last.z];
            length +=
                libm::sqrt(x * x + y * y + z * z) + (next.yaw - last.yaw).abs() * MM_PER_DEGREE;
            last = next;
        }
        // A conversion from float saturates; NaN gives 0.
        let count = ((length / STRIDE) as u64).clamp(coarse.count, MAX_SAMPLES);
        Self { count, ..coarse }
    }
}

/// First microsecond at which a condition holds, by bisection between `not` and `so`.
pub(super) fn first(
    mut not: ArmInstant,
    mut so: ArmInstant,
    is_so: impl Fn(ArmInstant) -> bool,
) -> ArmInstant {
    if is_so(not) {
        return not;
    }
    while so.micros_since(not) > 1 {
        let middle = not.after_micros(so.micros_since(not) / 2);
        if is_so(middle) {
            so = middle;
        } else {
            not = middle;
        }
    }
    so
}
