//! From each line to the nearest that has not been drawn.

use super::super::Stroke;
use super::Leg;
use super::grid::{Entry, Grid};

/// As many corners of a closed line may be where it is begun.
const MOST_CORNERS: usize = 64;

/// Begins with the line nearest to the lower left corner.
pub(super) fn tour(strokes: &[Stroke]) -> Vec<Leg> {
    let mut drawn = vec![false; strokes.len()];
    let mut legs = Vec::with_capacity(strokes.len());
    let mut at = least(strokes);
    let mut left = strokes.len();
    while left > 0 {
        // With fewer points the cells must be larger, or most of them are empty.
        let mut grid = Grid::new(entries(strokes, &drawn));
        for _ in 0..left.div_ceil(2).max(16).min(left) {
            let Some(next) = grid.nearest(at, |entry| !is(&drawn, entry.owner)) else {
                return legs;
            };
            let Some(leg) = leg(strokes, &next) else {
                return legs;
            };
            if let Some(drawn) = drawn.get_mut(next.owner) {
                *drawn = true;
            }
            at = leg.end;
            legs.push(leg);
            left -= 1;
        }
    }
    legs
}

fn is(drawn: &[bool], owner: usize) -> bool {
    drawn.get(owner).copied().unwrap_or(true)
}

fn least(strokes: &[Stroke]) -> [f64; 2] {
    let points = strokes.iter().flat_map(|stroke| &stroke.points);
    points.fold([f64::INFINITY; 2], |least, point| {
        [least[0].min(point[0]), least[1].min(point[1])]
    })
}

/// Where lines that have not been drawn can begin.
fn entries<'a>(
    strokes: &'a [Stroke],
    drawn: &'a [bool],
) -> impl Iterator<Item = Entry> + Clone + 'a {
    let left = strokes
        .iter()
        .enumerate()
        .filter(|(owner, _)| !is(drawn, *owner));
    left.flat_map(|(owner, stroke)| {
        let last = stroke.points.len().saturating_sub(1);
        let step = match stroke.is_closed() {
            true => last.div_ceil(MOST_CORNERS).max(1),
            false => last.max(1),
        };
        // The last corner of a closed line is its first.
        let until = if stroke.is_closed() { last } else { last + 1 };
        let corners = stroke.points.iter().enumerate().take(until).step_by(step);
        corners.map(move |(which, at)| Entry {
            at: *at,
            owner,
            which,
        })
    })
}

fn leg(strokes: &[Stroke], entry: &Entry) -> Option<Leg> {
    let stroke = strokes.get(entry.owner)?;
    let (first, last) = (*stroke.points.first()?, *stroke.points.last()?);
    if stroke.is_closed() {
        return Some(Leg {
            stroke: entry.owner,
            start: entry.at,
            end: entry.at,
            reversed: false,
            corner: entry.which,
        });
    }
    let leg = Leg {
        stroke: entry.owner,
        start: first,
        end: last,
        reversed: false,
        corner: 0,
    };
    Some(if entry.which == 0 {
        leg
    } else {
        leg.reversed()
    })
}
