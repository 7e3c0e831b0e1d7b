//! Lines of fewer points.

use crate::artwork::distance;

/// Leaves out points so that none of them is farther than this from the line that remains (after Douglas and Peucker). Of a
/// closed line, the first and the farthest point from it stay, at least.
pub(super) fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let Some((first, last)) = points.first().zip(points.len().checked_sub(1)) else {
        return Vec::new();
    };
    let mut stays = vec![false; points.len()];
    let mut open = Vec::new();
    let far = farthest(points, [0, last], |point| distance(*first, point));
    for end in [0, far.map_or(last, |(at, _)| at), last] {
        stays[end] = true;
        open.push(end);
    }
    let mut spans: Vec<[usize; 2]> = open.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    while let Some([from, to]) = spans.pop() {
        let off = |point| off_chord(point, points[from], points[to]);
        if let Some((at, off)) = farthest(points, [from, to], off)
            && off > tolerance
        {
            stays[at] = true;
            spans.extend([[from, at], [at, to]]);
        }
    }
    let kept = points.iter().zip(stays).filter(|(_, stays)| *stays);
    kept.map(|(point, _)| *point).collect()
}

/// The point between two others that is farthest, and how far.
fn farthest(
    points: &[[f64; 2]],
    [from, to]: [usize; 2],
    far: impl Fn([f64; 2]) -> f64,
) -> Option<(usize, f64)> {
    let between = points.iter().enumerate().take(to).skip(from + 1);
    let far = between.map(|(at, point)| (at, far(*point)));
    far.max_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// How far a point is from a line between two.
fn off_chord(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let way = [point[0] - from[0], point[1] - from[1]];
    let square = chord[0] * chord[0] + chord[1] * chord[1];
    let along = way[0] * chord[0] + way[1] * chord[1];
    let share = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let nearest = [from[0] + chord[0] * share, from[1] + chord[1] * share];
    distance(point, nearest)
}
