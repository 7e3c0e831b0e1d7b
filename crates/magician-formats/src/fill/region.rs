//! Regions: areas normalised to shapes that neither cross nor overlap, each an outline and its
//! holes.
//!
//! The boolean operations and offsets of the fill modes work on this form.

use i_overlay::core::fill_rule::FillRule as OverlayFillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;
use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};

use super::{Area, FillRule};
use crate::artwork::distance;
use crate::simplify::distance_to_chord;

/// Smallest angle of a mitre, radians. Sharper corners are bevelled when an edge is offset.
const MIN_MITRE_ANGLE: f64 = 0.5;

/// Largest number of edges of a ring that is compared with itself, which takes quadratic time.
const MAX_COMPARED_EDGES: usize = 2_000;

/// Shapes: the outline of each first, counter-clockwise, then its holes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Region(Vec<Vec<Vec<[f64; 2]>>>);

impl FromIterator<Region> for Region {
    fn from_iter<T: IntoIterator<Item = Region>>(parts: T) -> Self {
        Self(parts.into_iter().flat_map(|part| part.0).collect())
    }
}

impl Region {
    pub(crate) fn of(area: &Area) -> Self {
        let finite = |ring: &&Vec<[f64; 2]>| ring.iter().flatten().all(|side| side.is_finite());
        let rings: Vec<_> = area.rings.iter().filter(finite).cloned().collect();
        let rule = match area.rule {
            FillRule::NonZero => OverlayFillRule::NonZero,
            FillRule::EvenOdd => OverlayFillRule::EvenOdd,
        };
        Self(rings.simplify_shape_as::<i64>(rule))
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Iterates over the shapes as regions.
    pub(super) fn parts(&self) -> impl Iterator<Item = Self> + '_ {
        self.0.iter().map(|shape| Self(vec![shape.clone()]))
    }

    /// Iterates over outlines and holes.
    pub(super) fn rings(&self) -> impl Iterator<Item = &Vec<[f64; 2]>> {
        self.0.iter().flatten()
    }

    /// Iterates over outlines only.
    pub(super) fn outlines(&self) -> impl Iterator<Item = &Vec<[f64; 2]>> {
        self.0.iter().filter_map(|shape| shape.first())
    }

    /// Returns the bounding box (smallest and largest corner), or `None` if the region is empty.
    #[cfg(feature = "drawings")]
    pub(crate) fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let [x, y] = [0, 1].map(|side: usize| self.extent(|point| point[side]));
        (!self.is_empty()).then_some([[x.0, y.0], [x.1, y.1]])
    }

    /// Larger of width and height.
    pub(super) fn size(&self) -> f64 {
        let side = |which: usize| {
            let (least, most) = self.extent(|point| point[which]);
            most - least
        };
        side(0).max(side(1))
    }

    /// Smallest and largest value of a measure over all vertices, usually a coordinate along a
    /// direction.
    pub(super) fn extent(&self, measure: impl Fn([f64; 2]) -> f64) -> (f64, f64) {
        let measures = self.rings().flatten().map(|point| measure(*point));
        measures.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| {
            (least.min(at), most.max(at))
        })
    }

    /// Offsets the edge outwards, or inwards if `by` is negative.
    pub(super) fn offset(&self, by: f64) -> Self {
        if by == 0.0 || self.is_empty() {
            return self.clone();
        }
        let style = OutlineStyle::new(by).line_join(LineJoin::Miter(MIN_MITRE_ANGLE));
        Self(self.0.outline_as::<i64>(&style))
    }

    pub(crate) fn area(self) -> Area {
        Area {
            rings: self.0.into_iter().flatten().collect(),
            rule: FillRule::NonZero,
        }
    }

    /// Returns the intersection.
    pub(crate) fn common(&self, other: &Self) -> Self {
        self.overlaid(other, OverlayRule::Intersect)
    }

    /// Returns the union.
    #[cfg(feature = "drawings")]
    pub(crate) fn joined(&self, other: &Self) -> Self {
        self.overlaid(other, OverlayRule::Union)
    }

    /// Returns the difference.
    pub(crate) fn except(&self, other: &Self) -> Self {
        self.overlaid(other, OverlayRule::Difference)
    }

    fn overlaid(&self, other: &Self, rule: OverlayRule) -> Self {
        Self(
            self.0
                .overlay_as::<i64>(&other.0, rule, OverlayFillRule::NonZero),
        )
    }

    /// Returns the difference, without parts too small for a line of this width.
    pub(super) fn without(&self, other: &Self, width: f64) -> Self {
        let rest = self.except(other);
        rest.parts()
            .filter(|part| part.is_worth_a_line(width))
            .collect()
    }

    /// True if the region is larger than a line of this width and not a sliver.
    pub(super) fn is_worth_a_line(&self, width: f64) -> bool {
        self.size() > width && self.size_of() > width * width / 4.0
    }

    /// True if one of these points, sorted by x, is inside.
    pub(super) fn has_any_of(&self, points: &[[f64; 2]]) -> bool {
        let (least, most) = self.extent(|point| point[0]);
        let first = points.partition_point(|point| point[0] < least);
        let mut near = points[first..].iter().take_while(|point| point[0] <= most);
        near.any(|point| self.is_around(*point))
    }

    /// True if a point is inside.
    pub(super) fn is_around(&self, point: [f64; 2]) -> bool {
        self.rings().filter(|ring| is_around(ring, point)).count() % 2 == 1
    }

    /// Returns one line for a single small or thin shape.
    ///
    /// The line goes through the middle if the shape is not larger than `width`, else along its
    /// edge. It goes only one way if a line of that width covers the way back.
    pub(super) fn one_line(&self, width: f64) -> Vec<[f64; 2]> {
        if self.size() <= width {
            return self.middle_line();
        }
        let Some(ring) = self.outlines().next() else {
            return Vec::new();
        };
        // The two vertices farthest from each other, roughly: farthest from any vertex, then from
        // that one.
        let farthest = |from: usize| {
            let far = |nth: &usize| distance(ring[from], ring[*nth]);
            (0..ring.len()).max_by(|one, other| far(one).total_cmp(&far(other)))
        };
        let Some(first) = farthest(0) else {
            return Vec::new();
        };
        let mut there = ring.clone();
        there.rotate_left(first);
        there.push(there[0]);
        let last = farthest(first).map_or(0, |last| (last + ring.len() - first) % ring.len());
        let back = &there[last..];
        let there_only = &there[..=last];
        let covered = |point: &[f64; 2]| {
            let edges = there_only.windows(2);
            { edges }.any(|edge| distance_to_chord(*point, edge[0], edge[1]) <= width / 2.0)
        };
        if ring.len() <= MAX_COMPARED_EDGES && back.iter().all(covered) {
            there_only.to_vec()
        } else {
            there
        }
    }

    /// Returns a point inside a single shape; `None` if it has no area.
    pub(super) fn inner_point(&self) -> Option<[f64; 2]> {
        self.middle_line().get(1).copied()
    }

    /// Returns a line through the middle along x or y, whichever is longer, of half the shape's
    /// length there.
    fn middle_line(&self) -> Vec<[f64; 2]> {
        let chords = [0, 1].into_iter().filter_map(|side: usize| {
            let (least, most) = self.extent(|point| point[1 - side]);
            let level = f64::midpoint(least, most);
            let (from, to) = self.longest_chord(side, level)?;
            let share = |share: f64| {
                let mut point = [level; 2];
                point[side] = from + (to - from) * share;
                point
            };
            Some((to - from, [0.25, 0.5, 0.75].map(share)))
        });
        let longest = chords.max_by(|one, other| one.0.total_cmp(&other.0));
        longest.map_or_else(Vec::new, |(_, line)| line.to_vec())
    }

    /// Returns the longest chord along x (0) or y (1) at a level.
    fn longest_chord(&self, side: usize, level: f64) -> Option<(f64, f64)> {
        let edges = self.rings().flat_map(|ring| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next)
        });
        let across = 1 - side;
        let crossed = edges.filter(|(a, b)| (a[across] > level) != (b[across] > level));
        let mut ends: Vec<f64> = crossed
            .map(|(a, b)| {
                let share = (level - a[across]) / (b[across] - a[across]);
                a[side] + share * (b[side] - a[side])
            })
            .collect();
        ends.sort_unstable_by(f64::total_cmp);
        let chords = ends.chunks_exact(2).map(|pair| (pair[0], pair[1]));
        chords.max_by(|one, other| (one.1 - one.0).total_cmp(&(other.1 - other.0)))
    }

    /// Area, mm2.
    pub(super) fn size_of(&self) -> f64 {
        self.rings().map(|ring| ring_area(ring)).sum()
    }
}

/// True if a ring surrounds a point.
fn is_around(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crossed = ring.iter().zip(next).filter(|(a, b)| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

/// Signed area of a ring, positive if counter-clockwise.
fn ring_area(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    let twice: f64 = { ring.iter().zip(next) }
        .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
        .sum();
    twice / 2.0
}
