//! Search for the best place of a drawing within the arm's reach.
//!
//! For a fixed point the drawing can be scaled about, there is exactly one largest scale, found by
//! bisection. The point itself is searched on a grid and refined by shrinking steps around the best
//! one (pattern search). While searching, edges are sampled; the result is checked exactly and
//! shrunk until it passes.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::{Fit, Reach, SheetTransform, hull};
use crate::Diagnostic;
use crate::artwork::distance;

/// Spacing of the grid of first candidates, mm. A choice between time and the risk of missing a
/// narrow place.
const GRID_SPACING: f64 = 10.0;
/// Share of the size kept free at the edges, because coordinates are rounded to 32 bits on their
/// way to the arm.
const MARGIN_SHARE: f64 = 1e-4;
/// Ratio of sizes from which a place beside the arm is preferred to one in front. A user expects
/// the drawing in front, so a small gain is not enough.
const MIN_SIDE_GAIN: f64 = 1.01;
/// Tolerance for a drawing to count as in front of the arm: distance from the line straight ahead,
/// mm. It absorbs rounding.
const FRONT_TOLERANCE: f64 = 0.01;
/// Sampling distance along edges during the search, mm. The place found is checked exactly
/// afterwards.
const SAMPLE_DISTANCE: f64 = 15.0;
/// Relative precision of the size. Far finer than a user can notice.
const SIZE_PRECISION: f64 = 1e-5;

impl Reach {
    /// Finds the best place for a drawing with these points: all of it, and every straight way
    /// between two of its points, is within reach on the surface and at the lift above it.
    ///
    /// In true size the drawing goes as near as possible to the middle of the reach straight ahead:
    /// in front of the arm, so that the line straight ahead passes through it, or beside the arm if
    /// it fits nowhere in front. Otherwise it goes where it can be largest, again in front unless
    /// it is larger beside.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the size of the drawing and the largest size that fits, or if a point
    /// is not finite.
    pub fn best_place(
        &self,
        hull_points: &[[f64; 2]],
        fit: Fit,
    ) -> Result<SheetTransform, Diagnostic> {
        let numbers = hull_points.as_flattened();
        if numbers
            .iter()
            .any(|number| number.abs() >= 1e9 || number.is_nan())
        {
            return Err(Diagnostic::of_file(message!(
                "a point of the drawing is not a number, or out of range"
            )));
        }
        let shape = Shape::of(hull_points);
        if shape.corners.is_empty() {
            return Err(Diagnostic::of_file(message!(
                "nothing to place: the drawing is empty"
            )));
        }
        let Some([near, far]) = self.ahead() else {
            return Err(self.nothing_in_reach());
        };
        let search = Search {
            reach: self,
            shape: &shape,
            preferred: [0.5 * (near + far), 0.0],
        };
        if fit != Fit::Fill
            && let Some(at) = search.true_size()
        {
            return Ok(shape.placed(at, 1.0));
        }
        if shape.is_a_point() {
            return Ok(shape.placed(search.preferred, 1.0));
        }
        let largest = search
            .largest()
            .and_then(|best| search.shrunk_to_hold(best));
        let (at, scale) = largest.ok_or_else(|| self.nothing_in_reach())?;
        if fit == Fit::TrueSize {
            return Err(self.too_large(&shape, scale));
        }
        Ok(shape.placed(at, scale))
    }

    fn nothing_in_reach(&self) -> Diagnostic {
        let (height, lift) = (self.surface.at([200.0, 0.0]), self.lift);
        let message = message!(
            "nothing is within reach on a surface at z = {height:.1} mm with the tool lifted by {lift} mm",
            height,
            lift
        );
        Diagnostic::of_file(message).help(message!(
            "check the height of the surface, the lift and the tool"
        ))
    }

    fn too_large(&self, shape: &Shape, scale: f64) -> Diagnostic {
        let [width, height] = shape.size;
        let message = message!(
            "the drawing is {width:.1} x {height:.1} mm; the largest of that shape that fits is \
                {width_2:.1} x {height_2:.1} mm",
            width,
            height,
            width_2 = scale * width,
            height_2 = scale * height
        );
        let percent = 100.0 * scale;
        Diagnostic::of_file(message)
            .remedy(
                (Setting::Fit, SettingValue::On),
                format!("scales it to {percent:.0} %"),
            )
            .remedy(
                (Setting::Rotate, SettingValue::Number(90.0)),
                "may leave it larger",
            )
    }
}

/// Convex hull of a drawing.
struct Shape {
    /// Vertices relative to the middle.
    corners: Vec<[f64; 2]>,
    /// Point inside the hull about which it is scaled.
    middle: [f64; 2],
    /// Width and height.
    size: [f64; 2],
    /// Smallest and largest y of the vertices, relative to the middle.
    across: [f64; 2],
}

impl Shape {
    fn of(points: &[[f64; 2]]) -> Self {
        let hull = hull::of(points);
        let middle = hull::middle(&hull);
        let corners = hull.iter().map(|[x, y]| [x - middle[0], y - middle[1]]);
        let extent = |axis: usize| {
            let values = || hull.iter().filter_map(|corner| corner.get(axis).copied());
            let most = values().fold(f64::NEG_INFINITY, f64::max);
            (most - values().fold(f64::INFINITY, f64::min)).max(0.0)
        };
        let corners: Vec<_> = corners.collect();
        let across = corners.iter().fold([0.0_f64; 2], |[least, most], [_, y]| {
            [least.min(*y), most.max(*y)]
        });
        Self {
            corners,
            middle,
            size: [extent(0), extent(1)],
            across,
        }
    }

    fn is_a_point(&self) -> bool {
        self.size == [0.0, 0.0]
    }

    /// Smallest scale at which the line straight ahead of the arm passes through the shape with its
    /// middle at a point.
    fn least_in_front(&self, [_, y]: [f64; 2]) -> f64 {
        let [least, most] = self.across;
        match y {
            y if y > FRONT_TOLERANCE => y / -least,
            y if y < -FRONT_TOLERANCE => -y / most,
            _ => 0.0,
        }
    }

    /// Returns the transform that puts the middle at a point.
    fn placed(&self, [x, y]: [f64; 2], scale: f64) -> SheetTransform {
        let [mx, my] = self.middle;
        SheetTransform {
            scale,
            offset: [x - scale * mx, y - scale * my],
        }
    }

    fn corners_at(&self, [x, y]: [f64; 2], scale: f64) -> impl Iterator<Item = [f64; 2]> + Clone {
        let corners = self.corners.iter();
        corners.map(move |corner| [x + scale * corner[0], y + scale * corner[1]])
    }

    /// Iterates over the edges as pairs of points.
    fn edges_at(&self, at: [f64; 2], scale: f64) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let next = self.corners_at(at, scale).cycle().skip(1);
        self.corners_at(at, scale).zip(next).map(|(a, b)| [a, b])
    }
}

/// Area in which to search a place.
#[derive(Clone, Copy, Debug)]
enum Area {
    /// In front of the arm: the line straight ahead passes through the shape.
    Front,
    /// Anywhere within reach.
    Anywhere,
}

/// Search for the place of a shape. Scaling about an inner point is monotonic: a smaller shape lies
/// within a larger one. So each place has exactly one largest scale.
struct Search<'s> {
    reach: &'s Reach,
    shape: &'s Shape,
    /// Preferred position of the middle.
    preferred: [f64; 2],
}

impl Search<'_> {
    /// True if the shape fits at a place, judged by samples along its edges.
    fn fits(&self, at: [f64; 2], scale: f64) -> bool {
        let scale = scale * (1.0 + MARGIN_SHARE);
        self.reach.has(at)
            && self
                .shape
                .corners_at(at, scale)
                .all(|corner| self.reach.has(corner))
            && self
                .shape
                .edges_at(at, scale)
                .all(|edge| self.has_edge(edge))
    }

    fn has_edge(&self, [a, b]: [[f64; 2]; 2]) -> bool {
        // The base cannot turn through the rear, so a line behind the arm is impossible.
        let crosses_behind = (a[1] > 0.0) != (b[1] > 0.0)
            && (a[0] * (b[1] - a[1]) - a[1] * (b[0] - a[0])) * (b[1] - a[1]).signum() < 0.0;
        let step = [b[0] - a[0], b[1] - a[1]];
        let point = |share: f64| [a[0] + share * step[0], a[1] + share * step[1]];
        let square = step[0] * step[0] + step[1] * step[1];
        let nearest = -(a[0] * step[0] + a[1] * step[1]) / square;
        let pieces = (square.sqrt() / SAMPLE_DISTANCE).ceil().min(1e3) as u32;
        !crosses_behind
            && (!(0.0..1.0).contains(&nearest) || self.reach.has(point(nearest)))
            && (1..pieces).all(|piece| self.reach.has(point(f64::from(piece) / f64::from(pieces))))
    }

    /// True if every way along its edges is within reach, checked exactly. Checking the edges is
    /// enough: the unreachable area near the base is open to the rear, so it cannot be a hole
    /// inside the shape.
    fn holds_exactly(&self, at: [f64; 2], scale: f64) -> bool {
        let scale = scale * (1.0 + MARGIN_SHARE);
        let mut edges = self.shape.edges_at(at, scale);
        edges.all(|[a, b]| self.reach.contains_line(a, b).is_ok())
    }

    /// Returns the points of a grid within the farthest reach, nearest to the preferred one first.
    fn places(&self) -> Vec<[f64; 2]> {
        let most = (2.0 * self.preferred[0] / GRID_SPACING).ceil().min(60.0) as i32;
        let ahead = self.preferred[0];
        let grid = (-2 * most..=most).flat_map(|x| (-most..=most).map(move |y| (x, y)));
        let mut places: Vec<[f64; 2]> = grid
            .map(|(x, y)| {
                [
                    ahead + f64::from(x) * GRID_SPACING,
                    f64::from(y) * GRID_SPACING,
                ]
            })
            .filter(|at| self.reach.has(*at))
            .collect();
        places
            .sort_by(|a, b| distance(*a, self.preferred).total_cmp(&distance(*b, self.preferred)));
        places
    }

    /// Returns the place nearest to the preferred one for the true size: in front of the arm, else
    /// beside it.
    fn true_size(&self) -> Option<[f64; 2]> {
        let places = self.places();
        let fits = |at: &[f64; 2]| self.fits(*at, 1.0) && self.holds_exactly(*at, 1.0);
        let in_front = |at: &[f64; 2]| self.shape.least_in_front(*at) <= 1.0;
        let ahead = places.iter().find(|at| in_front(at) && fits(at)).copied();
        // A place with just enough room is unlikely to be on the grid, so search by size.
        let tight = |area: Area| {
            let (at, scale) = self.largest_in(area, &places)?;
            (scale >= 1.0 && fits(&at)).then_some(at)
        };
        ahead
            .or_else(|| tight(Area::Front))
            .or_else(|| places.iter().find(|at| fits(at)).copied())
            .or_else(|| tight(Area::Anywhere))
    }

    /// Returns the place with the largest size, and the size: in front unless it is clearly larger
    /// beside.
    fn largest(&self) -> Option<([f64; 2], f64)> {
        let places = self.places();
        let front = self.largest_in(Area::Front, &places);
        let anywhere = self.largest_in(Area::Anywhere, &places);
        let is_larger = |(_, beside): &([f64; 2], f64)| {
            front.is_none_or(|(_, ahead)| *beside > MIN_SIDE_GAIN * ahead)
        };
        anywhere.filter(is_larger).or(front)
    }

    fn largest_in(&self, area: Area, places: &[[f64; 2]]) -> Option<([f64; 2], f64)> {
        let mut best: Option<([f64; 2], f64)> = None;
        for at in places {
            best = self.better(area, best, *at);
        }
        let mut step = GRID_SPACING;
        while step > 0.01 {
            let (at, _) = best?;
            let round = [
                [1.0, 0.0],
                [-1.0, 0.0],
                [0.0, 1.0],
                [0.0, -1.0],
                [1.0, 1.0],
                [1.0, -1.0],
                [-1.0, 1.0],
                [-1.0, -1.0],
            ];
            let improved = round.iter().fold(best, |best, [x, y]| {
                self.better(area, best, [at[0] + step * x, at[1] + step * y])
            });
            if improved == best {
                step *= 0.5;
            }
            best = improved;
        }
        best
    }

    /// Returns the better of the current best place and another.
    fn better(
        &self,
        area: Area,
        best: Option<([f64; 2], f64)>,
        at: [f64; 2],
    ) -> Option<([f64; 2], f64)> {
        let least = best.map_or(0.0, |(_, scale)| scale * (1.0 + SIZE_PRECISION));
        let least = match area {
            Area::Front => least.max(self.shape.least_in_front(at)),
            Area::Anywhere => least,
        };
        if !least.is_finite() || !self.fits(at, least) {
            return best;
        }
        let (mut low, mut high) = (least, f64::max(2.0 * least, 1e-6));
        while self.fits(at, high) && high < 1e9 {
            (low, high) = (high, 2.0 * high);
        }
        while high - low > 0.1 * SIZE_PRECISION * high {
            let middle = 0.5 * (low + high);
            if self.fits(at, middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some((at, low)).filter(|_| low > 0.0).or(best)
    }

    /// Shrinks the shape at a place until all of its ways pass the exact check. `None` after 500
    /// steps of 1 %.
    fn shrunk_to_hold(&self, (at, mut scale): ([f64; 2], f64)) -> Option<([f64; 2], f64)> {
        for _ in 0..500 {
            if self.holds_exactly(at, scale) {
                return Some((at, scale));
            }
            scale *= 0.99;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use magician_host::ToolBias;
    use magician_motion::ArmModel;

    use super::*;
    use crate::Surface;

    const SHEET: [[f64; 2]; 4] = [[0.0, 0.0], [297.0, 0.0], [297.0, 210.0], [0.0, 210.0]];

    fn reach() -> Reach {
        Reach::new(ToolBias::PEN, Surface::level(-60.0), 20.0)
    }

    fn lies_within(reach: &Reach, points: &[[f64; 2]], place: &SheetTransform) {
        for a in points {
            for b in points {
                let line = reach.contains_line(place.of(*a), place.of(*b));
                assert!(line.is_ok(), "{place:?} {a:?} {b:?}: {line:?}");
            }
        }
    }

    #[test]
    fn fitting_shape_is_placed_at_true_size_in_the_middle() {
        let small = SHEET.map(|[x, y]| [0.2 * x, 0.2 * y]);
        for fit in [Fit::TrueSize, Fit::Shrink] {
            let place = reach().best_place(&small, fit).unwrap();
            lies_within(&reach(), &small, &place);
            assert_eq!(place.scale, 1.0);
            assert_eq!(place.offset[1], -21.0, "symmetric about the arm's x axis");
        }
    }

    #[test]
    fn oversize_shape_is_refused_with_both_sizes_or_shrunk() {
        let diagnostic = reach().best_place(&SHEET, Fit::TrueSize).unwrap_err();
        assert!(
            diagnostic.message.contains("297.0 x 210.0 mm"),
            "{diagnostic}"
        );
        let place = reach().best_place(&SHEET, Fit::Shrink).unwrap();
        lies_within(&reach(), &SHEET, &place);
        let largest = format!("{:.1} x {:.1} mm", 297.0 * place.scale, 210.0 * place.scale);
        assert!(
            diagnostic.message.contains(&largest),
            "{diagnostic} {largest}"
        );
        // No larger one fits there.
        assert!(place.scale > 0.4 && place.scale < 1.0);
        let larger = SheetTransform {
            scale: 1.01 * place.scale,
            ..place
        };
        assert!(
            SHEET
                .iter()
                .any(|corner| reach().contains(larger.of(*corner)).is_err())
        );
    }

    #[test]
    fn wide_drawing_is_beside_the_arm_only_if_it_fits_nowhere_in_front() {
        for (size, in_front) in [
            ([150.0, 20.0], true),
            ([240.0, 20.0], false),
            ([20.0, 240.0], true),
        ] {
            let [width, height] = size;
            let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
            let place = reach().best_place(&corners, Fit::TrueSize).unwrap();
            lies_within(&reach(), &corners, &place);
            let [low, high] = [0.0, height].map(|y| place.of([0.0, y])[1]);
            assert_eq!(
                low <= 0.0 && high >= 0.0,
                in_front,
                "{size:?}: {low} {high}"
            );
        }
    }

    /// Size and place are searched together, so no larger size fits anywhere.
    #[test]
    fn largest_size_is_that_of_the_best_place_in_reach() {
        for [width, height] in [
            [500.0, 200.0],
            [300.0, 200.0],
            [600.0, 60.0],
            [100.0, 500.0],
            [300.0, 300.0],
        ] {
            let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
            let place = reach().best_place(&corners, Fit::Shrink).unwrap();
            lies_within(&reach(), &corners, &place);
            let larger = 1.02 * place.scale;
            let shape = Shape::of(&corners);
            let search = Search {
                reach: &reach(),
                shape: &shape,
                preferred: [0.0, 0.0],
            };
            for degrees in -90..=90 {
                let (sin, cos) = libm::sincos(1.5 * f64::from(degrees).to_radians());
                for radius in 60..160 {
                    let radius = 2.0 * f64::from(radius);
                    let at = [radius * cos, radius * sin];
                    assert!(
                        !search.fits(at, larger),
                        "{width} x {height}: {larger} at {at:?}, {place:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn filling_shape_touches_the_edge() {
        let small = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 1.2]];
        let place = reach().best_place(&small, Fit::Fill).unwrap();
        lies_within(&reach(), &small, &place);
        assert!(place.scale > 100.0, "{place:?}");
        let ends = small.map(|corner| place.of(corner));
        let room = ends
            .iter()
            .map(|[x, y]| libm::hypot(*x, *y))
            .fold(0.0, f64::max);
        let [_, far] = reach().ahead().unwrap();
        assert!(far - room < 0.1, "{room} of {far}");
    }

    #[test]
    fn reach_follows_tilt_rotation_and_sideways_bias() {
        let tilted = Surface {
            height: -60.0,
            slope: [0.1, -0.05],
        };
        for reach in [
            Reach::new(ToolBias::LASER, tilted, 5.0),
            reach().rotated_to(120.0),
            Reach::new(ToolBias::new(60.0, 25.0, 10.0), Surface::level(0.0), 30.0),
            reach().limits(ArmModel::MAGICIAN.guaranteed),
        ] {
            let place = reach.best_place(&SHEET, Fit::Shrink).unwrap();
            lies_within(&reach, &SHEET, &place);
            assert!(place.scale > 0.2, "{place:?}");
            let outline = reach.outline();
            assert!(!outline.is_empty());
            for [x, y] in outline.concat() {
                let inwards = |by: f64| {
                    let (distance, heading) = (libm::hypot(x, y) + by, libm::atan2(y, x));
                    reach.has([distance * libm::cos(heading), distance * libm::sin(heading)])
                };
                assert!(inwards(0.01) || inwards(-0.01) || inwards(0.0), "{x} {y}");
            }
        }
    }

    #[test]
    fn invalid_values_are_refused() {
        assert!(reach().best_place(&[], Fit::Fill).is_err());
        assert!(reach().best_place(&[[f64::NAN, 0.0]], Fit::Fill).is_err());
        assert!(
            reach()
                .best_place(&[[1e300, 0.0], [0.0, 0.0]], Fit::Shrink)
                .is_err()
        );
        let far = Reach::new(ToolBias::PEN, Surface::level(-400.0), 20.0);
        assert!(far.best_place(&SHEET, Fit::Shrink).is_err());
        assert!(far.outline().is_empty());
        let dot = reach().best_place(&[[3.0, 4.0]], Fit::Fill).unwrap();
        assert_eq!(dot.scale, 1.0);
        let line = reach().best_place(&[[3.0, 4.0], [500.0, 4.0]], Fit::Shrink);
        assert!(line.is_ok_and(|place| place.scale < 1.0));
    }

    #[test]
    fn outline_is_one_area_over_the_range_of_j1() {
        let outline = reach().outline();
        assert_eq!(outline.len(), 1);
        let headings = outline[0]
            .iter()
            .map(|[x, y]| libm::atan2(*y, *x).to_degrees());
        let widest = headings.map(f64::abs).fold(0.0, f64::max);
        assert!((widest - 135.0).abs() < 0.01, "{widest}");
        assert_eq!(outline[0].first(), outline[0].last());
    }

    #[test]
    fn errors_state_the_tool_position() {
        let [_, far] = Reach::new(ToolBias::PEN, Surface::level(-60.0), 0.0)
            .ahead()
            .unwrap();
        let reach = Reach::new(ToolBias::PEN, Surface::level(-60.0), -60.0);
        let error = reach.contains([far - 0.1, 0.0]).unwrap_err();
        assert!(error.to_string().contains("lifted by -60 mm"), "{error}");
        assert!(error.value().is_some() && error.limit().is_some());
    }
}
