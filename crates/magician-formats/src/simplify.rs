//! Simplification of polylines (Ramer, Douglas and Peucker).

/// Length of a run, points. The algorithm is quadratic in the worst case, so longer lines are cut
/// into runs of this length, whose ends stay, and the cost stays linear.
const MAX_RUN_POINTS: usize = 1024;
/// Segments whose directions differ by no more than this are collinear, rad. It absorbs the
/// rounding of points computed on one line.
const COLLINEAR_TOLERANCE: f64 = 1e-12;

/// Returns true for each point to keep so that all others are within the tolerance of the remaining
/// line (Ramer, Douglas and Peucker). The first and the last point are kept.
#[must_use]
pub fn kept_points<const N: usize>(points: &[[f64; N]], tolerance: f64) -> Vec<bool> {
    kept_points_by(points, tolerance, distance_to_chord)
}

/// Simplifies as [`kept_points`] does with another measure of the distance between a point and a
/// chord.
pub(crate) fn kept_points_by<P: Copy>(
    points: &[P],
    tolerance: f64,
    off: impl Fn(P, P, P) -> f64,
) -> Vec<bool> {
    let mut stays = vec![false; points.len()];
    let Some(last) = points.len().checked_sub(1) else {
        return stays;
    };
    let ends = (0..last).step_by(MAX_RUN_POINTS).chain([last]);
    let mut spans: Vec<[usize; 2]> = Vec::new();
    for end in ends {
        stays[end] = true;
        let from = spans.last().map_or(0, |[_, to]| *to);
        spans.push([from, end]);
    }
    while let Some([from, to]) = spans.pop() {
        let off = |point| off(point, points[from], points[to]);
        if let Some((at, off)) = farthest(points, [from, to], off)
            && off > tolerance
        {
            stays[at] = true;
            spans.extend([[from, at], [at, to]]);
        }
    }
    stays
}

/// Returns the polyline with as few points as keep the given one within the tolerance. A closed
/// line keeps its first point and the point farthest from it.
#[must_use]
pub fn simplified(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let points = corners(points);
    let Some((first, last)) = points.first().zip(points.len().checked_sub(1)) else {
        return Vec::new();
    };
    let far = farthest(&points, [0, last], |point| length(minus(point, *first)));
    let middle = far.map_or(last, |(at, _)| at);
    let mut stays = kept_points(&points[..=middle], tolerance);
    stays.extend(
        kept_points(&points[middle..], tolerance)
            .into_iter()
            .skip(1),
    );
    let kept = points.iter().zip(stays).filter(|(_, stays)| *stays);
    kept.map(|(point, _)| *point).collect()
}

/// Removes points at which the line goes straight on.
fn corners(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = Vec::new();
    for point in points {
        if let [.., before, last] = corners.as_slice() {
            let (way, next) = (minus(*last, *before), minus(*point, *last));
            let turn = way[0] * next[1] - way[1] * next[0];
            let on = way[0] * next[0] + way[1] * next[1];
            if on > 0.0 && turn.abs() <= COLLINEAR_TOLERANCE * on {
                corners.pop();
            }
        }
        corners.push(*point);
    }
    corners
}

/// Returns the point between two indices that is farthest, and its distance. `None` if there are no
/// points in between.
fn farthest<P: Copy>(
    points: &[P],
    [from, to]: [usize; 2],
    far: impl Fn(P) -> f64,
) -> Option<(usize, f64)> {
    let between = points.iter().enumerate().take(to).skip(from + 1);
    let far = between.map(|(at, point)| (at, far(*point)));
    far.max_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// Distance of a point from the segment between two others.
pub(crate) fn distance_to_chord<const N: usize>(
    point: [f64; N],
    from: [f64; N],
    to: [f64; N],
) -> f64 {
    let (chord, way) = (minus(to, from), minus(point, from));
    let square = dot(chord, chord);
    let share = if square > 0.0 {
        (dot(way, chord) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    length(minus(way, chord.map(|part| part * share)))
}

fn minus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Scalar product.
#[must_use]
pub fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Length of a vector.
#[must_use]
pub fn length<const N: usize>(way: [f64; N]) -> f64 {
    dot(way, way).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dropped_points_are_within_the_tolerance() {
        // Teeth of all heights, with many points along each side.
        let mut points = Vec::new();
        for tooth in 0..300 {
            for nth in 0..20 {
                let up = f64::from(if nth < 10 { nth } else { 20 - nth });
                points.push([
                    f64::from(20 * tooth + nth) * 0.1,
                    up * f64::from(tooth % 7) * 0.01,
                ]);
            }
        }
        for tolerance in [0.0, 0.05, 0.3, 2.0] {
            let stays = kept_points(&points, tolerance);
            let ends: Vec<usize> = (0..points.len()).filter(|at| stays[*at]).collect();
            for pair in ends.windows(2) {
                for at in pair[0]..=pair[1] {
                    let off = distance_to_chord(points[at], points[pair[0]], points[pair[1]]);
                    assert!(off <= tolerance, "{off}");
                }
            }
            assert!(ends.len() < points.len());
        }
    }

    #[test]
    fn closed_line_keeps_two_points_and_straight_line_its_ends() {
        let square = [
            [0.0, 0.0],
            [0.1, 0.0],
            [0.3, 0.0],
            [0.3, 0.3],
            [0.0, 0.3],
            [0.0, 0.0],
        ];
        let corners = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3], [0.0, 0.0]];
        assert_eq!(simplified(&square, 0.01), corners);
        assert_eq!(
            simplified(&square, 9.0),
            [corners[0], corners[2], corners[4]]
        );
        let back = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(simplified(&back, 9.0), back);
        assert_eq!(simplified(&[[1.0, 1.0]], 0.1), [[1.0, 1.0]]);
        assert!(simplified(&[], 0.1).is_empty());
        let long: Vec<[f64; 2]> = (0..200_000).map(|at| [f64::from(at) * 0.05, 0.1]).collect();
        assert_eq!(simplified(&long, 0.0).len(), 2);
    }
}
