//! Outer contours of lines, by morphological closing of a bitmap.
//!
//! Marks are drawn into a bitmap, dilated and eroded by the same radius, which closes narrow gaps,
//! and traced. Only outer contours are kept.

use super::{closed, hull};
use crate::Artwork;
use crate::Raster;
use crate::raster::{Size, Trace};

/// Half the width of gaps between marks that are closed, mm.
const GAP_HALF_WIDTH: f64 = 2.0;
/// Radius of the closing in pixels, for `GAP_HALF_WIDTH`.
const CLOSING_RADIUS: usize = 4;
/// Largest side of the bitmap in pixels: pixels grow for larger drawings.
const MAX_SIDE: f64 = 1500.0;

/// Outer contours of some lines, exact to half a millimetre for drawings within the arm's reach.
pub(super) fn of(lines: &Artwork) -> Vec<Vec<[f64; 2]>> {
    let [least, most] = lines.bounds().unwrap_or_default();
    let side = f64::max(most[0] - least[0], most[1] - least[1]);
    let pixel = (GAP_HALF_WIDTH / CLOSING_RADIUS as f64).max(side / MAX_SIDE);
    // Margin for the growth at the edges.
    let room = pixel * (CLOSING_RADIUS + 2) as f64;
    // Offset by half a pixel, so that a line along pixel centres grows equally to both sides.
    let corner = least.map(|at| at - room - pixel / 2.0);
    let pixels =
        |axis: usize| ((most[axis] - least[axis] + 2.0 * room) / pixel).ceil() as usize + 1;
    let mut image = Bitmap::new(pixels(0), pixels(1));
    for stroke in &lines.strokes {
        let place = |[x, y]: [f64; 2]| [(x - corner[0]) / pixel, (y - corner[1]) / pixel];
        let mut from = None;
        for point in stroke.points.iter().map(|point| place(*point)) {
            image.line(from.unwrap_or(point), point);
            from = Some(point);
        }
    }
    let closing = image.grown(true).grown(false);
    let trace = Trace {
        size: Size::Pixel(pixel),
        tolerance: pixel,
        despeckle: 0.0,
        ..Trace::default()
    };
    let contours = trace
        .lines(&closing.raster())
        .map(|traced| traced.artwork.strokes)
        .unwrap_or_default();
    // Dark is on the right of a contour, so contours around light areas are holes.
    let outer = contours
        .into_iter()
        .filter(|stroke| area(&stroke.points) < 0.0);
    let outer: Vec<_> = outer
        .map(|stroke| {
            let points = stroke.points.iter();
            points
                .map(|[x, y]| [x + corner[0], y + corner[1]])
                .collect()
        })
        .collect();
    if outer.is_empty() {
        let points: Vec<_> = lines
            .strokes
            .iter()
            .flat_map(|stroke| &stroke.points)
            .copied()
            .collect();
        return vec![closed(hull(&points))];
    }
    outer
}

/// Twice the signed area of a ring; positive if counter-clockwise.
fn area(ring: &[[f64; 2]]) -> f64 {
    let pairs = ring.iter().zip(ring.iter().skip(1));
    pairs
        .map(|([x, y], [to_x, to_y])| x * to_y - to_x * y)
        .sum()
}

/// Bitmap, row by row from the bottom.
struct Bitmap {
    width: usize,
    height: usize,
    marked: Vec<bool>,
}

impl Bitmap {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            marked: vec![false; width * height],
        }
    }

    /// Marks the pixels of a line.
    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let way = libm::hypot(to[0] - from[0], to[1] - from[1]);
        let count = (2.0 * way).ceil().max(1.0);
        for nth in 0..=count as usize {
            let share = nth as f64 / count;
            let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            let (x, y) = (x as usize, y as usize);
            if x < self.width
                && let Some(pixel) = self.marked.get_mut(y * self.width + x)
            {
                *pixel = true;
            }
        }
    }

    /// Dilation of the marked pixels by the radius, or erosion if `marked` is false.
    fn grown(&self, marked: bool) -> Self {
        let radius = CLOSING_RADIUS as isize;
        let disc: Vec<[isize; 2]> = (-radius..=radius)
            .flat_map(|y| (-radius..=radius).map(move |x| [x, y]))
            .filter(|[x, y]| x * x + y * y <= radius * radius)
            .collect();
        let mut grown = Self {
            width: self.width,
            height: self.height,
            marked: self.marked.clone(),
        };
        for (at, _) in self
            .marked
            .iter()
            .enumerate()
            .filter(|(_, is)| **is == marked)
        {
            let (x, y) = (at % self.width, at / self.width);
            if self.is_within(x, y, marked) {
                continue;
            }
            for [dx, dy] in &disc {
                let (Some(x), Some(y)) = (x.checked_add_signed(*dx), y.checked_add_signed(*dy))
                else {
                    continue;
                };
                if x < self.width
                    && let Some(pixel) = grown.marked.get_mut(y * self.width + x)
                {
                    *pixel = marked;
                }
            }
        }
        grown
    }

    /// True if all neighbours have the same value: the disc around such a pixel adds nothing to the
    /// discs of its neighbours.
    fn is_within(&self, x: usize, y: usize, marked: bool) -> bool {
        let same = |x: Option<usize>, y: Option<usize>| {
            let (Some(x), Some(y)) = (x.filter(|x| *x < self.width), y) else {
                return true;
            };
            self.marked
                .get(y * self.width + x)
                .is_none_or(|is| *is == marked)
        };
        same(x.checked_sub(1), Some(y))
            && same(Some(x + 1), Some(y))
            && same(Some(x), y.checked_sub(1))
            && same(Some(x), Some(y + 1))
    }

    /// Converts to an image, from the top row.
    fn raster(&self) -> Raster {
        let rows = self.marked.chunks(self.width).rev().flatten();
        Raster {
            width: self.width,
            height: self.height,
            grey: rows.map(|marked| if *marked { 0 } else { 255 }).collect(),
            ..Raster::default()
        }
    }
}
