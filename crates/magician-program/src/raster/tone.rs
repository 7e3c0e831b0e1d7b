//! Conversion of grey levels to laser power.

use super::Engrave;

/// Conversion of grey levels to power.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tone {
    /// Power by darkness: none for white, and from the least to the largest power between the
    /// lightest grey and black.
    #[default]
    Grey,
    /// Full power below this grey level (1 to 255), none above.
    Threshold(u8),
    /// Dots of full power, denser in dark areas (Floyd-Steinberg error diffusion).
    Dither,
}

/// Number of power steps between the least and the largest. An arbitrary number: with fewer steps
/// more neighbouring cells have equal power and share a segment.
const LEVELS: u8 = 100;
/// Level of full power; level 1 is the least power, 0 none.
const FULL_LEVEL: u8 = LEVELS + 1;

/// Power of each level, percent.
pub(super) struct Powers([f32; FULL_LEVEL as usize + 1]);

impl Powers {
    pub(super) fn new(engrave: &Engrave) -> Self {
        let [least, most] = engrave.power;
        let mut powers = [0.0; FULL_LEVEL as usize + 1];
        for (level, power) in powers.iter_mut().enumerate().skip(1) {
            let share = (level - 1) as f64 / f64::from(LEVELS);
            *power = (least + (most - least) * share) as f32;
        }
        Self(powers)
    }

    pub(super) fn of(&self, level: u8) -> f32 {
        self.0.get(usize::from(level)).copied().unwrap_or(0.0)
    }
}

/// Converts grey values to levels of power in place, scaled by the opacity of each cell:
/// transparent cells get none. `opacity` is empty if the image is opaque.
pub(super) fn levels(cells: &mut [u8], opacity: &[u8], columns: usize, engrave: &Engrave) {
    let opaque = |at: usize| opacity.get(at).copied().unwrap_or(u8::MAX);
    // The grey values are those over white, so a cell is no darker than its opacity.
    for (at, cell) in cells.iter_mut().enumerate() {
        let dark = (255 - *cell).min(opaque(at));
        *cell = if engrave.invert {
            match (opaque(at) - dark, opaque(at)) {
                // A difference of 1 in a translucent cell comes from rounding grey and opacity
                // separately.
                (1, opaque) if opaque < u8::MAX => 0,
                (light, _) => light,
            }
        } else {
            dark
        };
    }
    // Gamma applies to the cell's own darkness; its opacity then scales the power.
    let share = |dark: u8, opaque: u8| match opaque {
        0 => 0.0,
        _ => {
            let darkness = f64::from(dark) / f64::from(opaque);
            libm::pow(darkness, engrave.gamma) * f64::from(opaque) / 255.0
        }
    };
    match engrave.tone {
        Tone::Grey => {
            let table = table(|dark| grey_level(share(dark, u8::MAX)));
            for (at, cell) in cells.iter_mut().enumerate() {
                *cell = match (*cell, opaque(at)) {
                    (0, _) => 0,
                    (dark, u8::MAX) => table[usize::from(dark)],
                    (dark, opaque) => grey_level(share(dark, opaque)),
                };
            }
            if engrave.power[0] <= 0.0 {
                apply_to_each(cells, |level| if level == 1 { 0 } else { level });
            }
        }
        Tone::Threshold(level) => {
            apply_to_each(
                cells,
                |dark| if 255 - dark < level { FULL_LEVEL } else { 0 },
            )
        }
        Tone::Dither => {
            let dots = |share: f64| (share * 255.0).round() as u8;
            let table = table(|dark| dots(share(dark, u8::MAX)));
            for (at, cell) in cells.iter_mut().enumerate() {
                *cell = match (*cell, opaque(at)) {
                    (dark, u8::MAX) => table[usize::from(dark)],
                    (dark, opaque) => dots(share(dark, opaque)),
                };
            }
            diffuse(cells, opacity, columns);
        }
    }
}

/// Level for a share of the power.
fn grey_level(share: f64) -> u8 {
    1 + (share * f64::from(LEVELS)).round() as u8
}

fn apply_to_each(cells: &mut [u8], make: impl Fn(u8) -> u8) {
    cells.iter_mut().for_each(|cell| *cell = make(*cell));
}

/// Table of `make` for each darkness; 0 for white.
fn table(make: impl Fn(u8) -> u8) -> [u8; 256] {
    let mut table = [0; 256];
    for dark in 1..=u8::MAX {
        table[usize::from(dark)] = make(dark);
    }
    table
}

/// Reduces each cell to black or white and spreads the error over later neighbours: 7/16 to the
/// next, 3, 5 and 1/16 to those below. Every other row runs backwards, so that no pattern leans to
/// one side. Error passed to a transparent cell is dropped.
fn diffuse(cells: &mut [u8], opacity: &[u8], columns: usize) {
    // An extra cell on either side receives the error at the edges.
    let mut this_row = vec![0_i32; columns + 2];
    let mut next_row = this_row.clone();
    for (nth, row) in cells.chunks_exact_mut(columns.max(1)).enumerate() {
        next_row.fill(0);
        for step in 0..columns {
            let (at, ahead) = match nth % 2 {
                0 => (step, 1),
                _ => (columns - 1 - step, -1),
            };
            if opacity.get(nth * columns + at) == Some(&0) {
                row[at] = 0;
                continue;
            }
            let target = i32::from(row[at]) * 16 + this_row[at + 1];
            let full = target >= 128 * 16;
            row[at] = if full { FULL_LEVEL } else { 0 };
            let error = target - if full { 255 * 16 } else { 0 };
            let side = |by: isize| (at + 1).wrapping_add_signed(by);
            // The cell below also gets the remainder of the integer divisions.
            let shares = [7, 3, 1].map(|share| error * share / 16);
            this_row[side(ahead)] += shares[0];
            next_row[side(-ahead)] += shares[1];
            next_row[side(ahead)] += shares[2];
            next_row[at + 1] += error - shares.iter().sum::<i32>();
        }
        std::mem::swap(&mut this_row, &mut next_row);
    }
}
