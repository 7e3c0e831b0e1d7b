//! Paths as polylines, and dashes.

use kurbo::{Affine, BezPath, PathEl, Point};
use usvg::tiny_skia_path::{Path, PathSegment};

use crate::curves::tidy;
pub(super) use crate::curves::{Line, flatten};

/// Largest number of dashes per path. It bounds memory for tiny dashes on long lines.
const MAX_DASHES: f64 = 100_000.0;
/// Distance within which a point counts as lying on a drawn line, mm. It absorbs the rounding of
/// 32-bit coordinates in usvg.
pub(super) const LINE_TOLERANCE: f64 = 1e-3;

/// Tolerances, mm at the size of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closeness {
    /// Largest distance of a chord from its curve.
    pub(super) tolerance: f64,
    /// Distance within which a point counts as lying on a line.
    pub(super) near: f64,
}

impl Closeness {
    /// Creates the tolerances; `unit` is the length in the file that is drawn 1 mm long.
    pub(super) fn new(tolerance: f64, unit: f64) -> Self {
        Self {
            tolerance,
            near: LINE_TOLERANCE * unit,
        }
    }
}

/// Returns the curves of a path after a transform.
pub(super) fn curves(path: &Path, to: Affine) -> BezPath {
    let point = |at: usvg::tiny_skia_path::Point| to * Point::new(at.x.into(), at.y.into());
    let elements = path.segments().map(|segment| match segment {
        PathSegment::MoveTo(to) => PathEl::MoveTo(point(to)),
        PathSegment::LineTo(to) => PathEl::LineTo(point(to)),
        PathSegment::QuadTo(by, to) => PathEl::QuadTo(point(by), point(to)),
        PathSegment::CubicTo(one, other, to) => {
            PathEl::CurveTo(point(one), point(other), point(to))
        }
        PathSegment::Close => PathEl::ClosePath,
    });
    elements.collect()
}

/// Cuts polylines into dashes. `None` if there are too many.
pub(super) fn dashed(lines: &[Line], pattern: &[f64], offset: f64) -> Option<Vec<Line>> {
    let period: f64 = pattern.iter().sum();
    let length: f64 = lines.iter().map(length).sum();
    let count = length / period * pattern.len() as f64;
    if !(period > 0.0 && count < MAX_DASHES) || pattern.iter().any(|part| *part < 0.0) {
        return None;
    }
    Some(
        lines
            .iter()
            .flat_map(|line| dashes(line, pattern, offset))
            .collect(),
    )
}

fn dashes(line: &Line, pattern: &[f64], offset: f64) -> Vec<Line> {
    let Some(first) = line.first() else {
        return Vec::new();
    };
    let period: f64 = pattern.iter().sum();
    // With an odd number of parts, dashes and gaps swap in each period.
    let cycle = period
        * if pattern.len().is_multiple_of(2) {
            1.0
        } else {
            2.0
        };
    let mut parts = pattern.iter().copied().cycle();
    let mut left = parts.next().unwrap_or(f64::INFINITY);
    let mut on = true;
    let mut skip = offset.rem_euclid(cycle);
    while skip >= left && skip > 0.0 {
        skip -= left;
        left = parts.next().unwrap_or(f64::INFINITY);
        on = !on;
    }
    left -= skip;
    let mut found = Vec::new();
    let mut dash: Line = if on { vec![*first] } else { Vec::new() };
    for (from, to) in line.iter().zip(line.iter().skip(1)) {
        let long = crate::artwork::distance(*from, *to);
        let mut done = 0.0;
        while long - done > left {
            done += left;
            let share = done / long;
            let at = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            if on {
                dash.push(at);
                found.push(std::mem::take(&mut dash));
            } else {
                dash = vec![at];
            }
            on = !on;
            left = parts.next().unwrap_or(f64::INFINITY);
        }
        left -= long - done;
        if on {
            dash.push(*to);
        }
    }
    found.push(dash);
    found.retain(|dash| !dash.is_empty());
    found.into_iter().map(tidy).collect()
}

fn length(line: &Line) -> f64 {
    let pairs = line.iter().zip(line.iter().skip(1));
    pairs
        .map(|(from, to)| crate::artwork::distance(*from, *to))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(length: f64) -> Vec<Line> {
        vec![vec![[0.0, 0.0], [length / 2.0, 0.0], [length, 0.0]]]
    }

    fn spans(pattern: &[f64], offset: f64) -> Vec<[f64; 2]> {
        let dashes = dashed(&straight(20.0), pattern, offset).unwrap();
        let ends = |dash: &Line| [dash[0][0], dash[dash.len() - 1][0]];
        dashes.iter().map(ends).collect()
    }

    #[test]
    fn dashes_follow_the_pattern() {
        assert_eq!(
            spans(&[5.0, 3.0], 0.0),
            [[0.0, 5.0], [8.0, 13.0], [16.0, 20.0]]
        );
        assert_eq!(
            spans(&[5.0, 3.0], 6.0),
            [[2.0, 7.0], [10.0, 15.0], [18.0, 20.0]]
        );
        assert_eq!(
            spans(&[5.0, 3.0], -2.0),
            [[2.0, 7.0], [10.0, 15.0], [18.0, 20.0]]
        );
        // An odd pattern repeats with dashes and gaps swapped: 4 on, 4 off.
        assert_eq!(spans(&[4.0], 0.0), [[0.0, 4.0], [8.0, 12.0], [16.0, 20.0]]);
        // A zero-length dash is a dot.
        assert_eq!(
            spans(&[0.0, 8.0], 0.0),
            [[0.0, 0.0], [8.0, 8.0], [16.0, 16.0]]
        );
    }

    #[test]
    fn endless_dashes_give_none() {
        assert_eq!(dashed(&straight(20.0), &[0.0, 0.0], 0.0), None);
        assert_eq!(dashed(&straight(20.0), &[1e-9, 1e-9], 0.0), None);
        assert_eq!(dashed(&straight(20.0), &[f64::NAN], 0.0), None);
    }
}
