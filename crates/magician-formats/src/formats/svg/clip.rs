//! Clipping of polylines to clip paths.
//!
//! A [`Region`] is the union of shapes, each clipped by further regions. A polyline is cut where it
//! crosses any edge of the region, and each piece is kept if its middle is inside.

use kurbo::Affine;
use usvg::{ClipPath, FillRule, Group, Node};

use super::collector::matrix;
use super::lines::{Closeness, Line, curves, flatten};
use crate::fill::{Area, Region as Shapes};

/// Largest number of tests of a segment against an edge per path. A choice; it takes about a
/// second.
const MAX_WORK: usize = 200_000_000;

/// A region: inside any of its shapes, and inside each further region.
#[derive(Clone, Debug, Default)]
pub(super) struct Region {
    /// Shapes in painting order, each with true if it shows what is within. All shapes of a clip
    /// path do.
    shapes: Vec<(Shape, bool)>,
    /// Further regions, which clip the clip path itself.
    also: Vec<Region>,
}

#[derive(Clone, Debug)]
pub(super) struct Shape {
    edges: Vec<[[f64; 2]; 2]>,
    rule: FillRule,
    /// Regions that clip this shape only.
    within: Vec<Region>,
    /// Distance from its edge within which a point counts as inside, mm: half of a stroke along the
    /// edge is visible.
    near: f64,
}

impl Region {
    /// Creates the region of a clip path, for content with this transform.
    pub(super) fn of(clip: &ClipPath, to: Affine, close: Closeness) -> Self {
        let to_own = to * matrix(clip.transform());
        let mut shapes = Vec::new();
        collect(clip.root(), to_own, &[], close, &mut shapes);
        let also = clip.clip_path().map(|outer| Self::of(outer, to, close));
        let shows = shapes.into_iter().map(|shape| (shape, true));
        Self {
            shapes: shows.collect(),
            also: also.into_iter().collect(),
        }
    }

    /// Creates a region that is visible where the topmost shape shows.
    pub(super) fn painted(shapes: Vec<(Shape, bool)>, also: Vec<Self>) -> Self {
        Self { shapes, also }
    }

    /// Creates the region inside a closed polyline.
    pub(super) fn inside(corners: &[[f64; 2]], near: f64) -> Self {
        let closed: Line = corners.iter().chain(corners.first()).copied().collect();
        let shape = Shape::new(&[closed], FillRule::NonZero, &[], near);
        Self {
            shapes: vec![(shape, true)],
            also: Vec::new(),
        }
    }

    /// Returns its inside as normalised shapes.
    pub(super) fn shapes(&self) -> Shapes {
        let painted = self
            .shapes
            .iter()
            .fold(Shapes::default(), |painted, (shape, shows)| {
                let own = shape.shapes();
                if *shows {
                    painted.joined(&own)
                } else {
                    painted.except(&own)
                }
            });
        let also = self.also.iter();
        also.fold(painted, |inside, region| inside.common(&region.shapes()))
    }

    fn edges(&self) -> usize {
        let own = self.shapes.iter().map(|(shape, _)| shape.edges());
        own.sum::<usize>() + self.also.iter().map(Self::edges).sum::<usize>()
    }

    fn contains(&self, at: [f64; 2]) -> bool {
        let uppermost = self
            .shapes
            .iter()
            .rev()
            .find(|(shape, _)| shape.contains(at));
        uppermost.is_some_and(|(_, shows)| *shows)
            && self.also.iter().all(|region| region.contains(at))
    }

    /// Collects where a segment crosses any edge, as shares of its length.
    fn crossings(&self, from: [f64; 2], to: [f64; 2], found: &mut Vec<f64>) {
        for (shape, _) in &self.shapes {
            let own = shape
                .edges
                .iter()
                .filter_map(|edge| crossing([from, to], *edge));
            found.extend(own);
            for region in &shape.within {
                region.crossings(from, to, found);
            }
        }
        for region in &self.also {
            region.crossings(from, to, found);
        }
    }

    /// Returns the parts of a polyline inside the region. `None` if that is too much work.
    pub(super) fn clip(&self, line: &Line) -> Option<Vec<Line>> {
        if line.len().saturating_mul(self.edges()) > MAX_WORK {
            return None;
        }
        if let [dot] = line.as_slice() {
            return Some(if self.contains(*dot) {
                vec![line.clone()]
            } else {
                vec![]
            });
        }
        let mut pieces: Vec<Line> = Vec::new();
        let mut open = Line::new();
        for (from, to) in line.iter().zip(line.iter().skip(1)) {
            let mut cuts = vec![0.0, 1.0];
            self.crossings(*from, *to, &mut cuts);
            cuts.sort_by(f64::total_cmp);
            cuts.dedup();
            let at = |share: f64| match share {
                1.0 => *to,
                _ => [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])),
            };
            for (start, end) in cuts.iter().zip(cuts.iter().skip(1)) {
                if !self.contains(at(f64::midpoint(*start, *end))) {
                    pieces.push(std::mem::take(&mut open));
                    continue;
                }
                if open.is_empty() {
                    open.push(at(*start));
                }
                open.push(at(*end));
            }
        }
        pieces.push(open);
        pieces.retain(|piece| piece.len() > 1);
        rejoin(line, &mut pieces);
        Some(pieces)
    }
}

/// Joins the last piece of a closed polyline to the first.
fn rejoin(line: &Line, pieces: &mut Vec<Line>) {
    let ends = pieces.first().and_then(|piece| piece.first());
    let begins = pieces.last().and_then(|piece| piece.last());
    let whole = line.first() == line.last() && ends == line.first() && begins == line.last();
    if whole
        && pieces.len() > 1
        && let Some(mut last) = pieces.pop()
        && let Some(first) = pieces.first_mut()
    {
        last.extend(first.iter().skip(1));
        *first = last;
    }
}

impl Shape {
    /// Creates a shape from closed polylines, limited to these regions.
    pub(super) fn new(outline: &[Line], rule: FillRule, within: &[Region], near: f64) -> Self {
        let edges = outline
            .iter()
            .flat_map(|line| line.iter().zip(line.iter().skip(1)));
        Self {
            edges: edges.map(|(from, to)| [*from, *to]).collect(),
            rule,
            within: within.to_vec(),
            near,
        }
    }

    fn shapes(&self) -> Shapes {
        let mut rings: Vec<Line> = Vec::new();
        let mut last = None;
        for [from, to] in &self.edges {
            match rings.last_mut().filter(|_| last == Some(from)) {
                Some(ring) => ring.push(*to),
                None => rings.push(vec![*from, *to]),
            }
            last = Some(to);
        }
        let rule = match self.rule {
            FillRule::NonZero => crate::fill::FillRule::NonZero,
            FillRule::EvenOdd => crate::fill::FillRule::EvenOdd,
        };
        let whole = Shapes::of(&Area { rings, rule });
        let within = self.within.iter();
        within.fold(whole, |inside, region| inside.common(&region.shapes()))
    }

    pub(super) fn edges(&self) -> usize {
        self.edges.len() + self.within.iter().map(Region::edges).sum::<usize>()
    }

    pub(super) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let mut winding = 0;
        for [from, to] in &self.edges {
            let up = from[1] <= y && to[1] > y;
            let down = from[1] > y && to[1] <= y;
            if !(up || down) {
                continue;
            }
            let share = (y - from[1]) / (to[1] - from[1]);
            if from[0] + share * (to[0] - from[0]) > x {
                winding += if up { 1 } else { -1 };
            }
        }
        let inside = match self.rule {
            FillRule::NonZero => winding != 0,
            FillRule::EvenOdd => winding % 2 != 0,
        };
        (inside
            || self
                .edges
                .iter()
                .any(|edge| off_edge([x, y], *edge) <= self.near))
            && self.within.iter().all(|region| region.contains([x, y]))
    }
}

/// Distance of a point from an edge, mm.
fn off_edge(at: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let edge = [to[0] - from[0], to[1] - from[1]];
    let way = [at[0] - from[0], at[1] - from[1]];
    let length = edge[0] * edge[0] + edge[1] * edge[1];
    let share = (way[0] * edge[0] + way[1] * edge[1]) / length;
    // A zero-length edge yields NaN.
    let share = if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(way[0] - share * edge[0], way[1] - share * edge[1])
}

/// Returns where a segment crosses another, as a share of the first; `None` if they are parallel or
/// do not cross.
fn crossing([from, to]: [[f64; 2]; 2], [start, end]: [[f64; 2]; 2]) -> Option<f64> {
    let way = [to[0] - from[0], to[1] - from[1]];
    let edge = [end[0] - start[0], end[1] - start[1]];
    let between = [start[0] - from[0], start[1] - from[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let turn = cross(way, edge);
    if turn == 0.0 {
        return None;
    }
    let share = cross(between, edge) / turn;
    let along = cross(between, way) / turn;
    ((0.0..=1.0).contains(&share) && (0.0..=1.0).contains(&along)).then_some(share)
}

fn collect(
    group: &Group,
    to: Affine,
    within: &[Region],
    close: Closeness,
    shapes: &mut Vec<Shape>,
) {
    for node in group.children() {
        match node {
            Node::Group(group) => {
                let own = to * matrix(group.transform());
                let mut inner = within.to_vec();
                inner.extend(group.clip_path().map(|clip| Region::of(clip, own, close)));
                collect(group, own, &inner, close, shapes);
            }
            Node::Path(path) => {
                let rule = path.fill().map_or(FillRule::NonZero, |fill| fill.rule());
                let outline = flatten(&curves(path.data(), to), close.tolerance, true);
                shapes.push(Shape::new(&outline, rule, within, close.near));
            }
            Node::Text(text) => collect(text.flattened(), to, within, close, shapes),
            Node::Image(_) => {}
        }
    }
}
