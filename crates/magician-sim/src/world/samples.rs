//! Looking at a path for what changes on it.
//!
//! A path is looked at often enough that the tool goes about a millimetre between two looks, and
//! every change between two looks is narrowed down to its microsecond. What begins and ends between
//! two looks is missed.

use super::ObjectPose;
use crate::{ArmInstant, Micros};

/// The most looks at a path.
const MOST: u64 = 2048;
/// How far the tool goes between two looks if these are enough, mm.
const STRIDE: f64 = 1.0;
/// How far a corner of what the tool holds goes when the tool turns by a degree, mm: as in an
/// object of 60 mm.
const TURN: f64 = 0.5;
/// How many looks it takes to know the length of a path: one in so many microseconds, within
/// bounds. A tool that goes and comes back in less than that is not something that this arm does.
const COARSE: Micros = 5_000;
const COARSE_FEWEST: u64 = 4;
const COARSE_MOST: u64 = 64;

/// The instants at which a path is looked at: evenly spread, the first and the last included.
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

    /// As many as the length of the tool's way asks for.
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
            length += libm::sqrt(x * x + y * y + z * z) + (next.yaw - last.yaw).abs() * TURN;
            last = next;
        }
        // A conversion of a float saturates; NaN is 0.
        let count = ((length / STRIDE) as u64).clamp(coarse.count, MOST);
        Self { count, ..coarse }
    }
}

/// The first microsecond that is so, between one that may not be and one that is.
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
