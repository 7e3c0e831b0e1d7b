//! Exact Euclidean distance transform: columns first, then the lower envelope of parabolas along
//! each row (Meijster, Roerdink and Hesselink 2000).

use super::Picture;

/// Returns the distance of each pixel from the nearest inked one, mm, row by row from the bottom.
/// If no pixel is inked, all distances are the length of the diagonal.
pub(super) fn transform(picture: &Picture) -> Vec<f32> {
    let [width, height] = picture.frame().size();
    let columns = column_distances(picture.inked(), [width, height]);
    let per_mm = picture.frame().pixels_per_mm();
    let farthest = libm::hypot(width as f64, height as f64);
    let mut field = Vec::with_capacity(columns.len());
    let mut envelope = Envelope::default();
    for row in columns.chunks(width.max(1)) {
        envelope.rebuild(row);
        for squared_distance in envelope.along(row) {
            let pixels = (squared_distance as f64).sqrt().min(farthest);
            field.push((pixels / per_mm) as f32);
        }
    }
    field
}

/// Returns the distance to the nearest inked pixel of the same column, or width plus height in a
/// column without ink.
fn column_distances(inked: &[bool], [width, height]: [usize; 2]) -> Vec<u32> {
    let none = u32::try_from(width + height).unwrap_or(u32::MAX / 2);
    let mut distances = vec![none; inked.len()];
    let mut nearest = vec![none; width];
    let rows = (0..height).chain((0..height).rev());
    for (nth, row) in rows.enumerate() {
        if nth == height {
            nearest.fill(none);
        }
        let cells = row * width..(row + 1) * width;
        let (Some(distances), Some(inked)) = (distances.get_mut(cells.clone()), inked.get(cells))
        else {
            continue;
        };
        for ((distance, near), inked) in distances.iter_mut().zip(&mut nearest).zip(inked) {
            *near = if *inked { 0 } else { (*near + 1).min(none) };
            *distance = (*distance).min(*near);
        }
    }
    distances
}

/// Lower envelope: for each of its parabolas the vertex and the position from which it is lowest.
#[derive(Default)]
struct Envelope {
    parts: Vec<(i64, i64)>,
}

impl Envelope {
    fn rebuild(&mut self, row: &[u32]) {
        self.parts.clear();
        for (middle, height) in row.iter().enumerate() {
            let (middle, height) = (middle as i64, i64::from(*height));
            let mut start = 0;
            while let Some((other, other_start)) = self.parts.last().copied() {
                let other_height = i64::from(row.get(other as usize).copied().unwrap_or(0));
                let value =
                    |at: i64, middle: i64, height: i64| (at - middle).pow(2) + height.pow(2);
                if value(other_start, other, other_height) > value(other_start, middle, height) {
                    self.parts.pop();
                    continue;
                }
                // Position from which the new parabola is lower.
                let numerator = middle.pow(2) - other.pow(2) + height.pow(2) - other_height.pow(2);
                start = numerator.div_euclid(2 * (middle - other)) + 1;
                break;
            }
            if start < row.len() as i64 {
                self.parts.push((middle, start));
            }
        }
    }

    /// Iterates over squared distances along the row.
    fn along<'a>(&'a self, row: &'a [u32]) -> impl Iterator<Item = i64> + 'a {
        let mut part = 0;
        (0..row.len() as i64).map(move |at| {
            while self
                .parts
                .get(part + 1)
                .is_some_and(|(_, start)| *start <= at)
            {
                part += 1;
            }
            let (middle, _) = self.parts.get(part).copied().unwrap_or_default();
            let height = i64::from(row.get(middle as usize).copied().unwrap_or(0));
            (at - middle).pow(2) + height.pow(2)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::PixelGrid;

    #[test]
    fn distance_is_to_the_nearest_inked_pixel() {
        let lines = [
            vec![[0.0, 0.0]],
            vec![[4.0, 1.0], [4.0, 2.0]],
            vec![[1.5, 5.0], [3.0, 3.5]],
        ];
        let frame = PixelGrid::around(lines.iter().flatten().copied(), 1.0, 5.0);
        let picture = Picture::of_lines(frame, &lines);
        let [width, height] = frame.size();
        let inked: Vec<_> = (0..width * height)
            .filter(|at| picture.inked()[*at])
            .collect();
        for (at, distance) in transform(&picture).into_iter().enumerate() {
            let distance_to = |other: &usize| {
                let [dx, dy] = [at % width, at / width].map(|value| value as f64);
                let [x, y] = [other % width, other / width].map(|value| value as f64);
                libm::hypot(dx - x, dy - y) / 5.0
            };
            let nearest = inked.iter().map(distance_to).fold(f64::MAX, f64::min);
            assert!((f64::from(distance) - nearest).abs() < 1e-5, "{at}");
        }
    }

    #[test]
    fn empty_picture_gives_the_diagonal() {
        let frame = PixelGrid::around([[0.0, 0.0], [3.0, 4.0]], 0.0, 10.0);
        let empty: [Vec<[f64; 2]>; 0] = [];
        let field = transform(&Picture::of_lines(frame, &empty));
        assert!(field.iter().all(|distance| (distance - 5.0).abs() < 1e-5));
    }
}
