//! Nesting: which strokes lie within which closed stroke.
//!
//! Bounding boxes and horizontal strips narrow down the candidates; a ray cast decides. The cost
//! stays near-linear for drawings of many separate shapes.

use std::ops::Range;

use super::super::Stroke;

/// Largest number of strips per drawing or stroke. A choice that bounds memory.
const MAX_STRIPS: usize = 1024;
/// Largest number of enclosing strokes to search per stroke. Those beyond enclose the found ones
/// themselves, so they are reached from there.
const MAX_ENCLOSING: usize = 256;
/// Largest number of segments to probe per stroke. A choice: a stroke that is only partly inside is
/// rare.
const MAX_PROBES: usize = 8;

/// Returns for each stroke the index of the closed stroke around it, or `None`.
///
/// A stroke may lie within several that do not contain each other. These are chained by size, so
/// that following the chain visits all of them.
pub(super) fn enclosing_strokes(strokes: &[Stroke]) -> Vec<Option<usize>> {
    let boxes: Vec<Bounds> = strokes.iter().map(Bounds::of).collect();
    let mut closed: Vec<ClosedStroke<'_>> = (strokes.iter().zip(&boxes).enumerate())
        .filter(|(_, (stroke, bounds))| stroke.is_closed() && bounds.area() > 0.0)
        .map(|(index, (stroke, bounds))| ClosedStroke::new(index, stroke, *bounds))
        .collect();
    closed.sort_by(|one, other| one.bounds.area().total_cmp(&other.bounds.area()));
    let all = boxes.iter().fold(Bounds::NONE, |all, one| all.with(*one));
    let strips = Strips::new([all.least[1], all.most[1]], closed.len());
    let mut by_strip = vec![Vec::new(); strips.count];
    for (at, shape) in closed.iter().enumerate() {
        for strip in strips.of([shape.bounds.least[1], shape.bounds.most[1]]) {
            by_strip[strip].push(at);
        }
    }
    let mut tree = Tree::new(strokes.len(), closed.iter().map(|shape| shape.index));
    for (line, (stroke, bounds)) in strokes.iter().zip(&boxes).enumerate() {
        let strip = strips.of([bounds.least[1]; 2]).start;
        let Some(candidates) = by_strip.get(strip) else {
            continue;
        };
        // Candidates are sorted by size, so skip those smaller than the stroke.
        let from = candidates.partition_point(|at| closed[*at].bounds.area() <= bounds.area());
        let larger = candidates[from..].iter().map(|at| &closed[*at]);
        let around = larger.filter(|shape| shape.bounds.contain(bounds) && shape.contain(stroke));
        let mut within = line;
        for shape in around.take(MAX_ENCLOSING) {
            tree.insert(within, shape.index);
            within = shape.index;
        }
    }
    tree.around
}

/// Parent of each stroke: the closed stroke around it.
struct Tree {
    around: Vec<Option<usize>>,
    /// Rank of each closed stroke by size.
    rank: Vec<usize>,
}

impl Tree {
    fn new(count: usize, by_size: impl Iterator<Item = usize>) -> Self {
        let mut rank = vec![0; count];
        by_size.enumerate().for_each(|(at, line)| rank[line] = at);
        Self {
            around: vec![None; count],
            rank,
        }
    }

    /// Inserts a larger closed stroke into the chain of a stroke, which is sorted by size.
    fn insert(&mut self, mut line: usize, mut into: usize) {
        while let Some(next) = self.around[line].replace(into) {
            if next == into {
                return;
            }
            if self.rank[next] < self.rank[into] {
                self.around[line] = Some(next);
                line = next;
            } else {
                line = std::mem::replace(&mut into, next);
            }
        }
    }
}

/// Axis-aligned bounding box.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    least: [f64; 2],
    most: [f64; 2],
}

impl Bounds {
    const NONE: Self = Self {
        least: [f64::INFINITY; 2],
        most: [f64::NEG_INFINITY; 2],
    };

    fn of(stroke: &Stroke) -> Self {
        let points = stroke.points.iter().map(|point| Self {
            least: *point,
            most: *point,
        });
        points.fold(Self::NONE, Self::with)
    }

    fn with(self, other: Self) -> Self {
        Self {
            least: [0, 1].map(|axis| self.least[axis].min(other.least[axis])),
            most: [0, 1].map(|axis| self.most[axis].max(other.most[axis])),
        }
    }

    fn area(&self) -> f64 {
        (self.most[0] - self.least[0]) * (self.most[1] - self.least[1])
    }

    fn contain(&self, other: &Self) -> bool {
        let within = |axis: usize| {
            self.least[axis] <= other.least[axis] && other.most[axis] <= self.most[axis]
        };
        within(0) && within(1)
    }
}

/// An even division of a range of y, for finding what is at a y without searching everything.
#[derive(Clone, Copy, Debug)]
struct Strips {
    least: f64,
    height: f64,
    count: usize,
}

impl Strips {
    /// Creates about one strip per item.
    fn new([least, most]: [f64; 2], items: usize) -> Self {
        let count = items.clamp(1, MAX_STRIPS);
        let height = (most - least) / count as f64;
        Self {
            least,
            height: height.max(f64::MIN_POSITIVE),
            count,
        }
    }

    /// Returns the strips between two values of y.
    fn of(&self, heights: [f64; 2]) -> Range<usize> {
        let [from, to] = heights
            .map(|height| (((height - self.least) / self.height) as usize).min(self.count - 1));
        from..to + 1
    }
}

/// A closed stroke with its segments by strip.
struct ClosedStroke<'a> {
    index: usize,
    stroke: &'a Stroke,
    bounds: Bounds,
    strips: Strips,
    /// Index of the first vertex of each segment that crosses a strip.
    segments: Vec<Vec<usize>>,
}

impl<'a> ClosedStroke<'a> {
    fn new(index: usize, stroke: &'a Stroke, bounds: Bounds) -> Self {
        let strips = Strips::new([bounds.least[1], bounds.most[1]], stroke.points.len() / 2);
        let mut segments = vec![Vec::new(); strips.count];
        for (at, ends) in stroke.points.windows(2).enumerate() {
            let [low, high] = [ends[0][1].min(ends[1][1]), ends[0][1].max(ends[1][1])];
            for strip in strips.of([low, high]) {
                segments[strip].push(at);
            }
        }
        Self {
            index,
            stroke,
            bounds,
            strips,
            segments,
        }
    }

    /// True if a stroke lies within. Tests the middles of a few segments, because vertices may
    /// touch the closed stroke.
    fn contain(&self, line: &Stroke) -> bool {
        let segments = line.points.len().saturating_sub(1);
        let probed = line
            .points
            .windows(2)
            .step_by(segments.div_ceil(MAX_PROBES).max(1));
        let mut middles =
            probed.map(|ends| [0, 1].map(|axis| ends[0][axis].midpoint(ends[1][axis])));
        segments > 0 && middles.all(|middle| self.surrounds(middle))
    }

    /// True if a ray from the point crosses the stroke an odd number of times.
    fn surrounds(&self, [x, y]: [f64; 2]) -> bool {
        let strip = self.strips.of([y; 2]).start;
        let points = &self.stroke.points;
        let crossed = self.segments[strip].iter().filter(|at| {
            let [[x0, y0], [x1, y1]] = [points[**at], points[**at + 1]];
            (y0 <= y) != (y1 <= y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
        });
        crossed.count() % 2 == 1
    }
}
