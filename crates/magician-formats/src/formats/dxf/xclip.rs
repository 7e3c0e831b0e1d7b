//! Clip boundaries of inserted blocks (XCLIP): only the part inside a polygon is visible.

use kurbo::{Affine, Point};

use super::drawing::Drawing;
use super::pairs::Record;
use crate::Diagnostic;
use crate::fill::{Area, FillRule, Region};

/// Largest number of tests of a segment against an edge per line.
const MAX_WORK: usize = 50_000_000;

/// A clip polygon, mm.
pub(super) struct Clip(Vec<Point>);

impl Clip {
    /// Returns the clip boundary of an insert; `map` takes its block to the sheet. `None` if it has
    /// none or it is switched off.
    pub(super) fn of(
        drawing: &Drawing<'_>,
        insert: &Record<'_>,
        map: &Affine,
    ) -> Result<Option<Self>, Diagnostic> {
        let Some(filter) = filter(drawing, insert) else {
            return Ok(None);
        };
        if filter.integer(71)? == 0 {
            return Ok(None);
        }
        let points = filter.points(10, -1)?.into_iter();
        let mut corners: Vec<Point> = points.map(|([x, y, _], _)| Point::new(x, y)).collect();
        // Two points are opposite corners of a rectangle.
        if let [one, other] = *corners {
            corners = vec![
                one,
                Point::new(other.x, one.y),
                other,
                Point::new(one.x, other.y),
            ];
        }
        // The last 24 numbers are two matrices: the inverse of the block's insertion, and the
        // transform of the boundary.
        let numbers = filter.numbers(40)?;
        let first = numbers.len().checked_sub(24);
        let to_block = match first.and_then(|first| numbers.get(first..first + 12)) {
            Some(&[a, c, _, e, b, d, _, f, ..]) => Affine::new([a, b, c, d, e, f]),
            // Without matrices the boundary is in the coordinates of the block.
            _ => Affine::IDENTITY,
        };
        let to = *map * to_block;
        let corners: Vec<Point> = corners.into_iter().map(|corner| to * corner).collect();
        let usable = corners.len() > 2 && corners.iter().all(|corner| corner.is_finite());
        Ok(usable.then_some(Self(corners)))
    }

    /// Returns the parts of a line inside; `None` if that is too much work.
    pub(super) fn line(&self, line: &[Point]) -> Option<Vec<Vec<Point>>> {
        if line.len().saturating_mul(self.0.len()) > MAX_WORK {
            return None;
        }
        if let [dot] = line {
            let inside = self.contains(*dot);
            return Some(inside.then(|| vec![*dot]).into_iter().collect());
        }
        let mut pieces: Vec<Vec<Point>> = Vec::new();
        let mut goes_on = false;
        for pair in line.windows(2) {
            let &[from, to] = pair else { continue };
            let mut shares: Vec<f64> = self
                .edges()
                .filter_map(|edge| crossing([from, to], edge))
                .collect();
            shares.extend([0.0, 1.0]);
            shares.sort_by(f64::total_cmp);
            for share in shares.windows(2) {
                let &[begin, end] = share else { continue };
                if end <= begin {
                    continue;
                }
                if !self.contains(from.lerp(to, f64::midpoint(begin, end))) {
                    goes_on = false;
                    continue;
                }
                match pieces.last_mut().filter(|_| goes_on) {
                    Some(piece) => piece.push(from.lerp(to, end)),
                    None => pieces.push(vec![from.lerp(to, begin), from.lerp(to, end)]),
                }
                goes_on = true;
            }
        }
        Some(pieces)
    }

    /// Returns the part of an area inside.
    pub(super) fn area(&self, area: &Area) -> Area {
        let ring = self.0.iter().map(|corner| [corner.x, corner.y]).collect();
        let inside = Area {
            rings: vec![ring],
            rule: FillRule::EvenOdd,
        };
        Region::of(area).common(&Region::of(&inside)).area()
    }

    fn edges(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        let next = self.0.iter().cycle().skip(1);
        self.0.iter().zip(next).map(|(from, to)| [*from, *to])
    }

    fn contains(&self, at: Point) -> bool {
        let crossed = self.edges().filter(|[from, to]| {
            (from.y > at.y) != (to.y > at.y)
                && at.x < from.x + (at.y - from.y) / (to.y - from.y) * (to.x - from.x)
        });
        crossed.count() % 2 == 1
    }
}

/// Returns where an edge crosses a segment, as a share of the segment.
fn crossing([from, to]: [Point; 2], [begin, end]: [Point; 2]) -> Option<f64> {
    let (way, edge, apart) = (to - from, end - begin, begin - from);
    let across = way.cross(edge);
    if across == 0.0 {
        return None;
    }
    let [share, on_edge] = [apart.cross(edge) / across, apart.cross(way) / across];
    ((0.0..1.0).contains(&share) && (0.0..=1.0).contains(&on_edge)).then_some(share)
}

/// Returns the spatial filter of an insert: entry ACAD_FILTER of its dictionary, then entry
/// SPATIAL.
fn filter<'p>(drawing: &Drawing<'p>, insert: &Record<'p>) -> Option<&'p Record<'p>> {
    let pairs = insert.pairs.iter();
    let mut after = pairs.skip_while(|pair| (pair.code, pair.value) != (102, "{ACAD_XDICTIONARY"));
    let dictionary = drawing.object(after.find(|pair| pair.code == 360)?.value)?;
    let filters = drawing.object(entry(dictionary, "ACAD_FILTER")?)?;
    let filter = drawing.object(entry(filters, "SPATIAL")?)?;
    (filter.kind == "SPATIAL_FILTER").then_some(filter)
}

fn entry<'p>(dictionary: &Record<'p>, name: &str) -> Option<&'p str> {
    let mut pairs = dictionary.pairs.iter();
    pairs.find(|pair| (pair.code, pair.value) == (3, name))?;
    let handle = pairs.next()?;
    matches!(handle.code, 350 | 360).then_some(handle.value)
}
