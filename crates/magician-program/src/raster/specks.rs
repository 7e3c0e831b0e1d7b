//! Specks: dark spots too small to be intended.

use super::Raster;

/// Whitens spots darker than `level` whose bounding box is smaller than `least` on both sides, mm;
/// returns their number.
pub(super) fn whiten(image: &mut Raster, pixel: [f64; 2], level: u8, least: f64) -> usize {
    if least <= 0.0 {
        return 0;
    }
    let (width, height) = (image.width, image.height);
    let mut seen = vec![false; image.grey.len()];
    let mut spot = Vec::new();
    let mut specks = 0;
    for first in 0..image.grey.len() {
        if seen[first] || image.grey[first] >= level {
            continue;
        }
        spot.clear();
        spot.push(first);
        seen[first] = true;
        let [mut left, mut right] = [first % width; 2];
        let mut bottom = first / width;
        let mut next = 0;
        while let Some(at) = spot.get(next).copied() {
            next += 1;
            let (x, y) = (at % width, at / width);
            (left, right) = (left.min(x), right.max(x));
            bottom = bottom.max(y);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                for column in x.saturating_sub(1)..(x + 2).min(width) {
                    let near = row * width + column;
                    if !seen[near] && image.grey[near] < level {
                        seen[near] = true;
                        spot.push(near);
                    }
                }
            }
        }
        let across = (right - left + 1) as f64 * pixel[0];
        let down = (bottom - first / width + 1) as f64 * pixel[1];
        if across.max(down) < least {
            specks += 1;
            spot.iter().for_each(|at| image.grey[*at] = 255);
        }
    }
    specks
}
