//! Curves as corners.

use kurbo::{BezPath, PathEl};

/// Corners nearer than this are one.
const SAME: f64 = 1e-6;

/// A line of corners; a closed one ends where it begins.
pub(crate) type Line = Vec<[f64; 2]>;

/// Corners along curves. `close` has every line end where it begins, as the edge of a filled shape does.
pub(crate) fn flatten(curves: &BezPath, tolerance: f64, close: bool) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let mut line = Line::new();
    let mut begin = [0.0; 2];
    let finish = |line: &mut Line, lines: &mut Vec<Line>| {
        let mut done = std::mem::take(line);
        if close {
            shut(&mut done);
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
            shut(&mut line);
            finish(&mut line, &mut lines);
            // What follows begins here without saying so.
            line.push(begin);
        }
        PathEl::LineTo(to) | PathEl::QuadTo(_, to) | PathEl::CurveTo(_, _, to) => {
            line.push([to.x, to.y]);
        }
    });
    finish(&mut line, &mut lines);
    lines
}

fn shut(line: &mut Line) {
    if let (Some(first), Some(last)) = (line.first().copied(), line.last())
        && first != *last
    {
        line.push(first);
    }
}

/// Without corners that are where the one before is; a line that goes nowhere becomes a dot.
pub(crate) fn tidy(line: Line) -> Line {
    let closed = line.first() == line.last();
    let mut tidy: Line = Vec::with_capacity(line.len());
    for point in line {
        if tidy
            .last()
            .is_none_or(|last| crate::artwork::distance(*last, point) > SAME)
        {
            tidy.push(point);
        }
    }
    if let (true, Some(first), Some(last)) = (closed, tidy.first().copied(), tidy.last_mut()) {
        // A dot stays one, and the last corner is the first to the last bit.
        *last = first;
    }
    tidy
}
