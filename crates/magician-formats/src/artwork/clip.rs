//! Clipping of polylines to a rectangle.

use super::Stroke;

impl Stroke {
    /// Returns the pieces of the stroke within a rectangle, given by its smallest and largest
    /// corner. The edge belongs to the rectangle.
    #[must_use]
    pub fn within(&self, window: [[f64; 2]; 2]) -> Vec<Self> {
        let [least, most] = window;
        let inside = |[x, y]: [f64; 2]| {
            (least[0]..=most[0]).contains(&x) && (least[1]..=most[1]).contains(&y)
        };
        if self.points.iter().all(|point| inside(*point)) {
            return vec![self.clone()];
        }
        let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut open: Vec<[f64; 2]> = Vec::new();
        for (from, to) in self.points.iter().zip(self.points.iter().skip(1)) {
            let Some([begin, end]) = share_within(*from, *to, window) else {
                pieces.push(std::mem::take(&mut open));
                continue;
            };
            let at = |share: f64| {
                if share == 0.0 {
                    *from
                } else if share == 1.0 {
                    *to
                } else {
                    [0, 1].map(|axis| {
                        let exact = from[axis] + share * (to[axis] - from[axis]);
                        exact.clamp(least[axis], most[axis])
                    })
                }
            };
            if begin > 0.0 {
                pieces.push(std::mem::take(&mut open));
            }
            if open.is_empty() {
                open.push(at(begin));
            }
            open.push(at(end));
        }
        pieces.push(open);
        // A piece without length comes from a corner that touches the edge from outside.
        pieces.retain(|piece| piece.iter().any(|point| Some(point) != piece.first()));
        // If a closed stroke starts inside, its last piece continues in its first.
        if self.is_closed() && pieces.len() > 1 {
            let goes_on = |piece: Option<&Vec<[f64; 2]>>,
                           end: fn(&[[f64; 2]]) -> Option<&[f64; 2]>| {
                piece.and_then(|piece| end(piece)).copied() == self.points.first().copied()
            };
            if goes_on(pieces.first(), <[_]>::first)
                && goes_on(pieces.last(), <[_]>::last)
                && let Some(mut last) = pieces.pop()
                && let Some(first) = pieces.first_mut()
            {
                last.extend(first.iter().skip(1));
                *first = last;
            }
        }
        let (origin, style) = (self.origin, self.style);
        let pieces = pieces.into_iter().map(|points| Self {
            points,
            origin,
            style,
        });
        pieces.collect()
    }
}

/// Returns the shares of a segment at which it enters and leaves a rectangle (Liang and Barsky).
/// `None` if it misses it.
fn share_within(from: [f64; 2], to: [f64; 2], [least, most]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for axis in [0, 1] {
        let way = to[axis] - from[axis];
        let bounds = [least[axis] - from[axis], most[axis] - from[axis]];
        if way == 0.0 {
            if bounds[0] > 0.0 || bounds[1] < 0.0 {
                return None;
            }
            continue;
        }
        let [enter, leave] = bounds.map(|bound| bound / way);
        begin = begin.max(enter.min(leave));
        end = end.min(enter.max(leave));
    }
    (begin <= end).then_some([begin, end])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Origin;

    const WINDOW: [[f64; 2]; 2] = [[0.0, 0.0], [10.0, 5.0]];

    fn pieces(points: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
        let stroke = Stroke::new(points.to_vec(), Origin::NONE);
        let pieces = stroke.within(WINDOW).into_iter();
        pieces.map(|piece| piece.points).collect()
    }

    #[test]
    fn clipped_lines_end_at_the_edge_and_continue_on_reentry() {
        assert_eq!(
            pieces(&[[-5.0, 1.0], [5.0, 1.0], [5.0, 9.0], [7.0, 9.0], [7.0, 1.0]]),
            [
                vec![[0.0, 1.0], [5.0, 1.0], [5.0, 5.0]],
                vec![[7.0, 5.0], [7.0, 1.0]],
            ]
        );
        // Crosses the rectangle without a corner inside.
        assert_eq!(
            pieces(&[[-5.0, 0.0], [15.0, 5.0]]),
            [[[0.0, 1.25], [10.0, 3.75]]]
        );
        // A line on the edge is inside, one beside it is not.
        assert_eq!(
            pieces(&[[0.0, 0.0], [0.0, 5.0]]),
            [[[0.0, 0.0], [0.0, 5.0]]]
        );
        assert!(pieces(&[[-1.0, 0.0], [-1.0, 5.0]]).is_empty());
        assert!(pieces(&[[-1.0, 1.0], [1.0, -1.0]]).is_empty());
        assert!(pieces(&[[12.0, 1.0]]).is_empty());
        assert_eq!(pieces(&[[2.0, 1.0]]), [[[2.0, 1.0]]]);
    }

    #[test]
    fn clipped_closed_line_stays_joined_at_its_start() {
        let round = [[5.0, 1.0], [5.0, 9.0], [8.0, 9.0], [8.0, 1.0], [5.0, 1.0]];
        assert_eq!(
            pieces(&round),
            [[[8.0, 5.0], [8.0, 1.0], [5.0, 1.0], [5.0, 5.0]]]
        );
        let whole = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 1.0]];
        assert_eq!(pieces(&whole), [whole]);
    }
}
