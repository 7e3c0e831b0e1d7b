//! Nearest-neighbour tour: from each stroke to the nearest one not drawn yet.

use std::ops::Range;

use super::super::Stroke;
use super::TourStop;
use super::kd_tree::{Entry, KdTree};

/// Largest number of vertices of a closed stroke that are tried as its start.
///
/// An arbitrary limit: more vertices improve the tour little, because
/// [`rotate_closed`](super::improve::rotate_closed) tries all of them later.
const MAX_START_VERTICES: usize = 64;

/// Returns the tour, which begins with the stroke nearest to the lower left corner.
pub(super) fn tour(strokes: &[Stroke]) -> Vec<TourStop> {
    let mut entries = Vec::new();
    // Range of entries of each stroke.
    let ranges: Vec<Range<usize>> = strokes
        .iter()
        .enumerate()
        .map(|(owner, stroke)| {
            let from = entries.len();
            entries.extend(start_points(owner, stroke));
            from..entries.len()
        })
        .collect();
    let mut tree = KdTree::new(entries);
    let mut stops = Vec::with_capacity(strokes.len());
    let mut at = lower_left(strokes);
    while let Some(next) = tree.nearest(at) {
        let range = ranges.get(next.owner).cloned().unwrap_or_default();
        range.for_each(|nth| tree.remove(nth));
        if let Some(stop) = stop(strokes, &next) {
            at = stop.end;
            stops.push(stop);
        }
    }
    stops
}

fn lower_left(strokes: &[Stroke]) -> [f64; 2] {
    let points = strokes.iter().flat_map(|stroke| &stroke.points);
    points.fold([f64::INFINITY; 2], |least, point| {
        [least[0].min(point[0]), least[1].min(point[1])]
    })
}

/// Iterates over the points at which a stroke can begin.
fn start_points(owner: usize, stroke: &Stroke) -> impl Iterator<Item = Entry> + '_ {
    let last = stroke.points.len().saturating_sub(1);
    let (step, until) = if stroke.is_closed() {
        // The last vertex of a closed stroke repeats its first.
        (last.div_ceil(MAX_START_VERTICES).max(1), last)
    } else {
        (last.max(1), last + 1)
    };
    let corners = stroke.points.iter().enumerate().take(until).step_by(step);
    corners.map(move |(which, at)| Entry {
        at: *at,
        owner,
        which,
    })
}

fn stop(strokes: &[Stroke], entry: &Entry) -> Option<TourStop> {
    let stroke = strokes.get(entry.owner)?;
    let (first, last) = (*stroke.points.first()?, *stroke.points.last()?);
    if stroke.is_closed() {
        return Some(TourStop {
            stroke: entry.owner,
            start: entry.at,
            end: entry.at,
            reversed: false,
            corner: entry.which,
        });
    }
    let stop = TourStop {
        stroke: entry.owner,
        start: first,
        end: last,
        reversed: false,
        corner: 0,
    };
    Some(if entry.which == 0 {
        stop
    } else {
        stop.reversed()
    })
}
