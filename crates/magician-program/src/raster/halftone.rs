//! Halftone: an image as dots on a grid turned by 45 degrees, each sized by the darkness around it.
//!
//! The share of ink in a cell equals the darkness of the image. Dots come in a limited number of
//! sizes, and the error of each dot is diffused to its neighbours, so that the mean is right even
//! in light areas.

use magician_host::message;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use super::Trace;
use super::shade::{Shade, check_bounds};
use crate::{Diagnostic, Stroke};

/// Distance between turns of a spiral, in pen widths. Below 1, so that no white is left between
/// them.
const SPIRAL_PITCH: f64 = 0.9;
/// Largest deviation of a polyline from its circle, mm.
const CIRCLE_TOLERANCE: f64 = 0.02;

/// Returns the dots, row by row.
pub(super) fn strokes(shade: &Shade, trace: &Trace) -> Result<Vec<Stroke>, Diagnostic> {
    let pitch = trace.spacing();
    let [width, height] = shade.page();
    let cells = width * height / (pitch * pitch);
    check_bounds(
        message!("dots"),
        cells,
        cells * pitch * pitch / trace.pen_width,
    )?;
    let dots = Dots::new(trace, pitch);
    let mut strokes = Vec::new();
    // Rows and columns of the grid run along the diagonals, from the upper left corner.
    let reach = ((width + height) * FRAC_1_SQRT_2 / pitch).ceil() as i64 + 1;
    let back = (height * FRAC_1_SQRT_2 / pitch).ceil() as i64 + 1;
    let columns = (reach + back) as usize;
    let mut here = vec![0.0; columns + 2];
    let mut below = here.clone();
    for row in 0..reach {
        below.fill(0.0);
        for step in 0..columns {
            let forth = row % 2 == 0;
            let column = if forth { step } else { columns - 1 - step };
            let along = (column as i64 - back) as f64;
            let [u, v] = [along + 0.5, row as f64 + 0.5].map(|cells| cells * pitch);
            let middle = [(u + v) * FRAC_1_SQRT_2, (v - u) * FRAC_1_SQRT_2];
            let inside =
                middle[0] >= 0.0 && middle[0] <= width && middle[1] >= 0.0 && middle[1] <= height;
            if !inside {
                continue;
            }
            let wanted = shade.around(middle, [pitch; 2]);
            // White stays white: diffused error must not put dots there.
            let wanted = if wanted < 1.0 / 512.0 {
                0.0
            } else {
                wanted + here[column + 1]
            };
            let (radius, inked) = dots.of(wanted);
            if let Some(radius) = radius {
                strokes.push(shade.stroke(&dot(middle, radius, trace.pen_width)));
            }
            // The difference is passed to later dots (Floyd-Steinberg error diffusion).
            let off = (wanted - inked).clamp(-1.0, 1.0);
            let side = |by: i64| (column as i64 + 1 + by) as usize;
            let ahead = if forth { 1 } else { -1 };
            here[side(ahead)] += off * 7.0 / 16.0;
            below[side(-ahead)] += off * 3.0 / 16.0;
            below[side(0)] += off * 5.0 / 16.0;
            below[side(ahead)] += off / 16.0;
        }
        std::mem::swap(&mut here, &mut below);
    }
    Ok(strokes)
}

/// Available dots, by the share of a cell that they ink.
struct Dots {
    /// Radius of ink and share of the cell, in ascending order.
    sizes: Vec<[f64; 2]>,
    pen: f64,
}

impl Dots {
    /// Number of sizes unless `levels` is given.
    const DEFAULT_SIZES: u8 = 64;

    fn new(trace: &Trace, pitch: f64) -> Self {
        let count = trace.levels.unwrap_or(Self::DEFAULT_SIZES).max(1);
        let pen = trace.pen_width / 2.0;
        let least = inked(pen, pitch);
        // The last size covers the whole cell.
        let share =
            |nth: u8| least + (1.0 - least) * f64::from(nth) / f64::from((count - 1).max(1));
        let sizes = (0..count).map(|nth| {
            let share = share(nth);
            [radius(share, pitch).max(pen), share]
        });
        Self {
            sizes: sizes.collect(),
            pen,
        }
    }

    /// Path radius of the dot that inks about this share of its cell, and the share it really inks.
    /// `None` for no dot.
    fn of(&self, wanted: f64) -> (Option<f64>, f64) {
        let none = [0.0, 0.0];
        let after = self.sizes.partition_point(|[_, share]| *share <= wanted);
        let under = after.checked_sub(1).and_then(|at| self.sizes.get(at));
        let under = *under.unwrap_or(&none);
        let over = self.sizes.get(after).copied().unwrap_or(under);
        let [radius, share] = if over[1] - wanted < wanted - under[1] {
            over
        } else {
            under
        };
        let path = (share > 0.0).then_some((radius - self.pen).max(0.0));
        (path, share)
    }
}

/// Share of a cell inked by discs of this radius, which may overlap their neighbours.
fn inked(radius: f64, pitch: f64) -> f64 {
    let half = pitch / 2.0;
    let disc = PI * radius * radius;
    let overlap = if radius <= half {
        0.0
    } else {
        // Each disc shares a lens with each of its four neighbours; half of each lens is its own.
        let lens = 2.0 * radius * radius * libm::acos(half / radius)
            - half * (4.0 * radius * radius - pitch * pitch).max(0.0).sqrt();
        2.0 * lens
    };
    ((disc - overlap) / (pitch * pitch)).min(1.0)
}

/// Radius of discs that ink this share, by bisection.
fn radius(share: f64, pitch: f64) -> f64 {
    let (mut least, mut most) = (0.0, pitch * FRAC_1_SQRT_2);
    for _ in 0..40 {
        let middle = f64::midpoint(least, most);
        if inked(middle, pitch) < share {
            least = middle;
        } else {
            most = middle;
        }
    }
    most
}

/// Path of a dot: a point, a circle, or a spiral that ends in a circle.
fn dot(middle: [f64; 2], path: f64, pen_width: f64) -> Vec<[f64; 2]> {
    let at = |radius: f64, angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        [middle[0] + radius * cos, middle[1] + radius * sin]
    };
    if path < CIRCLE_TOLERANCE {
        return vec![middle];
    }
    let pieces = (PI / libm::acos(1.0 - (CIRCLE_TOLERANCE / path).min(0.5)))
        .ceil()
        .max(6.0);
    let turns = if path <= pen_width / 2.0 {
        0.0
    } else {
        (path / (SPIRAL_PITCH * pen_width)).ceil()
    };
    let mut points = Vec::new();
    let steps = (turns * pieces) as usize;
    for step in 0..steps {
        let share = step as f64 / (turns * pieces);
        points.push(at(path * share, TAU * turns * share));
    }
    for step in 0..pieces as usize {
        points.push(at(path, TAU * step as f64 / pieces));
    }
    points.push(at(path, 0.0));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_that_overlap_are_counted_once() {
        for (radius, share) in [
            (0.25, PI / 16.0),
            (0.5, PI / 4.0),
            (0.6, 0.950_910),
            (FRAC_1_SQRT_2, 1.0),
        ] {
            assert!((inked(radius, 1.0) - share).abs() < 1e-5, "{radius}");
        }
        for share in [0.05, 0.5, 0.8, 0.95] {
            assert!(
                (inked(radius(share, 2.0), 2.0) - share).abs() < 1e-6,
                "{share}"
            );
        }
    }
}
