//! Squiggle: an image drawn as rows, alternately forwards and backwards, whose lines oscillate with
//! larger amplitude and frequency in darker areas.
//!
//! A row is at its lightest as a straight pen line. For lighter areas rows are left out: only every
//! second, fourth or eighth row remains, and oscillates to make up for the others.

use magician_host::message;
use std::f64::consts::TAU;

use super::Trace;
use super::shade::{Shade, check_bounds};
use crate::{Diagnostic, Stroke};

/// Window over which the image is averaged, in line distances.
const AVERAGING_WINDOW: f64 = 0.6;
/// Points per period of the oscillation.
const POINTS_PER_PERIOD: f64 = 16.0;
/// Length of straight pieces where a line hardly oscillates, in line distances.
const STRAIGHT_PIECE: f64 = 0.5;
/// Shortest stretch with or without ink, in line distances.
const MIN_RUN: f64 = 2.0;
/// Thinning order of eight rows: in areas lighter than straight lines can show, rows with high
/// numbers are left out first, and the remaining ones oscillate.
const THINNING_ORDER: [u8; 8] = [0, 3, 2, 3, 1, 3, 2, 3];
/// Largest thinning: seven of eight rows are left out.
const MAX_THINNING: u8 = 3;

/// Returns the rows, each in as few strokes as possible.
pub(super) fn strokes(shade: &Shade, trace: &Trace) -> Result<Vec<Stroke>, Diagnostic> {
    let [width, height] = shade.page();
    let rows = (height / trace.spacing()).round().max(1.0);
    check_bounds(message!("lines"), rows, rows * width * 4.0)?;
    let pitch = height / rows;
    let oscillations = Oscillations::new(pitch, trace.pen_width);
    let straight = oscillations.inked[0];
    let mut strokes = Vec::new();
    for row in 0..rows as usize {
        let y = (row as f64 + 0.5) * pitch;
        let darkness = |x: f64| shade.around([x, y], [AVERAGING_WINDOW * pitch, pitch]);
        // Thinning at this darkness: 0 keeps all rows, 1, 2 and 3 every second, fourth and eighth.
        let thinning_for = |dark: f64| {
            let mut thinning = 0;
            while thinning < MAX_THINNING && dark * f64::from(1_u32 << thinning) < straight {
                thinning += 1;
            }
            thinning
        };
        let drawn = |x: f64| {
            let dark = darkness(x);
            let thinning = thinning_for(dark);
            // Blank if lighter than half of the lightest shade available.
            let blank = dark * f64::from(1_u32 << MAX_THINNING) < straight / 2.0;
            !blank && THINNING_ORDER[row % THINNING_ORDER.len()] <= MAX_THINNING - thinning
        };
        let line = |[from, to]: [f64; 2]| {
            let mut points = Vec::new();
            let (mut x, mut phase) = (from, 0.0_f64);
            while x < to {
                let dark = darkness(x);
                let share = dark * f64::from(1_u32 << thinning_for(dark));
                let Oscillation { amplitude, period } = oscillations.of(share);
                points.push([x, y + amplitude * libm::sin(TAU * phase)]);
                let step = (period / POINTS_PER_PERIOD).min(STRAIGHT_PIECE * pitch);
                phase += step / period;
                x += step;
            }
            points.push([to, y]);
            points
        };
        let mut found: Vec<_> = runs(width, MIN_RUN * pitch, pitch * STRAIGHT_PIECE, drawn)
            .into_iter()
            .map(line)
            .collect();
        // Every second row runs backwards.
        if row % 2 == 1 {
            found.reverse();
            found.iter_mut().for_each(|points| points.reverse());
        }
        strokes.extend(found.iter().map(|points| shade.stroke(points)));
    }
    Ok(strokes)
}

/// Stretches where a condition holds, without stretches and gaps below the least length.
fn runs(length: f64, least: f64, step: f64, holds: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
    let count = (length / step).ceil().max(1.0) as usize;
    let step = length / count as f64;
    let mut found: Vec<[f64; 2]> = Vec::new();
    for nth in (0..count).filter(|nth| holds((*nth as f64 + 0.5) * step)) {
        let [from, to] = [nth, nth + 1].map(|nth| nth as f64 * step);
        match found.last_mut() {
            Some([_, end]) if from - *end < least => *end = to,
            _ => found.push([from, to]),
        }
    }
    found.retain(|[from, to]| to - from >= least.min(length));
    found
}

/// Oscillation of a line.
#[derive(Clone, Copy)]
struct Oscillation {
    amplitude: f64,
    period: f64,
}

/// Oscillations in order of increasing ink, from a straight line to a line that inks everything up
/// to the next row. First the amplitude grows, then the frequency.
struct Oscillations {
    pitch: f64,
    pen_width: f64,
    /// Share of the paper inked by each oscillation in order.
    inked: Vec<f64>,
}

impl Oscillations {
    const COUNT: usize = 24;

    fn new(pitch: f64, pen_width: f64) -> Self {
        let mut oscillations = Self {
            pitch,
            pen_width,
            inked: Vec::new(),
        };
        let mut inked: Vec<f64> = (0..=Self::COUNT)
            .map(|nth| {
                oscillations.coverage(oscillations.interpolated(nth as f64 / Self::COUNT as f64))
            })
            .collect();
        for nth in 1..inked.len() {
            inked[nth] = inked[nth].max(inked[nth - 1]);
        }
        oscillations.inked = inked;
        oscillations
    }

    fn interpolated(&self, share: f64) -> Oscillation {
        let frequency_share = (2.0 * share - 1.0).max(0.0);
        // At the highest frequency the crests reach between the troughs of the next row.
        let max_amplitude = (self.pitch - self.pen_width * (1.0 - 1.5 * frequency_share)) / 2.0;
        let (slow, fast) = (1.2 * self.pitch, 1.3 * self.pen_width);
        let slow = slow.max(fast);
        Oscillation {
            amplitude: max_amplitude.max(0.0) * (2.0 * share).min(1.0),
            // Interpolates the frequency linearly.
            period: 1.0 / ((1.0 - frequency_share) / slow + frequency_share / fast),
        }
    }

    /// Oscillation that inks this share of the paper.
    fn of(&self, share: f64) -> Oscillation {
        let after = self.inked.partition_point(|inked| *inked < share);
        let Some(before) = after.checked_sub(1) else {
            return self.interpolated(0.0);
        };
        let Some(most) = self.inked.get(after) else {
            return self.interpolated(1.0);
        };
        let part = (share - self.inked[before]) / (most - self.inked[before]).max(1e-9);
        self.interpolated((before as f64 + part) / Self::COUNT as f64)
    }

    /// Share of the paper inked by rows that all have this oscillation. Measured on a raster,
    /// because ink overlaps at crests and between neighbouring rows.
    fn coverage(&self, oscillation: Oscillation) -> f64 {
        const ACROSS: usize = 32;
        const DOWN: usize = 48;
        let Oscillation { amplitude, period } = oscillation;
        let sine = |x: f64| amplitude * libm::sin(TAU * x / period);
        let radius = self.pen_width / 2.0;
        let pieces = 3 * POINTS_PER_PERIOD as i64;
        let corner = |nth: i64| {
            let x = period * nth as f64 / POINTS_PER_PERIOD;
            [x, sine(x)]
        };
        let corners: Vec<[f64; 2]> = (-pieces..=pieces).map(corner).collect();
        let is_inked = |x: f64, y: f64| {
            let ends = corners.windows(2);
            let mut close = ends.filter(|ends| ends[0][0] < x + radius && ends[1][0] > x - radius);
            close.any(|ends| distance_to_segment([x, y], ends[0], ends[1]) <= radius)
        };
        let mut inked = 0;
        for across in 0..ACROSS {
            let x = (across as f64 + 0.5) / ACROSS as f64 * period;
            for down in 0..DOWN {
                let y = ((down as f64 + 0.5) / DOWN as f64 - 0.5) * self.pitch;
                let rows = [0.0, -1.0, 1.0];
                inked += usize::from(rows.iter().any(|row| is_inked(x, y + row * self.pitch)));
            }
        }
        inked as f64 / (ACROSS * DOWN) as f64
    }
}

/// Distance of a point from a line segment.
fn distance_to_segment(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0] * way[0] + way[1] * way[1];
    let out = [point[0] - from[0], point[1] - from[1]];
    let along = (out[0] * way[0] + out[1] * way[1]) / length.max(1e-12);
    let along = along.clamp(0.0, 1.0);
    libm::hypot(out[0] - along * way[0], out[1] - along * way[1])
}
