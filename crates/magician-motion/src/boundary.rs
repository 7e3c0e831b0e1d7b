//! Crossings of a straight line with the boundaries of the workspace (model section 5).
//!
//! In the arm's vertical plane every boundary is a circle: around the elbow for a bound of J2,
//! around a displaced shoulder for a bound of J3, and around the shoulder for a bound of J2 - J3
//! and for the edge of reach. Along a straight line the wrist's radius is the root of a quadratic,
//! so a crossing solves `quadratic - c * sqrt(quadratic) = 0`. The second derivative of that
//! function has at most two zeros, in closed form. Between them it is convex or concave, so each
//! piece has at most two roots, and each of them can be bracketed. Nothing is sampled, and no root
//! can be missed.

use crate::angle::sin_cos;
use crate::roots::{bisect, quadratic};
use crate::{Bound, Geometry, Limits, Pose};

/// A boundary of the workspace in the arm's vertical plane. The centre is relative to the shoulder.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    pub(crate) outwards: f64,
    pub(crate) up: f64,
    pub(crate) radius: f64,
}

impl Circle {
    /// Returns the positions of the wrist at which a bound of J2, J3 or J2 - J3 at `angle` is
    /// reached.
    pub(crate) fn of(geometry: &Geometry, bound: Bound, angle: f64) -> Option<Self> {
        let (rear_arm, forearm) = (geometry.rear_arm, geometry.forearm);
        let (sin, cos) = sin_cos(angle);
        let (outwards, up, radius) = match bound {
            Bound::J2Min | Bound::J2Max => (rear_arm * sin, rear_arm * cos, forearm),
            Bound::J3Min | Bound::J3Max => (forearm * cos, -forearm * sin, rear_arm),
            Bound::J23Min | Bound::J23Max if libm::fabs(angle) < 90.0 => {
                let square =
                    rear_arm * rear_arm + forearm * forearm + 2.0 * rear_arm * forearm * sin;
                (0.0, 0.0, libm::sqrt(square))
            }
            // The elbow bends no further than straight; J1 and J4 do not act in the vertical plane.
            _ => return None,
        };
        Some(Self {
            outwards,
            up,
            radius,
        })
    }

    /// Returns the circles of the straight arm and of the folded arm.
    pub(crate) fn reach(geometry: &Geometry) -> [Self; 2] {
        let (rear_arm, forearm) = (geometry.rear_arm, geometry.forearm);
        [rear_arm + forearm, libm::fabs(forearm - rear_arm)].map(|radius| Self {
            outwards: 0.0,
            up: 0.0,
            radius,
        })
    }
}

/// A straight line in the arm's vertical plane; its parameter runs from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    geometry: Geometry,
    from: Pose,
    step: Pose,
    /// Squared distance of the tool from the base axis, less the squared sideways bias:
    /// coefficients, constant first.
    square: [f64; 3],
}

impl Section {
    pub(crate) fn new(geometry: &Geometry, from: &Pose, to: &Pose) -> Self {
        let step = Pose::new(to.x - from.x, to.y - from.y, to.z - from.z, to.r - from.r);
        let across = geometry.tool.y;
        Self {
            geometry: *geometry,
            from: *from,
            step,
            square: [
                from.x * from.x + from.y * from.y - across * across,
                2.0 * (from.x * step.x + from.y * step.y),
                step.x * step.x + step.y * step.y,
            ],
        }
    }

    /// Squared radius at a parameter, and its derivative.
    pub(crate) fn square(&self, at: f64) -> (f64, f64) {
        let [c0, c1, c2] = self.square;
        (c0 + at * (c1 + at * c2), c1 + 2.0 * c2 * at)
    }

    /// Parameter at which the line is closest to the base axis; NaN for a vertical line.
    pub(crate) fn nearest(&self) -> f64 {
        let [_, c1, c2] = self.square;
        -0.5 * c1 / c2
    }

    /// Smallest squared radius on the infinite line. Computed from the swept area, because the
    /// coefficients cancel.
    fn least_square(&self) -> f64 {
        let (swept, across) = (self.swept(), self.geometry.tool.y);
        let [_, _, c2] = self.square;
        swept * swept / c2 - across * across
    }

    /// Twice the area per unit of parameter that the line sweeps around the base axis: a constant.
    pub(crate) fn swept(&self) -> f64 {
        self.from.x * self.step.y - self.from.y * self.step.x
    }

    /// Reports the parameters at which the line may pass a bound of J1, J2, J3 or J2 - J3 at
    /// `angle`.
    pub(crate) fn cuts(&self, bound: Bound, angle: f64, report: &mut impl FnMut(f64)) {
        match bound {
            Bound::J1Min | Bound::J1Max => {
                // At J1 = angle the tool is off the vertical plane by exactly the sideways bias.
                let (sin, cos) = sin_cos(angle);
                let Pose { x, y, .. } = self.from;
                let offset = y * cos - x * sin - self.geometry.tool.y;
                report(-offset / (self.step.y * cos - self.step.x * sin));
            }
            _ => {
                if let Some(circle) = Circle::of(&self.geometry, bound, angle) {
                    self.circle(&circle, report);
                }
            }
        }
    }

    /// Reports the parameters at which the line may leave the reach of the links.
    pub(crate) fn reach_cuts(&self, report: &mut impl FnMut(f64)) {
        for circle in Circle::reach(&self.geometry) {
            self.circle(&circle, report);
        }
        let [c0, c1, c2] = self.square;
        quadratic(c2, c1, c0).into_iter().for_each(report);
    }

    /// Reports the parameters at which the wrist is on a circle in the vertical plane.
    fn circle(&self, circle: &Circle, report: &mut impl FnMut(f64)) {
        let radius = circle.radius;
        let height = self.from.z + self.geometry.tool.z - circle.up;
        let centre = circle.outwards + self.geometry.tool.x;
        let [c0, c1, c2] = self.square;
        let climb = self.step.z;
        Cut {
            square: self.square,
            nearest: self.nearest(),
            least: self.least_square(),
            sum: [
                c0 + centre * centre + height * height - radius * radius,
                c1 + 2.0 * height * climb,
                c2 + climb * climb,
            ],
            centre,
        }
        .roots(report);
    }
}

/// Squared distance from the base axis below which a line counts as passing through it, mm2.
const THROUGH: f64 = 1e-6;

/// The function `sum(x) - 2 centre sqrt(square(x))`; both quadratics with the constant first.
struct Cut {
    square: [f64; 3],
    /// Parameter closest to the axis, and `square` there.
    nearest: f64,
    least: f64,
    sum: [f64; 3],
    centre: f64,
}

/// Value and slope of the function at one parameter.
#[derive(Clone, Copy)]
struct Point {
    at: f64,
    value: f64,
    slope: f64,
}

impl Cut {
    fn point(&self, at: f64) -> Point {
        let ([s0, s1, s2], [g0, g1, g2]) = (self.square, self.sum);
        let root = libm::sqrt((s0 + at * (s1 + at * s2)).max(0.0));
        // If the root vanishes, its slope is unbounded; only the sign of the slope is used.
        let root_slope = if self.turns_at(at) {
            0.0
        } else {
            (0.5 * s1 + at * s2) / root.max(1e-12)
        };
        Point {
            at,
            value: g0 + at * (g1 + at * g2) - 2.0 * self.centre * root,
            slope: g1 + 2.0 * g2 * at - 2.0 * self.centre * root_slope,
        }
    }

    /// Zeros of the second derivative: `2 g2 = centre (4 s0 s2 - s1^2) / (2 root^3)`, where the
    /// bracket is `4 s2 least`.
    fn inflections(&self) -> [f64; 2] {
        let ([s0, s1, s2], [_, _, g2]) = (self.square, self.sum);
        let cube = self.centre * s2 * self.least / g2;
        if cube > 0.0 && libm::fabs(self.least) >= THROUGH {
            let root = libm::cbrt(cube);
            quadratic(s2, s1, s0 - root * root)
        } else {
            [f64::NAN; 2]
        }
    }

    /// True if the line passes through the axis, or nearly so. There the radius has a kink.
    fn turns_at(&self, at: f64) -> bool {
        at == self.nearest && libm::fabs(self.least) < THROUGH
    }

    fn roots(&self, report: &mut impl FnMut(f64)) {
        let [first, second] = self.inflections();
        let [s0, s1, s2] = self.square;
        let [enter, leave] = if libm::fabs(self.least) < THROUGH {
            [f64::NAN; 2]
        } else {
            quadratic(s2, s1, s0)
        };
        // Besides the inflections: parameters where the root begins, ends, or has a kink.
        let mut pieces = [first, second, enter, leave, self.nearest];
        pieces.sort_unstable_by(f64::total_cmp);
        let mut from = self.point(0.0);
        for end in pieces {
            if end > from.at && end < 1.0 {
                let mut to = self.point(end);
                let turn = if self.turns_at(end) {
                    2.0 * self.centre * libm::sqrt(s2)
                } else {
                    0.0
                };
                to.slope += turn;
                self.piece_roots(from, to, report);
                to.slope -= 2.0 * turn;
                from = to;
            }
        }
        self.piece_roots(from, self.point(1.0), report);
    }

    /// Reports the roots in a piece on which the function is convex or concave.
    fn piece_roots(&self, from: Point, to: Point, report: &mut impl FnMut(f64)) {
        let value = |at| self.point(at).value;
        if (from.value > 0.0) != (to.value > 0.0) {
            report(bisect(from.at, to.at, value));
            return;
        }
        // Two roots need a valley (a hill, if both values are negative) that reaches below the
        // intersection of the tangents at its ends.
        let side = if from.value > 0.0 { 1.0 } else { -1.0 };
        let (falling, rising) = (side * from.slope, side * to.slope);
        if !(falling < 0.0 && rising > 0.0) {
            return;
        }
        let (a, b) = (side * from.value, side * to.value);
        let meet = (b - a + falling * from.at - rising * to.at) / (falling - rising);
        if a + falling * (meet - from.at) > 0.0 {
            return;
        }
        let bottom = bisect(from.at, to.at, |at| self.point(at).slope);
        if side * value(bottom) <= 0.0 {
            report(bisect(from.at, bottom, value));
            report(bisect(bottom, to.at, value));
        }
    }
}

/// Bounds that limit positions in space: all except those of J4.
pub(crate) const SPATIAL: [Bound; 8] = [
    Bound::J1Min,
    Bound::J1Max,
    Bound::J2Min,
    Bound::J2Max,
    Bound::J3Min,
    Bound::J3Max,
    Bound::J23Min,
    Bound::J23Max,
];

/// Reports every parameter at which a line may pass a bound of `strict`, or of `wide` where it
/// differs.
pub(crate) fn spatial_cuts(
    section: &Section,
    strict: &Limits,
    wide: &Limits,
    report: &mut impl FnMut(f64),
) {
    for bound in SPATIAL {
        section.cuts(bound, strict.at(bound), report);
        if wide.at(bound) != strict.at(bound) {
            section.cuts(bound, wide.at(bound), report);
        }
    }
    section.reach_cuts(report);
}
