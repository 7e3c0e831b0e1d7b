//! Tolerance of flattened curves, and reading a file again at a finer one.
//!
//! A reader flattens curves before the final size of the drawing is known. If the drawing is then
//! enlarged, its chords are too coarse; if it is reduced, there are far too many. So a file with
//! curves is kept beside its content ([`Curves`]). Once the scale is known, the file is read again
//! unless the chords already fit ([`CurvedFile::is_unfit_for`]).
//!
//! Content that was edited since it was read must not be replaced, so a fingerprint of the lines is
//! compared first.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Content, Format, ReadOptions, lines};
use crate::{Artwork, Diagnostic, Plan};

/// Finest tolerance, mm. The arm cannot resolve less.
const MIN_TOLERANCE: f64 = 1e-4;
/// Ratio of scales up to which fine chords are kept. Their number grows with the square root of the
/// scale, so at 16 they are four times as many as needed, which costs less than reading again.
const MAX_SCALE_RATIO: f64 = 16.0;
/// Relative difference of scales that counts as rounding.
const SCALE_ROUNDING: f64 = 1e-6;

/// Tolerance of the chords of a file. `curved` becomes true once a curve has asked for it.
#[derive(Debug)]
#[cfg_attr(
    not(any(feature = "drawings", feature = "lettering", feature = "programs")),
    allow(dead_code)
)]
pub(crate) struct Chords {
    /// Largest distance of a chord from its curve at the size drawn, mm.
    drawn: f64,
    /// Length in the file that is drawn 1 mm long.
    unit: f64,
    curved: AtomicBool,
}

#[cfg_attr(
    not(any(feature = "drawings", feature = "lettering", feature = "programs")),
    allow(dead_code)
)]
impl Chords {
    fn of(options: &ReadOptions) -> Self {
        let usual = ReadOptions::default();
        let drawn = match options.tolerance {
            tolerance if tolerance.is_finite() => tolerance.max(MIN_TOLERANCE),
            // NaN or infinity: use the default instead of refusing to draw.
            _ => usual.tolerance,
        };
        Self {
            drawn,
            unit: 1.0 / usable(options.scale),
            curved: AtomicBool::new(false),
        }
    }

    /// Returns the tolerance for a curve, mm at the size of the file, and records that the file has
    /// curves: its lines then depend on the scale.
    pub(super) fn for_curve(&self) -> f64 {
        self.curved.store(true, Ordering::Relaxed);
        self.drawn * self.unit
    }

    /// Tolerance as [`for_curve`](Self::for_curve), for lines that may turn out straight.
    #[cfg(feature = "drawings")]
    pub(super) fn tolerance(&self) -> f64 {
        self.drawn * self.unit
    }

    /// Length in the file that is drawn 1 mm long.
    #[cfg(feature = "drawings")]
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// Largest distance of a chord from its curve at the size drawn, mm.
    #[cfg(feature = "programs")]
    pub(super) fn drawn(&self) -> f64 {
        self.drawn
    }
}

fn usable(scale: f64) -> f64 {
    if scale > 0.0 && scale.is_finite() {
        scale
    } else {
        1.0
    }
}

/// The file behind flattened curves, kept to flatten them again at the size in which they are
/// drawn. Ignored if the lines were changed since.
///
/// Equality ignores it: two contents with the same lines are equal.
#[derive(Clone, Default)]
pub struct Curves(Option<Arc<CurvedFile>>);

impl fmt::Debug for Curves {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match &self.0 {
            Some(_) => "Curves(..)",
            None => "Curves",
        })
    }
}

impl PartialEq for Curves {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A file with curves, and the options it was read with.
pub struct CurvedFile {
    format: Format,
    bytes: Arc<[u8]>,
    options: ReadOptions,
    /// Fingerprint of the lines that were read.
    lines: u64,
}

impl CurvedFile {
    /// True if the chords are too coarse for this scale, or much finer than it needs.
    #[must_use]
    pub fn is_unfit_for(&self, scale: f64) -> bool {
        let made_for = usable(self.options.scale);
        scale > made_for * (1.0 + SCALE_ROUNDING) || scale * MAX_SCALE_RATIO < made_for
    }

    /// Reads the file again for drawing at this scale.
    ///
    /// # Errors
    /// Same as [`read`](fn@super::read).
    pub fn read(&self, scale: f64) -> Result<Content, Diagnostic> {
        let options = ReadOptions {
            scale,
            ..self.options.clone()
        };
        let bytes = Arc::clone(&self.bytes);
        Ok(read(self.format, bytes, &options)?.content)
    }
}

/// Reads a file and keeps it beside its content if it has curves.
pub(super) fn read(
    format: Format,
    bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>,
    options: &ReadOptions,
) -> Result<super::Parsed, Diagnostic> {
    let chords = Chords::of(options);
    let mut reading = lines(format, bytes.as_ref(), options, &chords)?;
    if chords.curved.load(Ordering::Relaxed) {
        let file = CurvedFile {
            format,
            bytes: bytes.into(),
            options: options.clone(),
            lines: reading.content.fingerprint(),
        };
        reading.content.put_curves(Arc::new(file));
    }
    Ok(reading)
}

impl Content {
    fn curves(&mut self) -> Option<&mut Curves> {
        match self {
            Self::Artwork(artwork) => Some(&mut artwork.curves),
            Self::Plan(plan) => Some(&mut plan.curves),
            Self::Image(_) | Self::TestGrid(_) => None,
        }
    }

    /// Takes the file that the content was read from. `None` if it has no curves or the lines were
    /// changed since.
    pub fn take_curves(&mut self) -> Option<Arc<CurvedFile>> {
        let Curves(file) = std::mem::take(self.curves()?);
        file.filter(|file| file.lines == self.fingerprint())
    }

    /// Keeps the file that the lines were read from.
    pub fn put_curves(&mut self, file: Arc<CurvedFile>) {
        if let Some(curves) = self.curves() {
            *curves = Curves(Some(file));
        }
    }

    /// Longer side of the bounding box, mm; 0 for images and test grids.
    #[must_use]
    pub fn longest_side(&self) -> f64 {
        let bounds = match self {
            Self::Artwork(artwork) => artwork.bounds(),
            Self::Plan(plan) => plan.extent().map(|[least, most]| {
                let flat = |[x, y, _]: [f64; 3]| [x, y];
                [flat(least), flat(most)]
            }),
            Self::Image(_) | Self::TestGrid(_) => None,
        };
        bounds.map_or(0.0, |[least, most]| {
            f64::max(most[0] - least[0], most[1] - least[1])
        })
    }

    /// Fingerprint of the lines, to detect changes.
    fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint(0);
        match self {
            Self::Artwork(artwork) => print.artwork(artwork),
            Self::Plan(plan) => print.plan(plan),
            Self::Image(_) | Self::TestGrid(_) => {}
        }
        print.0
    }
}

struct Fingerprint(u64);

impl Fingerprint {
    /// Mixes in a number with two instructions, as `FxHash` does: a drawing has millions of
    /// numbers.
    fn take(&mut self, bits: u64) {
        self.0 = (self.0.rotate_left(5) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn points(&mut self, points: &[[f64; 2]]) {
        self.take(points.len() as u64);
        for value in points.as_flattened() {
            self.take(value.to_bits());
        }
    }

    fn artwork(&mut self, artwork: &Artwork) {
        let strokes = artwork.strokes.iter();
        let strokes = strokes.map(|stroke| (stroke.style, std::slice::from_ref(&stroke.points)));
        let areas = artwork.areas.iter();
        let areas = areas.map(|filled| (filled.style, filled.area.rings.as_slice()));
        for (style, lines) in strokes.chain(areas) {
            for number in [style.layer, style.color, style.part] {
                self.take(u64::from(number));
            }
            lines.iter().for_each(|points| self.points(points));
        }
    }

    fn plan(&mut self, plan: &Plan) {
        for step in &plan.steps {
            self.take(step.action.kind() as u64);
            for value in step.action.target().unwrap_or_default() {
                self.take(u64::from(value.to_bits()));
            }
        }
    }
}
