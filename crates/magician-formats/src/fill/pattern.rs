//! Hatch patterns that a drawing defines itself: families of parallel, possibly dashed lines.

/// Tolerance for a line on the edge of an area, as a share of the distance between lines. Within
/// the tolerance, a line on the lower edge is drawn and a line on the upper edge is not.
const EDGE_TOLERANCE: f64 = 1e-9;
/// Largest number of lines and dashes per area. It bounds memory for patterns with a tiny distance.
const MAX_LINES: f64 = 100_000.0;

/// A family of parallel lines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LineFamily {
    /// Direction, degrees counter-clockwise from x.
    pub(crate) angle: f64,
    /// Start of one of the lines.
    pub(crate) base: [f64; 2],
    /// Offset from the start of each line to that of the next.
    pub(crate) offset: [f64; 2],
    /// Lengths of dashes; negative lengths are gaps. Empty for solid lines.
    pub(crate) dashes: Vec<f64>,
}

impl LineFamily {
    /// Returns the parts of the lines within the rings (even-odd). `None` if there are too many.
    pub(crate) fn within(&self, rings: &[Vec<[f64; 2]>]) -> Option<Vec<[[f64; 2]; 2]>> {
        let (sin, cos) = libm::sincos(self.angle.to_radians());
        let turned = |[x, y]: [f64; 2]| [x * cos + y * sin, y * cos - x * sin];
        let back = |[x, y]: [f64; 2]| [x * cos - y * sin, x * sin + y * cos];
        let (base, step) = (turned(self.base), turned(self.offset));
        // Make the step positive, so that levels count upwards.
        let step = if step[1] < 0.0 {
            step.map(|side| -side)
        } else {
            step
        };
        let mut crossings: Vec<(f64, f64)> = Vec::new();
        for ring in rings {
            let next = ring.iter().cycle().skip(1);
            for (from, to) in ring.iter().zip(next) {
                let [from, to] = [turned(*from), turned(*to)];
                let (low, high) = if from[1] <= to[1] {
                    (from, to)
                } else {
                    (to, from)
                };
                let level = |y: f64| ((y - base[1]) / step[1] - EDGE_TOLERANCE).ceil();
                let (first, end) = (level(low[1]), level(high[1]));
                // NaN and infinity fail the comparison too: a line distance of 0 gives infinitely
                // many lines.
                let is_bounded = (end - first) + crossings.len() as f64 <= MAX_LINES;
                if !is_bounded {
                    return None;
                }
                for later in 0..(end - first) as u32 {
                    let nth = first + f64::from(later);
                    let share = (base[1] + nth * step[1] - low[1]) / (high[1] - low[1]);
                    crossings.push((nth, low[0] + (high[0] - low[0]) * share));
                }
            }
        }
        crossings.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1)));
        let mut lines = Vec::new();
        for level in crossings.chunk_by(|one, next| one.0 == next.0) {
            for pair in level.as_chunks::<2>().0 {
                let [(nth, from), (_, to)] = *pair;
                let y = base[1] + nth * step[1];
                let begin = base[0] + nth * step[0];
                for [from, to] in self.dashed([from, to], begin)? {
                    lines.push([back([from, y]), back([to, y])]);
                }
                if lines.len() as f64 > MAX_LINES {
                    return None;
                }
            }
        }
        Some(lines)
    }

    /// Returns the dashes of a line between two positions. The pattern starts at `begin`. `None` if
    /// there are too many.
    fn dashed(&self, [from, to]: [f64; 2], begin: f64) -> Option<Vec<[f64; 2]>> {
        let period: f64 = self.dashes.iter().map(|dash| dash.abs()).sum();
        if period <= 0.0 || self.dashes.iter().all(|dash| *dash >= 0.0) {
            return Some(vec![[from, to]]);
        }
        let repeats = ((from - begin) / period).floor();
        let count = ((to - from) / period).ceil() + 1.0;
        let is_bounded = count * self.dashes.len() as f64 <= MAX_LINES;
        if !is_bounded {
            return None;
        }
        let mut dashes = Vec::new();
        for nth in 0..count as u32 {
            let mut at = begin + (repeats + f64::from(nth)) * period;
            for dash in &self.dashes {
                let end = at + dash.abs();
                // A dash of length 0 is a dot.
                let meets = end > from || end == at && at >= from;
                if *dash >= 0.0 && meets && at < to {
                    dashes.push([at.max(from), end.min(to)]);
                }
                at = end;
            }
        }
        Some(dashes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];

    fn family(angle: f64, offset: [f64; 2], dashes: &[f64]) -> LineFamily {
        LineFamily {
            angle,
            base: [0.0, 1.0],
            offset,
            dashes: dashes.to_vec(),
        }
    }

    #[test]
    fn pattern_lines_follow_the_pattern_and_spare_holes() {
        let hole = vec![[2.0, 3.5], [6.0, 3.5], [6.0, 8.0], [2.0, 8.0]];
        let lines = family(0.0, [0.0, 3.0], &[]).within(&[SQUARE.to_vec(), hole]);
        let expected = [
            [[0.0, 1.0], [10.0, 1.0]],
            [[0.0, 4.0], [2.0, 4.0]],
            [[6.0, 4.0], [10.0, 4.0]],
            [[0.0, 7.0], [2.0, 7.0]],
            [[6.0, 7.0], [10.0, 7.0]],
        ];
        assert_eq!(lines.unwrap(), expected);
        let upright = LineFamily {
            base: [1.0, 0.0],
            ..family(90.0, [-5.0, 0.0], &[])
        };
        let lines = upright.within(&[SQUARE.to_vec()]).unwrap();
        let xs: Vec<_> = lines.iter().map(|[from, _]| from[0].round()).collect();
        assert_eq!(xs, [6.0, 1.0]);
    }

    #[test]
    fn dashes_begin_where_their_line_begins() {
        let lines = family(0.0, [1.0, 5.0], &[2.0, -2.0]).within(&[SQUARE.to_vec()]);
        let starts: Vec<_> = lines.unwrap().iter().map(|[from, _]| *from).collect();
        let expected = [
            [0.0, 1.0],
            [4.0, 1.0],
            [8.0, 1.0],
            [1.0, 6.0],
            [5.0, 6.0],
            [9.0, 6.0],
        ];
        assert_eq!(starts, expected);
    }

    #[test]
    fn endless_patterns_are_refused() {
        for offset in [[0.0, 0.0], [0.0, 1e-9], [1.0, 0.0], [f64::NAN, 1.0]] {
            assert_eq!(family(0.0, offset, &[]).within(&[SQUARE.to_vec()]), None);
        }
        let fine = family(0.0, [0.0, 5.0], &[1e-9, -1e-9]);
        assert_eq!(fine.within(&[SQUARE.to_vec()]), None);
    }
}
