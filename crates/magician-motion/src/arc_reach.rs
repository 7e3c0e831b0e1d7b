//! Crossings of a circular arc with the boundaries of the workspace (model section 5).
//!
//! A bound of J1 is a plane through the base axis, which an arc cuts in closed form. Every other
//! boundary is a circle in the arm's vertical plane, in space a torus or a sphere. On it a function
//! of the arc length is zero: the squared distance of the wrist from the circle's centre less the
//! squared radius. For an arc in any plane that leads to polynomials of degree eight with spurious
//! roots, so the zeros are enclosed instead:
//!
//! * At the middle of a span the function is known with two derivatives. A bound of the third holds
//!   on the whole span, because the curvature of the arc bounds how fast anything can change.
//! * By Taylor's formula a span may prove free of zeros, or monotone, and then its ends decide. Any
//!   other span is halved.
//!
//! So nothing between samples is missed. Near a tangent point the spans shrink fast, and few are
//! needed. Only an arc that follows a boundary all along needs many; above a limit the search
//! continues at a coarser resolution, and may then miss what is shallower than 0.001 mm.

use crate::angle::sin_cos;
use crate::arc::{Arc, ArcPoint};
use crate::boundary::{Circle, SPATIAL};
use crate::roots::bisect;
use crate::wrist::Interval;
use crate::{Bound, Geometry, Limits};

/// Tolerance at which a boundary counts as touched, in the unit of the functions, mm2. It is far
/// above rounding errors, and at a boundary it is less than
/// [`LIMIT_TOLERANCE`](crate::LIMIT_TOLERANCE).
const TOUCH: f64 = 1e-7;
/// Shortest span that is halved, mm.
const SHORTEST_SPAN: f64 = 1e-7;
/// Number of spans after which the search becomes coarser, so that planning time stays bounded.
const MANY_SPANS: u32 = 30_000;
/// Shortest span of the coarse search, as a share of the path.
const COARSE_SHARE: f64 = 1.0 / 8192.0;

/// Motion of the wrist over a span of the arc, in the arm's vertical plane.
///
/// Values and derivatives by arc length hold at the middle of the span, bounds on all of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    half: f64,
    curvature: f64,
    /// Smallest and greatest distance of the tool from the base axis.
    near: f64,
    far: f64,
    /// Squared distance of the tool from the base axis, less the squared sideways bias.
    square: [f64; 3],
    /// Root of `square`: horizontal distance of the tool in the vertical plane.
    out: [f64; 3],
    /// Range of `out` on the span.
    out_range: Interval,
    /// Bounds of the first three derivatives of `out`; infinite where the root may vanish.
    out_rates: [f64; 3],
    /// Height of the wrist.
    up: [f64; 3],
    /// Radius of a ball around the middle that holds the span.
    ball: f64,
}

impl Outline {
    /// Outlines the span that reaches `half` before and behind a place.
    pub(crate) fn new(arc: &Arc, geometry: &Geometry, place: &ArcPoint, half: f64) -> Self {
        let ArcPoint {
            at: [x, y, z],
            along: [dx, dy, dz],
            bend: [ddx, ddy, ddz],
        } = *place;
        let across = geometry.tool.y * geometry.tool.y;
        let curvature = arc.curvature();
        let ball = arc.max_chord(half);
        let whole = x * x + y * y;
        let distance = libm::sqrt(whole);
        let (near, far) = ((distance - ball).max(0.0), distance + ball);
        let slope = x * dx + y * dy;
        let bend = dx * dx + dy * dy + x * ddx + y * ddy;
        let root = libm::sqrt((whole - across).max(0.0));
        let root_rate = slope / root;
        let nearest_out = libm::sqrt((near * near - across).max(0.0));
        // `tilt` bounds the ratio of the root's slope to the speed of the tool.
        let tilt = far / nearest_out;
        let second = tilt * tilt / nearest_out + tilt * curvature;
        let third =
            (3.0 * curvature + far * curvature * curvature + 3.0 * tilt * second) / nearest_out;
        let out_rates = if nearest_out > 0.0 {
            [tilt, second, third]
        } else {
            [f64::INFINITY; 3]
        };
        Self {
            half,
            curvature,
            near,
            far,
            square: [whole - across, 2.0 * slope, 2.0 * bend],
            out: [root, root_rate, (bend - root_rate * root_rate) / root],
            out_range: Interval(nearest_out, libm::sqrt((far * far - across).max(0.0))),
            out_rates,
            up: [z + geometry.tool.z, dz, ddz],
            ball,
        }
    }

    /// Bounds of the rate of J1 by arc length on the span, rad/mm. `None` if the tool may touch the
    /// base axis. `place` is the middle of the span.
    pub(crate) fn turning(&self, place: &ArcPoint, across: f64) -> Option<Interval> {
        let [x, y, _] = place.at;
        let [dx, dy, _] = place.along;
        let [_, out_rate, _] = self.out;
        let [_, second, _] = self.out_rates;
        if !second.is_finite() {
            return None;
        }
        let swept = x * dy - y * dx + across * out_rate;
        let change = (self.far * self.curvature + libm::fabs(across) * second) * self.half;
        let swept = Interval(swept - change, swept + change);
        Some(swept.over_positive(&Interval(self.near * self.near, self.far * self.far)))
    }
}

/// A boundary, given as the zeros of a function of arc length.
#[derive(Clone, Copy, Debug)]
enum Surface {
    /// The wrist is on a circle in the vertical plane. The centre is given as a position of the
    /// tool.
    Circle(Circle),
    /// The tool is as close to the base axis as its sideways bias allows.
    Axis,
}

/// Result of a check of one span against a surface.
enum SurfaceCheck {
    Clear,
    Monotone,
    Open,
}

impl Surface {
    /// Returns the function and two derivatives at the middle of a span, and a bound of the third
    /// on all of it.
    fn taylor(&self, outline: &Outline) -> [f64; 4] {
        let Outline {
            curvature: bend, ..
        } = *outline;
        match self {
            Self::Circle(circle) => {
                let ([out, out1, out2], [up, up1, up2]) = (outline.out, outline.up);
                let [most1, most2, most3] = outline.out_rates;
                let (aside, above) = (out - circle.outwards, up - circle.up);
                let Interval(least_out, most_out) = outline.out_range;
                let most_aside = libm::fabs(least_out - circle.outwards)
                    .max(libm::fabs(most_out - circle.outwards));
                let most_above = libm::fabs(above) + outline.ball;
                [
                    aside * aside + above * above - circle.radius * circle.radius,
                    2.0 * (aside * out1 + above * up1),
                    2.0 * (out1 * out1 + aside * out2 + up1 * up1 + above * up2),
                    6.0 * (most1 * most2 + bend)
                        + 2.0 * (most_aside * most3 + most_above * bend * bend),
                ]
            }
            Self::Axis => {
                let [value, slope, second] = outline.square;
                [
                    value,
                    slope,
                    second,
                    6.0 * bend + 2.0 * outline.far * bend * bend,
                ]
            }
        }
    }

    fn value(&self, outline: &Outline) -> f64 {
        let [value, ..] = self.taylor(outline);
        value
    }

    fn check(&self, outline: &Outline) -> SurfaceCheck {
        let half = outline.half;
        let [value, slope, second, third] = self.taylor(outline);
        let bulge = half * half * (0.5 * libm::fabs(second) + half * third / 6.0);
        let change = half * libm::fabs(slope) + bulge;
        let size = libm::fabs(value);
        // The whole span is clear of the surface, or lies within the tolerance of it.
        if size - change > TOUCH || size + change <= TOUCH {
            SurfaceCheck::Clear
        } else if libm::fabs(slope) > half * (libm::fabs(second) + 0.5 * half * third) {
            SurfaceCheck::Monotone
        } else {
            SurfaceCheck::Open
        }
    }
}

/// Reports the arc lengths, within `lap`, at which the arc may pass a bound of the strict limits or
/// of the wide limits where these differ, or leave the reach.
pub(crate) fn spatial_cuts(
    arc: &Arc,
    lap: f64,
    geometry: &Geometry,
    (strict, wide): (&Limits, &Limits),
    report: &mut impl FnMut(f64),
) {
    let mut search = Search {
        arc,
        geometry,
        surfaces: [Surface::Axis; Search::<fn(f64)>::MOST_SURFACES],
        count: 1,
        coarse: COARSE_SHARE * lap,
        spans_left: MANY_SPANS,
        report,
    };
    for circle in Circle::reach(geometry) {
        search.add(circle);
    }
    for bound in SPATIAL {
        let (set, let_out) = (strict.at(bound), wide.at(bound));
        search.look_for(bound, set);
        if let_out != set {
            search.look_for(bound, let_out);
        }
    }
    search.run(lap);
}

struct Search<'a, R> {
    arc: &'a Arc,
    geometry: &'a Geometry,
    surfaces: [Surface; 15],
    count: usize,
    coarse: f64,
    spans_left: u32,
    report: &'a mut R,
}

impl<R: FnMut(f64)> Search<'_, R> {
    /// Six bounds, each strict and wide, two edges of reach, and the base axis.
    const MOST_SURFACES: usize = 15;

    fn add(&mut self, circle: Circle) {
        let seen_from_tool = Circle {
            outwards: circle.outwards + self.geometry.tool.x,
            ..circle
        };
        if let Some(slot) = self.surfaces.get_mut(self.count) {
            *slot = Surface::Circle(seen_from_tool);
            self.count += 1;
        }
    }

    /// Adds a bound at `angle` to the surfaces. Crossings of a bound of J1 are reported at once.
    fn look_for(&mut self, bound: Bound, angle: f64) {
        if !angle.is_finite() {
            return;
        }
        if let Some(circle) = Circle::of(self.geometry, bound, angle) {
            self.add(circle);
        } else if matches!(bound, Bound::J1Min | Bound::J1Max) {
            // At J1 = angle the tool is off the vertical plane by exactly the sideways bias.
            let (sin, cos) = sin_cos(angle);
            let across = self.geometry.tool.y;
            self.arc.plane_cuts([-sin, cos, 0.0], across, self.report);
        }
    }

    fn run(&mut self, lap: f64) {
        let all = (1 << self.count) - 1;
        self.halve(0.0, lap, all);
    }

    fn outline(&self, from: f64, to: f64) -> Outline {
        let place = self.arc.point_at(0.5 * (from + to));
        Outline::new(self.arc, self.geometry, &place, 0.5 * (to - from))
    }

    /// Searches a span for zeros of the surfaces whose bits are set in `pending`.
    fn halve(&mut self, from: f64, to: f64, pending: u32) {
        let outline = self.outline(from, to);
        let across = libm::fabs(self.geometry.tool.y);
        let mut open = 0;
        let mut monotone = 0;
        for (index, surface) in self.surfaces.iter().enumerate() {
            let bit = 1 << index;
            // Closer to the axis than its bias the tool has no wrist position, so no circle
            // applies.
            let nowhere = outline.far < across && matches!(surface, Surface::Circle(_));
            if pending & bit == 0 || nowhere {
                continue;
            }
            match surface.check(&outline) {
                SurfaceCheck::Clear => {}
                SurfaceCheck::Monotone => monotone |= bit,
                SurfaceCheck::Open => open |= bit,
            }
        }
        let middle = 0.5 * (from + to);
        let shortest = if self.spans_left > 0 {
            SHORTEST_SPAN
        } else {
            self.coarse.max(SHORTEST_SPAN)
        };
        // Too short to halve: treat the open surfaces by their ends.
        if to - from <= shortest || middle <= from || middle >= to {
            (monotone, open) = (monotone | open, 0);
        }
        self.settle(from, to, monotone);
        if open != 0 {
            self.spans_left = self.spans_left.saturating_sub(1);
            self.halve(from, middle, open);
            self.halve(middle, to, open);
        }
    }

    /// Reports the zeros of monotone functions on a span.
    ///
    /// A function that only touches zero at an end is reported at that end. So nothing is lost
    /// between spans that lie on a boundary as a whole.
    fn settle(&mut self, from: f64, to: f64, pending: u32) {
        if pending == 0 {
            return;
        }
        let (first, last) = (self.outline(from, from), self.outline(to, to));
        for index in 0..self.count {
            let Some(surface) = self
                .surfaces
                .get(index)
                .filter(|_| pending & (1 << index) != 0)
            else {
                continue;
            };
            let (a, b) = (surface.value(&first), surface.value(&last));
            let side = |value: f64| i8::from(value > TOUCH) - i8::from(value < -TOUCH);
            if side(a) == side(b) {
                continue;
            }
            let at = if (a > 0.0) != (b > 0.0) {
                bisect(from, to, |way| surface.value(&self.outline(way, way)))
            } else if side(a) == 0 {
                from
            } else {
                to
            };
            (self.report)(at);
        }
    }
}
