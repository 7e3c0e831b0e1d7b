//! Looking at a course for what changes on it.
//!
//! A course is looked at often enough that the tool goes about a millimetre between two looks, and every change
//! between two looks is narrowed down to its microsecond. What begins and ends between two looks is missed.

use super::Place;
use crate::Micros;

/// The fewest looks at a course.
const FEWEST: u64 = 64;
/// The most looks at a course.
const MOST: u64 = 2048;
/// How far the tool goes between two looks if these are enough, mm.
const STRIDE: f64 = 1.0;

/// The instants at which a course is looked at: evenly spread, the first and the last included.
#[derive(Clone, Copy)]
pub(super) struct Looks {
    pub(super) from: Micros,
    span: Micros,
    pub(super) count: u64,
}

impl Looks {
    pub(super) fn at(&self, nth: u64) -> Micros {
        let (whole, part) = (self.span / self.count, self.span % self.count);
        self.from + whole * nth + part * nth / self.count
    }

    /// As many as the length of the tool's way asks for.
    pub(super) fn along(from: Micros, to: Micros, tip: impl Fn(Micros) -> Place) -> Self {
        let span = to.saturating_sub(from);
        let coarse = Self {
            from,
            span,
            count: FEWEST,
        };
        let mut length = 0.0;
        let mut last = tip(from);
        for nth in 1..=FEWEST {
            let next = tip(coarse.at(nth));
            let [x, y] = [next.x - last.x, next.y - last.y];
            length += libm::sqrt(x * x + y * y) + (next.z - last.z).abs();
            last = next;
        }
        // A conversion of a float saturates; NaN is 0.
        let count = ((length / STRIDE) as u64).clamp(FEWEST, MOST);
        Self { count, ..coarse }
    }
}

/// The first microsecond that is so, between one that may not be and one that is.
pub(super) fn first(mut not: Micros, mut so: Micros, is_so: impl Fn(Micros) -> bool) -> Micros {
    if is_so(not) {
        return not;
    }
    while so - not > 1 {
        let middle = not + (so - not) / 2;
        if is_so(middle) {
            so = middle;
        } else {
            not = middle;
        }
    }
    so
}
