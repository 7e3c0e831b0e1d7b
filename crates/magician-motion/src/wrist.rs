//! Where J4 passes a limit on a straight line.
//!
//! J4 is r less J1. r follows its own law of time, J1 the arc tangent of a point that moves by another, so there is no
//! closed form. But both laws, the square of the radius and its slope are monotone between the corners of the laws and
//! the line's nearest point to the base axis, so that on any span between them the values at its two ends enclose
//! the rate of J4, and with it J4. A span whose enclosure stays below the limit holds no crossing; one on which
//! the rate keeps its sign holds at most one, bracketed by its ends; any other is halved. So no crossing is missed
//! that lasts longer than the shortest span.

use crate::angle::DEGREES_PER_RADIAN;
use crate::boundary::Section;
use crate::line_leg::LineLeg;
use crate::roots::between;
use crate::{Geometry, LIMIT_TOLERANCE, Limits};

/// No span shorter than this is halved, seconds: a tenth of the unit of time.
const SHORTEST_SPAN: f64 = 1e-7;
/// No more spans than this are looked at: reached only by motions made to hug the limit, and they are then followed
/// at the resolution reached.
const MOST_SPANS: u32 = 20_000;

/// J4 along a line, seen from one side: `side` is 1 to look for an upper limit, -1 for a lower one.
struct Wrist<'a> {
    line: &'a LineLeg,
    geometry: &'a Geometry,
    section: Section,
    side: f64,
}

/// When J4 first passes one of its limits between the start and `end` seconds, if it does.
///
/// A start beyond a limit may come back in, but not go further out. `whole` says that nothing else ends the line
/// before its end.
pub(crate) fn first_crossing(
    line: &LineLeg,
    geometry: &Geometry,
    limits: &Limits,
    end: f64,
    whole: bool,
) -> Option<f64> {
    let (above, below) = if whole {
        line.j4_extremes(geometry)
    } else {
        (None, None)
    };
    let crossing = |side: f64, limit: f64, extreme: Option<f64>| {
        if extreme.is_some_and(|extreme| side * extreme <= side * limit) {
            return None;
        }
        Wrist {
            line,
            geometry,
            section: line.section(geometry),
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

impl Wrist<'_> {
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
        let j4 = self.line.state_at(self.geometry, t).joints.j4;
        self.side * j4
    }

    /// When the value first rises above `level` between `a` and `b`, where it starts no higher.
    fn first_above(&self, level: f64, a: f64, b: f64) -> Option<f64> {
        let mut ends = self.line.corners(self.section.nearest());
        ends.sort_unstable_by(f64::total_cmp);
        let mut budget = MOST_SPANS;
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

    /// When the value passes `level` on a span at whose end it is above, if it is.
    fn rise(&self, level: f64, a: f64, b: f64) -> Option<f64> {
        if self.value(b) <= level + LIMIT_TOLERANCE {
            return None;
        }
        let above = |t| self.value(t) - level;
        Some(if above(a) < 0.0 {
            between(a, b, above)
        } else {
            a
        })
    }

    /// Bounds of the rate of the value on a span without a corner inside.
    fn rate(&self, a: f64, b: f64) -> (f64, f64) {
        let ends = |function: &dyn Fn(f64) -> f64| Span::over(function(a), function(b));
        let share = |t| self.line.share(t);
        let square = ends(&|t| self.section.square(share(t)).0.max(0.0));
        let slope = ends(&|t| self.section.square(share(t)).1);
        let across = self.geometry.tool.y;
        let turning = if across == 0.0 {
            Span::over(self.section.swept(), self.section.swept())
        } else {
            slope
                .times(&Span::over(0.5 * across, 0.5 * across))
                .over_positive(&Span(libm::sqrt(square.0), libm::sqrt(square.1)))
                .plus(self.section.swept())
        };
        let j1 = turning
            .over_positive(&square.plus(across * across))
            .times(&ends(&|t| self.line.share_rate(t)));
        let r = ends(&|t| self.line.turn_rate(t));
        let least = r.0 - j1.1 * DEGREES_PER_RADIAN;
        let most = r.1 - j1.0 * DEGREES_PER_RADIAN;
        if self.side > 0.0 {
            (least, most)
        } else {
            (-most, -least)
        }
    }
}

/// All numbers from the first to the second.
struct Span(f64, f64);

impl Span {
    fn over(a: f64, b: f64) -> Self {
        Self(a.min(b), a.max(b))
    }

    fn plus(&self, number: f64) -> Self {
        Self(self.0 + number, self.1 + number)
    }

    fn times(&self, other: &Self) -> Self {
        let (a, b) = (self.0 * other.0, self.0 * other.1);
        let (c, d) = (self.1 * other.0, self.1 * other.1);
        Self(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }

    fn over_positive(&self, other: &Self) -> Self {
        self.times(&Self(1.0 / other.1, 1.0 / other.0))
    }
}
