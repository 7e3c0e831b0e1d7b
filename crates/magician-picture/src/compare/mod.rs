//! Comparison of the marks that an arm has left with those that it was meant to leave.
//!
//! Drawn lines are compared with those of the source by their centre lines, regardless of width
//! ([`compare`](fn@compare)): both are rasterised, and the distance of each inked pixel of one
//! picture from the nearest inked pixel of the other is measured. Burns of a laser are compared
//! with an image by darkness, cell by cell ([`Tones`]). The same input gives the same figures on
//! every machine.

mod difference;
mod distance;
mod picture;
mod source;
mod tones;

use magician_sim::world::Drawing;

pub use picture::{Picture, PixelGrid};
pub use source::svg_lines;
pub use tones::{ToneMatch, Tones};

/// Largest resolution, pixels per mm. The limit on the total number of pixels may reduce it.
const MAX_PIXELS_PER_MM: f64 = 20.0;
/// Margin around the lines, mm.
const MARGIN: f64 = 2.0;

/// Match of two sets of lines. Distances are accurate to the width of a pixel,
/// [`pixel`](Self::pixel).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Match {
    /// Share of the source with nothing drawn within the tolerance, 0 to 1.
    pub missing_share: f64,
    /// Share of the drawing with no source within the tolerance, 0 to 1.
    pub extra_share: f64,
    /// Largest distance of a point of the source from the drawing, mm. The picture's diagonal if
    /// nothing is drawn.
    pub worst_missing: f64,
    /// Largest distance of a point of the drawing from the source, mm.
    pub worst_extra: f64,
    /// Mean distance, mm, of all points of source and drawing from the nearest point of the other.
    pub mean: f64,
    /// Width of a pixel, mm.
    pub pixel: f64,
}

impl Match {
    /// Hausdorff distance, mm: the larger of [`worst_missing`](Self::worst_missing) and
    /// [`worst_extra`](Self::worst_extra).
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.worst_missing.max(self.worst_extra)
    }

    /// True if nothing is missing and nothing is extra.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.missing_share == 0.0 && self.extra_share == 0.0
    }
}

/// A finished comparison of two pictures of lines.
#[derive(Clone, Debug)]
pub struct Comparison {
    source: Picture,
    drawn: Picture,
    tolerance: f64,
    /// Shares and distances found.
    pub matched: Match,
}

impl Comparison {
    /// Compares two pictures with the same frame. A point matches if the other picture has one
    /// within the tolerance, mm. `None` if the frames differ.
    #[must_use]
    pub fn of(source: Picture, drawn: Picture, tolerance: f64) -> Option<Self> {
        (source.frame() == drawn.frame()).then(|| Self::measured(source, drawn, tolerance))
    }

    /// Compares pictures that are known to have the same frame.
    fn measured(source: Picture, drawn: Picture, tolerance: f64) -> Self {
        let pixel = 1.0 / source.frame().pixels_per_mm();
        let missing = Distances::between(&source, &drawn, tolerance);
        let extra = Distances::between(&drawn, &source, tolerance);
        let pixels = (missing.pixels + extra.pixels).max(1) as f64;
        let matched = Match {
            missing_share: missing.share(),
            extra_share: extra.share(),
            worst_missing: missing.worst,
            worst_extra: extra.worst,
            mean: (missing.sum + extra.sum) / pixels,
            pixel,
        };
        Self {
            source,
            drawn,
            tolerance,
            matched,
        }
    }

    /// Returns the difference as PNG: matching lines in black on grey, missing ones in red, extra
    /// ones in orange.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        difference::png(&self.source, &self.drawn, self.tolerance)
    }
}

/// Distances of the points of one picture from the other.
struct Distances {
    pixels: usize,
    beyond: usize,
    sum: f64,
    worst: f64,
}

impl Distances {
    fn between(from: &Picture, to: &Picture, tolerance: f64) -> Self {
        let mut distances = Self {
            pixels: 0,
            beyond: 0,
            sum: 0.0,
            worst: 0.0,
        };
        let field = distance::transform(to);
        let inked = from.inked().iter().zip(&field).filter(|(inked, _)| **inked);
        for distance in inked.map(|(_, distance)| f64::from(*distance)) {
            distances.pixels += 1;
            distances.beyond += usize::from(distance > tolerance);
            distances.sum += distance;
            distances.worst = distances.worst.max(distance);
        }
        distances
    }

    fn share(&self) -> f64 {
        self.beyond as f64 / self.pixels.max(1) as f64
    }
}

/// Compares two sets of lines in the same coordinates.
///
/// The resolution is 20 pixels per mm, or less if that would exceed 16 million pixels. A point
/// matches if the other set has one within the tolerance, mm.
///
/// ```
/// use magician_picture::compare::compare;
///
/// let source = [vec![[0.0, 0.0], [30.0, 0.0]]];
/// let drawn = [vec![[0.0, 0.3], [30.0, 0.3]]];
/// let close = compare(&source, &drawn, 0.5).matched;
/// assert!(close.is_good());
/// assert!((close.worst() - 0.3).abs() < close.pixel);
/// ```
#[must_use]
pub fn compare(source: &[Vec<[f64; 2]>], drawn: &[Vec<[f64; 2]>], tolerance: f64) -> Comparison {
    let points = source.iter().chain(drawn).flatten();
    let frame = PixelGrid::around(points.copied(), MARGIN, MAX_PIXELS_PER_MM);
    let [source, drawn] = [source, drawn].map(|lines| Picture::of_lines(frame, lines));
    Comparison::measured(source, drawn, tolerance)
}

/// Returns the lines of a drawing as polylines.
#[must_use]
pub fn lines_of(drawing: &Drawing) -> Vec<Vec<[f64; 2]>> {
    let strokes = drawing.strokes().iter();
    strokes.map(|stroke| stroke.points.clone()).collect()
}
