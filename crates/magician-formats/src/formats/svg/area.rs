//! Test for an enclosed area.

use super::lines::Line;
use crate::artwork::distance;

/// True if a closed line encloses anything wider than `thin`. A line that only leads there and
/// back, over any vertices, encloses nothing.
///
/// Spikes and collinear vertices are removed until nothing changes; a polygon must remain.
pub(super) fn encloses(line: &Line, thin: f64) -> bool {
    let mut left: Line = Vec::new();
    for point in line.iter().chain(line.first()) {
        left.push(*point);
        while let [.., a, b, c] = left.as_slice() {
            if distance(*a, *c) < thin {
                // A spike: there and back.
                left.truncate(left.len() - 2);
            } else if distance_to_segment(*b, [*a, *c]) < thin {
                left.remove(left.len() - 2);
            } else {
                break;
            }
        }
    }
    left.len() > 3
}

/// Distance of a point from the line through two others, mm.
fn distance_to_segment([x, y]: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    ((x - a[0]) * dy - (y - a[1]) * dx).abs() / libm::hypot(dx, dy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::svg::lines::LINE_TOLERANCE;

    #[test]
    fn only_lines_that_enclose_an_area_have_an_inside() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let eight = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]];
        let spiked = [[0.0, 0.0], [5.0, 0.0], [5.0, -9.0], [5.0, 0.0], [5.0, 5.0]];
        let circle: Line = (0..720)
            .map(|nth| f64::from(nth).to_radians() / 2.0)
            .map(|angle| [500.0 * libm::cos(angle), 500.0 * libm::sin(angle)])
            .collect();
        for round in [&square[..], &eight, &spiked, &circle] {
            let mut line = round.to_vec();
            assert!(encloses(&line, LINE_TOLERANCE), "{line:?}");
            line.push(line[0]);
            assert!(encloses(&line, LINE_TOLERANCE), "{line:?}");
        }
        for none in [
            &[][..],
            &[[3.0, 4.0]],
            &[[3.0, 4.0], [9.0, 1.0]],
            // Collinear points in any order, rounded as in 32 bits.
            &[[5.0, 5.0], [9.0, 9.0], [0.0, 0.000_01], [2.0, 2.0]],
            // There and back around a corner, and from a fork.
            &[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [9.0, 0.0]],
            &[
                [9.0, 9.0],
                [9.0, 0.0],
                [0.0, 0.0],
                [9.0, 0.0],
                [20.0, 5.0],
                [9.0, 0.0],
            ],
        ] {
            let mut line = none.to_vec();
            assert!(!encloses(&line, LINE_TOLERANCE), "{line:?}");
            line.extend(none.first());
            assert!(!encloses(&line, LINE_TOLERANCE), "{line:?}");
        }
    }
}
