//! Splines: rational B-splines of any degree and any knots.

use kurbo::Point;

/// The highest degree that is drawn.
const MOST_DEGREE: usize = 25;
/// As often a piece is halved.
const HALVINGS: u32 = 16;
/// Where a piece is compared with its chord, as shares of its parameter; in no simple ratio, so that a curve that winds is not
/// found where it was each time.
const CHECKS: [f64; 5] = [0.2137, 0.3791, 0.5, 0.6173, 0.7919];

/// A spline whose numbers fit together.
pub(super) struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// x and y times the weight, and the weight.
    controls: Vec<[f64; 3]>,
}

impl Spline {
    /// Knots that are left out are even, weights are 1.
    ///
    /// # Errors
    /// Why it is none.
    pub(super) fn new(
        degree: i64,
        knots: Vec<f64>,
        points: &[Point],
        weights: &[f64],
    ) -> Result<Self, String> {
        let count = points.len();
        let degree = usize::try_from(degree).unwrap_or(0);
        if !(1..=MOST_DEGREE).contains(&degree) {
            return Err(format!("a spline of degree {degree} is not drawn"));
        }
        if count <= degree {
            return Err(format!(
                "a spline of degree {degree} needs more than {count} points"
            ));
        }
        let knots = if knots.is_empty() {
            even(degree, count)
        } else {
            knots
        };
        if knots.len() != count + degree + 1 {
            let needed = count + degree + 1;
            return Err(format!(
                "a spline has {} knots, and needs {needed}",
                knots.len()
            ));
        }
        if !knots.is_sorted() {
            return Err("the knots of a spline do not increase".to_owned());
        }
        if !(weights.is_empty() || weights.len() == count) || weights.iter().any(|w| *w <= 0.0) {
            return Err("the weights of a spline must be above 0, one for each point".to_owned());
        }
        let weights = weights.iter().copied().chain(std::iter::repeat(1.0));
        let controls = points.iter().zip(weights);
        Ok(Self {
            degree,
            knots,
            controls: controls.map(|(p, w)| [p.x * w, p.y * w, w]).collect(),
        })
    }

    /// Its points, both ends included, so that no chord is farther from it than the tolerance; at most so many.
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
            self.flatten(span, ends, tolerance, HALVINGS, most, &mut points);
        }
        points
    }

    /// Halves a piece until every part is as good as its chord.
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
            off_chord(at, from.1, to.1) > tolerance
        };
        if halvings == 0 || points.len() >= most || !CHECKS.iter().any(strays) {
            points.push(to.1);
            return;
        }
        let middle = f64::midpoint(from.0, to.0);
        let middle = (middle, self.at(span, middle));
        self.flatten(span, [from, middle], tolerance, halvings - 1, most, points);
        self.flatten(span, [middle, to], tolerance, halvings - 1, most, points);
    }

    /// The point at a parameter within a span of knots (de Boor).
    fn at(&self, span: usize, u: f64) -> Point {
        let first = span - self.degree;
        let mut near = [[0.0; 3]; MOST_DEGREE + 1];
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

/// Even knots that make a spline begin and end at its first and last point.
fn even(degree: usize, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(degree);
    let knots = 0..count + degree + 1;
    knots
        .map(|nth| nth.saturating_sub(degree).min(last) as f64)
        .collect()
}

fn off_chord(point: Point, from: Point, to: Point) -> f64 {
    let (chord, way) = (to - from, point - from);
    let square = chord.hypot2();
    let share = if square > 0.0 {
        (chord.dot(way) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (way - chord * share).hypot()
}
