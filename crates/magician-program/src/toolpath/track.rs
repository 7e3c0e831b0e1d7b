//! Polylines for a picture, simplified to its resolution.
//!
//! Points are thinned as they arrive, with memory for the result only. A cone of directions from
//! the last kept corner contains every straight line that passes all points since within the
//! tolerance; when a point empties the cone, the previous point becomes a corner.

/// Polylines in a plane, thinned as they arrive: the result is within the tolerance everywhere.
#[derive(Clone, Debug)]
pub struct Track {
    points: Vec<[f64; 2]>,
    /// Index in `points` at which each line begins.
    starts: Vec<usize>,
    tolerance: f64,
    /// Last point, if it is not kept yet.
    last: Option<[f64; 2]>,
    cone: Cone,
}

/// Directions from the last corner in which a line passes all later points within the tolerance.
#[derive(Clone, Copy, Debug, Default)]
struct Cone {
    /// Right and left edge; `None` until a point is far enough away.
    edges: Option<[[f64; 2]; 2]>,
    /// Distance of the farthest point.
    reach: f64,
}

impl Track {
    /// An empty track with this tolerance, mm.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            points: Vec::new(),
            starts: Vec::new(),
            tolerance,
            last: None,
            cone: Cone::default(),
        }
    }

    /// True if there is no line.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Begins a line at a point, unless the current line ends there.
    pub fn begin(&mut self, at: [f64; 2]) {
        if !self.starts.is_empty() && self.end() == Some(at) {
            return;
        }
        self.settle();
        self.starts.push(self.points.len());
        self.points.push(at);
    }

    /// Continues to a point.
    pub fn line_to(&mut self, to: [f64; 2]) {
        let Some(anchor) = self.points.last() else {
            self.begin(to);
            return;
        };
        if !self.cone.narrow(minus(to, *anchor), self.tolerance)
            && let Some(last) = self.last
        {
            self.points.push(last);
            self.cone = Cone::default();
            self.cone.narrow(minus(to, last), self.tolerance);
        }
        self.last = Some(to);
    }

    /// Lines, after [`settle`](Self::settle).
    pub fn lines(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        let ends = self.starts.iter().skip(1).copied();
        let ends = ends.chain([self.points.len()]);
        let ranges = self.starts.iter().zip(ends);
        ranges.filter_map(|(start, end)| self.points.get(*start..end))
    }

    /// Copy with a coarser tolerance.
    pub(super) fn thinned(&self, tolerance: f64) -> Self {
        let mut thinner = Self::new(tolerance);
        for line in self.lines() {
            for (nth, point) in line.iter().enumerate() {
                match nth {
                    0 => thinner.begin(*point),
                    _ => thinner.line_to(*point),
                }
            }
        }
        thinner.settle();
        thinner
    }

    /// Number of corners.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    fn end(&self) -> Option<[f64; 2]> {
        self.last.or(self.points.last().copied())
    }

    /// Ends the current line.
    pub fn settle(&mut self) {
        self.points.extend(self.last.take());
        self.cone = Cone::default();
    }
}

impl Cone {
    /// Narrows the cone by a point. False if no straight line passes this point and all earlier
    /// ones within the tolerance.
    fn narrow(&mut self, offset: [f64; 2], tolerance: f64) -> bool {
        let distance = libm::hypot(offset[0], offset[1]);
        if distance < self.reach - tolerance {
            return false;
        }
        self.reach = self.reach.max(distance);
        if distance <= tolerance {
            return self.edges.is_none();
        }
        let sin = tolerance / distance;
        let cos = (1.0 - sin * sin).sqrt();
        let [x, y] = offset;
        let mut right = [x * cos + y * sin, y * cos - x * sin];
        let mut left = [x * cos - y * sin, y * cos + x * sin];
        if let Some([old_right, old_left]) = self.edges {
            if cross(old_right, offset) < 0.0 || cross(offset, old_left) < 0.0 {
                return false;
            }
            if cross(old_right, right) < 0.0 {
                right = old_right;
            }
            if cross(left, old_left) < 0.0 {
                left = old_left;
            }
        }
        self.edges = Some([right, left]);
        true
    }
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thinned(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
        let mut track = Track::new(tolerance);
        for (nth, point) in points.iter().enumerate() {
            match nth {
                0 => track.begin(*point),
                _ => track.line_to(*point),
            }
        }
        track.settle();
        track.lines().next().map(<[_]>::to_vec).unwrap_or_default()
    }

    fn distance(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
        let (offset, to) = (minus(b, a), minus(point, a));
        let square = offset[0] * offset[0] + offset[1] * offset[1];
        let share = (to[0] * offset[0] + to[1] * offset[1]) / square.max(1e-30);
        let share = share.clamp(0.0, 1.0);
        libm::hypot(to[0] - share * offset[0], to[1] - share * offset[1])
    }

    #[test]
    fn straight_line_has_two_vertices() {
        let points: Vec<_> = (0..1000).map(|nth| [f64::from(nth) * 0.01, 1.0]).collect();
        assert_eq!(thinned(&points, 0.02), [[0.0, 1.0], [9.99, 1.0]]);
    }

    #[test]
    fn reversal_is_kept() {
        let points = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [5.0, 0.0], [-5.0, 0.0]];
        let kept = thinned(&points, 0.02);
        assert_eq!(kept, [[0.0, 0.0], [10.0, 0.0], [-5.0, 0.0]]);
    }

    #[test]
    fn thinned_points_stay_within_the_tolerance() {
        let tolerance = 0.05;
        let points: Vec<[f64; 2]> = (0..5000)
            .map(|nth| {
                let t = f64::from(nth) * 0.003;
                [20.0 * libm::sin(1.7 * t) + t, 15.0 * libm::cos(2.3 * t)]
            })
            .collect();
        let kept = thinned(&points, tolerance);
        assert!(kept.len() < points.len() / 4, "{}", kept.len());
        for point in &points {
            let nearest = kept
                .windows(2)
                .map(|pair| distance(*point, [pair[0], pair[1]]));
            let nearest = nearest.fold(f64::MAX, f64::min);
            assert!(nearest <= 1.01 * tolerance, "{point:?}: {nearest}");
        }
    }

    #[test]
    fn lines_stay_apart() {
        let mut track = Track::new(0.02);
        for x in [0.0, 10.0] {
            track.begin([x, 0.0]);
            track.line_to([x, 5.0]);
        }
        track.begin([10.0, 5.0]);
        track.line_to([12.0, 5.0]);
        track.settle();
        let lines: Vec<_> = track.lines().map(<[_]>::to_vec).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[1], [[10.0, 0.0], [10.0, 5.0], [12.0, 5.0]]);
    }
}
