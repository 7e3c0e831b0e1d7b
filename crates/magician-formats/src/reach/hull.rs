//! Convex hull of points (Andrew's monotone chain).

/// Returns the vertices of the convex hull, counter-clockwise, without points on its edges.
#[must_use]
pub fn of(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull = chain(sorted.iter());
    hull.extend(chain(sorted.iter().rev()));
    hull
}

/// Returns one side of the hull without its last vertex, which is the first of the other side.
fn chain<'p>(points: impl Iterator<Item = &'p [f64; 2]>) -> Vec<[f64; 2]> {
    let mut side: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., before, last] = side.as_slice()
            && turn(*before, *last, *point) <= 0.0
        {
            side.pop();
        }
        side.push(*point);
    }
    side.pop();
    side
}

/// Twice the signed area of the triangle `a`, `b`, `c`; positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Mean of the vertices, which lies inside.
pub(super) fn middle(hull: &[[f64; 2]]) -> [f64; 2] {
    let count = hull.len().max(1) as f64;
    let sum = hull
        .iter()
        .fold([0.0, 0.0], |[x, y], corner| [x + corner[0], y + corner[1]]);
    sum.map(|value| value / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hull_consists_of_the_corners() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let mut points = square.to_vec();
        points.extend([[2.0, 2.0], [2.0, 0.0], [4.0, 4.0], [1.0, 3.0]]);
        assert_eq!(of(&points), square);
        assert_eq!(middle(&square), [2.0, 2.0]);
        assert_eq!(of(&[[1.0, 1.0], [1.0, 1.0]]), [[1.0, 1.0]]);
        assert_eq!(of(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).len(), 2);
        assert!(of(&[]).is_empty());
    }
}
