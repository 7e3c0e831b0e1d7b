//! Flattening of Bézier curves into polylines.

use kurbo::{BezPath, PathEl};

/// Vertices closer than this are merged, in the units of the curve.
const MERGE_DISTANCE: f64 = 1e-6;

/// A polyline. A closed one ends with its first vertex.
pub(crate) type Line = Vec<[f64; 2]>;

/// Flattens curves into polylines that stay within `tolerance`. `close` closes every subpath, as
/// filling does.
pub(crate) fn flatten(curves: &BezPath, tolerance: f64, close: bool) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let mut line = Line::new();
    let mut begin = [0.0; 2];
    let finish = |line: &mut Line, lines: &mut Vec<Line>| {
        let mut done = std::mem::take(line);
        if close {
            close_line(&mut done);
        }
        if done.len() > 1 {
            lines.push(tidy(done));
        }
    };
    kurbo::flatten(curves.iter(), tolerance, |element| match element {
        PathEl::MoveTo(to) => {
            finish(&mut line, &mut lines);
            begin = [to.x, to.y];
            line.push(begin);
        }
        PathEl::ClosePath => {
            close_line(&mut line);
            finish(&mut line, &mut lines);
            // A subpath after a close begins at the same point without a MoveTo.
            line.push(begin);
        }
        PathEl::LineTo(to) | PathEl::QuadTo(_, to) | PathEl::CurveTo(_, _, to) => {
            line.push([to.x, to.y]);
        }
    });
    finish(&mut line, &mut lines);
    lines
}

fn close_line(line: &mut Line) {
    if let (Some(first), Some(last)) = (line.first().copied(), line.last())
        && first != *last
    {
        line.push(first);
    }
}

/// Removes vertices that coincide with their predecessor. A line without length becomes a dot.
pub(crate) fn tidy(line: Line) -> Line {
    let closed = line.first() == line.last();
    let mut tidy: Line = Vec::with_capacity(line.len());
    for point in line {
        if tidy
            .last()
            .is_none_or(|last| crate::artwork::distance(*last, point) > MERGE_DISTANCE)
        {
            tidy.push(point);
        }
    }
    if let (true, Some(first), Some(last)) = (closed, tidy.first().copied(), tidy.last_mut()) {
        // Merging may have dropped the closing vertex, so restore it bit for bit. A dot keeps its
        // single vertex.
        *last = first;
    }
    tidy
}
