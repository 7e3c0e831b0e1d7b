//! Comparison of the darkness that a laser has left with the darkness of an image.

use magician_sim::world::{Drawing, StrokeKind};

use magician_program::Raster;

/// Step along a line, as a share of a cell.
const LINE_STEP: f64 = 1.0 / 32.0;
/// Largest number of cells along a side.
const MAX_CELLS: usize = 4096;

/// Darkness of the cells of a grid, 0 (nothing) to 1 (black).
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    size: [usize; 2],
    /// Rows from the bottom.
    values: Vec<f64>,
}

/// Match of two grids, in shares of full black.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ToneMatch {
    /// Mean difference of cells.
    pub mean: f64,
    /// Largest difference of a cell.
    pub worst: f64,
}

impl Tones {
    /// Returns the tones of the burnt lines between two corners, in cells of this size, mm. Each
    /// line counts as `spacing` wide (the distance between lines, mm), and as dark as its power.
    #[must_use]
    pub fn of_burns(drawing: &Drawing, corners: [[f64; 2]; 2], cell: f64, spacing: f64) -> Self {
        let mut tones = Self::blank(corners, cell);
        let burns = drawing.strokes().iter();
        for stroke in burns.filter(|stroke| stroke.kind == StrokeKind::Burn) {
            let pairs = stroke.points.iter().zip(stroke.points.iter().skip(1));
            for (from, to) in pairs {
                let [from, to] = [from, to]
                    .map(|point| [0, 1].map(|axis| (point[axis] - corners[0][axis]) / cell));
                tones.burn(from, to, stroke.power / 100.0 * spacing / cell);
            }
        }
        for value in &mut tones.values {
            *value = value.min(1.0);
        }
        tones
    }

    /// Returns the tones of an image that fills the area between two corners.
    #[must_use]
    pub fn of_image(image: &Raster, corners: [[f64; 2]; 2], cell: f64) -> Self {
        let mut tones = Self::blank(corners, cell);
        let [columns, rows] = tones.size;
        let extent = [0, 1].map(|axis| (corners[1][axis] - corners[0][axis]) / cell);
        for (at, value) in tones.values.iter_mut().enumerate() {
            let (column, row) = (
                at % columns.max(1),
                rows - 1 - (at / columns.max(1)).min(rows - 1),
            );
            let across = [column as f64, (column + 1) as f64].map(|edge| edge / extent[0]);
            // Images start at the top.
            let bottom = extent[1] - (rows - 1 - row) as f64;
            let down = [bottom - 1.0, bottom].map(|edge| edge / extent[1]);
            *value = darkness(image, across, down);
        }
        tones
    }

    /// Returns the difference from tones of the same grid; `None` if the grids differ.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<ToneMatch> {
        if self.size != other.size {
            return None;
        }
        let pairs = self.values.iter().zip(&other.values);
        let differences = pairs.map(|(one, two)| (one - two).abs());
        let (sum, worst) = differences.fold((0.0, 0.0_f64), |(sum, worst), difference| {
            (sum + difference, worst.max(difference))
        });
        Some(ToneMatch {
            mean: sum / self.values.len().max(1) as f64,
            worst,
        })
    }

    fn blank(corners: [[f64; 2]; 2], cell: f64) -> Self {
        let size = [0, 1].map(|axis| {
            let cells = (corners[1][axis] - corners[0][axis]) / cell;
            // A cast from float saturates. The subtraction keeps rounding from adding a cell at the
            // edge.
            ((cells - 1e-6).ceil().max(1.0) as usize).min(MAX_CELLS)
        });
        Self {
            size,
            values: vec![0.0; size[0] * size[1]],
        }
    }

    /// Burns a line given in cells. Each cell is darkened by `darkness` per cell length.
    fn burn(&mut self, from: [f64; 2], to: [f64; 2], darkness: f64) {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(way[0], way[1]);
        let steps = (length / LINE_STEP).ceil().clamp(1.0, 1e7);
        for nth in 0..steps as u64 {
            let share = (nth as f64 + 0.5) / steps;
            let [x, y] = [0, 1].map(|axis| (from[axis] + share * way[axis]).floor());
            let [columns, rows] = self.size;
            if x < 0.0 || y < 0.0 || x >= columns as f64 || y >= rows as f64 {
                continue;
            }
            if let Some(value) = self.values.get_mut(y as usize * columns + x as usize) {
                *value += darkness * length / steps;
            }
        }
    }
}

/// Mean darkness of a part of an image, given by shares (0 to 1) of its width and height.
fn darkness(image: &Raster, across: [f64; 2], down: [f64; 2]) -> f64 {
    let (columns, rows) = (
        covered_pixels(across, image.width),
        covered_pixels(down, image.height),
    );
    let (mut sum, mut weights) = (0.0, 0.0);
    for (row, high) in &rows {
        for (column, wide) in &columns {
            let grey = image
                .grey
                .get(row * image.width + column)
                .copied()
                .unwrap_or(255);
            sum += high * wide * (1.0 - f64::from(grey) / 255.0);
            weights += high * wide;
        }
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Returns the pixels between two shares of a side, each with the part that lies between them.
fn covered_pixels([from, to]: [f64; 2], pixels: usize) -> Vec<(usize, f64)> {
    let [from, to] = [from, to].map(|share| share.clamp(0.0, 1.0) * pixels as f64);
    let last = (to.ceil() as usize).min(pixels);
    let part = |pixel: usize| {
        let (low, high) = (pixel as f64, pixel as f64 + 1.0);
        (pixel, (to.min(high) - from.max(low)).max(0.0))
    };
    (from as usize..last).map(part).collect()
}
