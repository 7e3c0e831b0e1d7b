//! Splines: rational B-splines of any degree and knot vector, and splines through fit points.

use kurbo::{BezPath, PathEl, Point, Vec2};
use magician_host::{Message, message};

/// Largest degree. It bounds the stack array of de Boor's algorithm; CAD programs use 3, rarely
/// more.
const MAX_DEGREE: usize = 25;
/// Largest number of bisections of a piece. It bounds time where a curve has a kink.
const MAX_BISECTIONS: u32 = 16;
/// Parameters at which a piece is compared with its chord. They are in no simple ratio, so that a
/// curve that oscillates does not meet the chord at all of them.
const CHECK_PARAMETERS: [f64; 5] = [0.2137, 0.3791, 0.5, 0.6173, 0.7919];

/// Returns the curve through fit points as CAD programs draw it: a cubic spline of minimum bending,
/// parameterised by chord length. `ends` are the tangents at both ends, if given.
pub(super) fn interpolated(
    through: &[Point],
    ends: [Option<Vec2>; 2],
    closed: bool,
    tolerance: f64,
) -> Vec<Point> {
    let mut points: Vec<Point> = through.to_vec();
    if closed && points.first() != points.last() {
        points.extend(points.first().copied());
    }
    points.dedup();
    // A closed curve is periodic: go round three times and take the middle round.
    let rounds = if closed && points.len() > 3 { 3 } else { 1 };
    let length = points.len() - 1;
    if rounds > 1 {
        let round: Vec<Point> = points[1..].to_vec();
        points.extend(round.iter().chain(&round));
    }
    let slopes = slopes(&points, if rounds > 1 { [None; 2] } else { ends });
    let from = if rounds > 1 { length } else { 0 };
    let mut path = BezPath::new();
    for at in from..from + length {
        let [Some(start), Some(end)] = [points.get(at), points.get(at + 1)] else {
            continue;
        };
        if at == from {
            path.move_to(*start);
        }
        let third = start.distance(*end) / 3.0;
        path.curve_to(
            *start + slopes[at] * third,
            *end - slopes[at + 1] * third,
            *end,
        );
    }
    let mut flat = Vec::new();
    kurbo::flatten(path, tolerance, |element| {
        if let PathEl::MoveTo(to) | PathEl::LineTo(to) = element {
            flat.push(to);
        }
    });
    flat
}

/// Returns the slopes at the points of a natural spline, or of one clamped to the given tangents.
/// Solves a tridiagonal system (Thomas algorithm).
fn slopes(points: &[Point], ends: [Option<Vec2>; 2]) -> Vec<Vec2> {
    let last = points.len().saturating_sub(1);
    let chord = |at: usize| {
        let way = points[at + 1] - points[at];
        (way.hypot(), way)
    };
    let unit = |way: Vec2| way / way.hypot();
    let ends = ends.map(|way| way.filter(|way| way.hypot() > 0.0));
    // A row: sub-diagonal, diagonal, super-diagonal, right-hand side.
    let row = |at: usize| -> (f64, f64, f64, Vec2) {
        if let (0, [Some(way), _]) = (at, ends) {
            return (0.0, 1.0, 0.0, unit(way));
        }
        if at == last
            && let [_, Some(way)] = ends
        {
            return (0.0, 1.0, 0.0, unit(way));
        }
        if at == 0 || at == last {
            let (length, way) = chord(if at == 0 { 0 } else { last - 1 });
            let [before, behind] = if at == 0 { [0.0, 1.0] } else { [1.0, 0.0] };
            return (before, 2.0, behind, way * 3.0 / length);
        }
        let ((before, came), (behind, goes)) = (chord(at - 1), chord(at));
        let right = came * (3.0 * behind / before) + goes * (3.0 * before / behind);
        (behind, 2.0 * (before + behind), before, right)
    };
    if last == 0 {
        return vec![Vec2::ZERO; points.len()];
    }
    let mut swept: Vec<(f64, Vec2)> = Vec::with_capacity(points.len());
    for at in 0..=last {
        let (before, on, behind, right) = row(at);
        let (ratio, sum) = swept.last().copied().unwrap_or((0.0, Vec2::ZERO));
        let pivot = on - before * ratio;
        swept.push((behind / pivot, (right - sum * before) / pivot));
    }
    let mut slopes = vec![Vec2::ZERO; points.len()];
    for at in (0..=last).rev() {
        let next = slopes.get(at + 1).copied().unwrap_or(Vec2::ZERO);
        slopes[at] = swept[at].1 - next * swept[at].0;
    }
    slopes
}

/// A validated spline.
pub(super) struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// Homogeneous control points: x and y times the weight, and the weight.
    controls: Vec<[f64; 3]>,
}

impl Spline {
    /// Creates a spline. Missing knots are uniform, missing weights are 1.
    ///
    /// # Errors
    /// A sentence about the first inconsistency.
    pub(super) fn new(
        degree: i64,
        knots: Vec<f64>,
        points: &[Point],
        weights: &[f64],
    ) -> Result<Self, Message> {
        let count = points.len();
        let degree = usize::try_from(degree).unwrap_or(0);
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(message!("a spline of degree {degree} is not drawn", degree));
        }
        if count <= degree {
            return Err(message!(
                "a spline of degree {degree} needs more than {count} points",
                degree,
                count
            ));
        }
        let knots = if knots.is_empty() {
            even(degree, count)
        } else {
            knots
        };
        if knots.len() != count + degree + 1 {
            let needed = count + degree + 1;
            return Err(message!(
                "a spline has {count} knots, and needs {needed}",
                count = knots.len(),
                needed
            ));
        }
        if !knots.is_sorted() {
            return Err(message!("the knots of a spline do not increase"));
        }
        if !(weights.is_empty() || weights.len() == count) || weights.iter().any(|w| *w <= 0.0) {
            return Err(message!(
                "the weights of a spline must be above 0, one for each point"
            ));
        }
        let weights = weights.iter().copied().chain(std::iter::repeat(1.0));
        let controls = points.iter().zip(weights);
        Ok(Self {
            degree,
            knots,
            controls: controls.map(|(p, w)| [p.x * w, p.y * w, w]).collect(),
        })
    }

    /// Returns points along the spline including both ends, at most about `most`, so that chords
    /// stay within the tolerance.
    pub(super) fn points(&self, tolerance: f64, most: usize) -> Vec<Point> {
        let mut points = Vec::new();
        for span in self.degree..self.controls.len() {
            let (Some(from), Some(to)) = (self.knots.get(span), self.knots.get(span + 1)) else {
                continue;
            };
            if from >= to {
                continue;
            }
            let ends = [*from, *to].map(|u| (u, self.at(span, u)));
            if points.is_empty() {
                points.push(ends[0].1);
            }
            self.flatten(span, ends, tolerance, MAX_BISECTIONS, most, &mut points);
        }
        points
    }

    /// Bisects a piece until each part is as good as its chord.
    fn flatten(
        &self,
        span: usize,
        [from, to]: [(f64, Point); 2],
        tolerance: f64,
        halvings: u32,
        most: usize,
        points: &mut Vec<Point>,
    ) {
        let strays = |share: &f64| {
            let at = self.at(span, from.0 + (to.0 - from.0) * share);
            distance_to_chord(at, from.1, to.1) > tolerance
        };
        if halvings == 0 || points.len() >= most || !CHECK_PARAMETERS.iter().any(strays) {
            points.push(to.1);
            return;
        }
        let middle = f64::midpoint(from.0, to.0);
        let middle = (middle, self.at(span, middle));
        self.flatten(span, [from, middle], tolerance, halvings - 1, most, points);
        self.flatten(span, [middle, to], tolerance, halvings - 1, most, points);
    }

    /// Evaluates the spline within a span of knots (de Boor).
    fn at(&self, span: usize, u: f64) -> Point {
        let first = span - self.degree;
        let mut near = [[0.0; 3]; MAX_DEGREE + 1];
        let controls = self.controls.get(first..=span).unwrap_or_default();
        for (slot, control) in near.iter_mut().zip(controls) {
            *slot = *control;
        }
        let knot = |at: usize| self.knots.get(at).copied().unwrap_or(u);
        for round in 1..=self.degree {
            for at in (round..=self.degree).rev() {
                let (low, high) = (knot(first + at), knot(span + 1 + at - round));
                let share = if high > low {
                    (u - low) / (high - low)
                } else {
                    0.0
                };
                let before = near[at - 1];
                for (value, before) in near[at].iter_mut().zip(before) {
                    *value = before + (*value - before) * share;
                }
            }
        }
        let [x, y, weight] = near[self.degree];
        Point::new(x / weight, y / weight)
    }
}

/// Returns uniform knots, clamped so that the spline begins and ends at its outer control points.
fn even(degree: usize, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(degree);
    let knots = 0..count + degree + 1;
    knots
        .map(|nth| nth.saturating_sub(degree).min(last) as f64)
        .collect()
}

fn distance_to_chord(point: Point, from: Point, to: Point) -> f64 {
    let (chord, way) = (to - from, point - from);
    let square = chord.hypot2();
    let share = if square > 0.0 {
        (chord.dot(way) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (way - chord * share).hypot()
}
