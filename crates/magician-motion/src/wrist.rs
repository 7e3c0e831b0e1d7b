//! Crossings of J4 with its limits on the path of a tool.
//!
//! J4 is r less J1. r follows its own profile of time and J1 the arc tangent of a point that moves
//! by another profile, so there is no closed form. But both profiles are monotone between their
//! corners. On a line so are the squared radius and its slope, up to the point closest to the base
//! axis; on an arc the curvature bounds their change. So on any span between corners the rate of J4
//! can be enclosed, and with it J4:
//!
//! * A span whose enclosure stays below the limit has no crossing.
//! * A span on which the rate keeps its sign has at most one, bracketed by its ends.
//! * Any other span is halved.
//!
//! No crossing is missed that lasts longer than the shortest span.

use crate::angle::DEGREES_PER_RADIAN;
use crate::roots::bisect;
use crate::tool_path::ToolPath;
use crate::velocity_profile::VelocityProfile;
use crate::{Geometry, LIMIT_TOLERANCE, Limits};

/// Shortest span that is halved, seconds: a tenth of a microsecond, the unit of time.
const SHORTEST_SPAN: f64 = 1e-7;
/// Most spans examined. Only a motion made to follow the limit needs that many; the rest of it is
/// then checked at the resolution reached.
const MAX_SPANS: u32 = 20_000;

/// J4 along a path. `side` is 1 to search for an upper limit, -1 for a lower one.
struct J4Search<'a, P> {
    path: &'a P,
    geometry: &'a Geometry,
    side: f64,
}

/// Returns the time at which J4 first passes one of its limits, between the start and `end`
/// seconds.
///
/// A start beyond a limit may come back in, but not go further out. `whole` is true if nothing else
/// ends the path before its end.
pub(crate) fn first_crossing<P: ToolPath>(
    path: &P,
    geometry: &Geometry,
    limits: &Limits,
    end: f64,
    whole: bool,
) -> Option<f64> {
    let (above, below) = if whole {
        path.j4_extremes(geometry)
    } else {
        (None, None)
    };
    let crossing = |side: f64, limit: f64, extreme: Option<f64>| {
        if extreme.is_some_and(|extreme| side * extreme <= side * limit) {
            return None;
        }
        J4Search {
            path,
            geometry,
            side,
        }
        .first_beyond(side * limit, end)
    };
    let upper = crossing(1.0, limits.j4.max, above);
    let lower = crossing(-1.0, limits.j4.min, below);
    match (upper, lower) {
        (Some(upper), Some(lower)) => Some(upper.min(lower)),
        (upper, lower) => upper.or(lower),
    }
}

impl<P: ToolPath> J4Search<'_, P> {
    fn first_beyond(&self, limit: f64, end: f64) -> Option<f64> {
        let start = self.value(0.0);
        if start <= limit + LIMIT_TOLERANCE {
            return self.first_above(limit, 0.0, end);
        }
        let outwards = self.first_above(start, 0.0, end);
        let inwards = self.mirrored().first_above(-limit, 0.0, end);
        match (outwards, inwards) {
            (Some(out), back) if back.is_none_or(|back| out < back) => Some(out),
            (_, Some(back)) => self.first_above(limit, back, end),
            (_, None) => None,
        }
    }

    fn mirrored(&self) -> Self {
        Self {
            side: -self.side,
            ..*self
        }
    }

    /// J4 times the side.
    fn value(&self, t: f64) -> f64 {
        let j4 = self.path.state_at(self.geometry, t).joints.j4;
        self.side * j4
    }

    /// Returns the first time between `a` and `b` at which the value exceeds `level`. It starts no
    /// higher.
    fn first_above(&self, level: f64, a: f64, b: f64) -> Option<f64> {
        let mut ends = self.path.corners(self.geometry);
        ends.sort_unstable_by(f64::total_cmp);
        let mut budget = MAX_SPANS;
        let mut from = a;
        for to in ends.into_iter().filter(|t| *t < b).chain([b]) {
            if to > from {
                let found = self.search(level, from, to, &mut budget);
                if found.is_some() {
                    return found;
                }
                from = to;
            }
        }
        None
    }

    fn search(&self, level: f64, a: f64, b: f64, budget: &mut u32) -> Option<f64> {
        *budget = budget.saturating_sub(1);
        let middle = 0.5 * (a + b);
        let half = 0.5 * (b - a);
        let (least, most) = self.rate(a, b);
        let steepest = most.max(-least);
        if self.value(middle) + steepest * half <= level + LIMIT_TOLERANCE {
            return None;
        }
        let last = b - a <= SHORTEST_SPAN || middle <= a || middle >= b || *budget == 0;
        if least >= 0.0 || most <= 0.0 || last {
            return self.rise(level, a, b);
        }
        self.search(level, a, middle, budget)
            .or_else(|| self.search(level, middle, b, budget))
    }

    /// Returns the time at which the value passes `level` on a span; `None` if its end is not
    /// above.
    fn rise(&self, level: f64, a: f64, b: f64) -> Option<f64> {
        if self.value(b) <= level + LIMIT_TOLERANCE {
            return None;
        }
        let above = |t| self.value(t) - level;
        Some(if above(a) < 0.0 {
            bisect(a, b, above)
        } else {
            a
        })
    }

    /// Bounds of the rate of the value on a span without a corner inside.
    fn rate(&self, a: f64, b: f64) -> (f64, f64) {
        let (least, most) = self.path.j4_rates(self.geometry, a, b);
        if self.side > 0.0 {
            (least, most)
        } else {
            (-most, -least)
        }
    }
}

/// Range of speeds of a profile's curve between two times without a corner in between.
pub(crate) fn speeds(profile: &VelocityProfile, a: f64, b: f64) -> Interval {
    let piece = profile.piece(0.5 * (a + b));
    Interval::over(piece.velocity(a), piece.velocity(b))
}

/// A closed interval: lower and upper end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval(pub(crate) f64, pub(crate) f64);

impl Interval {
    pub(crate) fn over(a: f64, b: f64) -> Self {
        Self(a.min(b), a.max(b))
    }

    pub(crate) fn plus(&self, number: f64) -> Self {
        Self(self.0 + number, self.1 + number)
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        let (a, b) = (self.0 * other.0, self.0 * other.1);
        let (c, d) = (self.1 * other.0, self.1 * other.1);
        Self(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }

    pub(crate) fn over_positive(&self, other: &Self) -> Self {
        self.times(&Self(1.0 / other.1, 1.0 / other.0))
    }

    /// Bounds of the rate of J4 in degrees, given those of r in degrees and of J1 in radians.
    pub(crate) fn j4(r: &Self, j1: &Self) -> (f64, f64) {
        (
            r.0 - j1.1 * DEGREES_PER_RADIAN,
            r.1 - j1.0 * DEGREES_PER_RADIAN,
        )
    }
}
