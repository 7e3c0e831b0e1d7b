//! How well what an arm has left matches what it was to leave: both as pixels, and how far those of one are from the
//! nearest of the other.
//!
//! Lines are compared by where their middles run, whatever their width: [`compare`](fn@compare). What a laser has burnt
//! is compared with an image by how dark it is, cell by cell: [`Tones`]. The same input gives the same figures on every
//! machine.

mod difference;
mod distance;
mod picture;
mod source;
mod tones;

use magician_sim::world::Drawing;

pub use picture::{Picture, PixelGrid};
pub use source::svg_lines;
pub use tones::{ToneMatch, Tones};

/// Pixels in a millimetre, as long as there are not too many in all.
const FINEST: f64 = 20.0;
/// What is left free around, mm.
const MARGIN: f64 = 2.0;

/// How well two sets of lines match. What is measured in mm is true to a pixel's width, which
/// [`pixel`](Self::pixel) tells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Match {
    /// The share of the source that nothing is drawn within the tolerance of, 0 to 1.
    pub missing_share: f64,
    /// The share of what is drawn that nothing of the source is within the tolerance of, 0 to 1.
    pub extra_share: f64,
    /// How far the place of the source is from the drawing that is farthest from it, mm; the picture's diagonal if nothing
    /// is drawn.
    pub worst_missing: f64,
    /// How far the place of the drawing is from the source that is farthest from it, mm.
    pub worst_extra: f64,
    /// How far places of either are from the other in the mean, mm.
    pub mean: f64,
    /// The width of a pixel, mm.
    pub pixel: f64,
}

impl Match {
    /// The greatest distance of a place of either from the other, mm: the Hausdorff distance.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.worst_missing.max(self.worst_extra)
    }

    /// Whether nothing is missing and nothing is too much.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.missing_share == 0.0 && self.extra_share == 0.0
    }
}

/// Two pictures of lines that have been compared.
#[derive(Clone, Debug)]
pub struct Comparison {
    source: Picture,
    drawn: Picture,
    tolerance: f64,
    /// The figures.
    pub matched: Match,
}

impl Comparison {
    /// Compares two pictures of the same frame; a place matches if the other picture has something within the tolerance,
    /// mm. `None` if the frames differ.
    #[must_use]
    pub fn of(source: Picture, drawn: Picture, tolerance: f64) -> Option<Self> {
        (source.frame() == drawn.frame()).then(|| Self::measured(source, drawn, tolerance))
    }

    /// Of pictures of the same frame.
    fn measured(source: Picture, drawn: Picture, tolerance: f64) -> Self {
        let pixel = 1.0 / source.frame().pixels_per_mm();
        let missing = Distances::between(&source, &drawn, tolerance);
        let extra = Distances::between(&drawn, &source, tolerance);
        let places = (missing.places + extra.places).max(1) as f64;
        let matched = Match {
            missing_share: missing.share(),
            extra_share: extra.share(),
            worst_missing: missing.worst,
            worst_extra: extra.worst,
            mean: (missing.sum + extra.sum) / places,
            pixel,
        };
        Self {
            source,
            drawn,
            tolerance,
            matched,
        }
    }

    /// The difference as PNG: what is as it was to be in black on grey, what is missing in red, what is too much in
    /// orange.
    #[must_use]
    pub fn to_png(&self) -> Vec<u8> {
        difference::png(&self.source, &self.drawn, self.tolerance)
    }
}

/// What the places of one picture have to the other.
struct Distances {
    places: usize,
    beyond: usize,
    sum: f64,
    worst: f64,
}

impl Distances {
    fn between(of: &Picture, to: &Picture, tolerance: f64) -> Self {
        let mut found = Self {
            places: 0,
            beyond: 0,
            sum: 0.0,
            worst: 0.0,
        };
        let field = distance::field(to);
        let inked = of.inked().iter().zip(&field).filter(|(inked, _)| **inked);
        for distance in inked.map(|(_, distance)| f64::from(*distance)) {
            found.places += 1;
            found.beyond += usize::from(distance > tolerance);
            found.sum += distance;
            found.worst = found.worst.max(distance);
        }
        found
    }

    fn share(&self) -> f64 {
        self.beyond as f64 / self.places.max(1) as f64
    }
}

/// Compares lines with lines, in the same coordinates: as fine as 16 million pixels allow, 20 to the millimetre at most. A
/// place matches if the other has something within the tolerance, mm.
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
    let frame = PixelGrid::around(points.copied(), MARGIN, FINEST);
    let [source, drawn] = [source, drawn].map(|lines| Picture::of_lines(frame, lines));
    Comparison::measured(source, drawn, tolerance)
}

/// The lines of a drawing, each by its corners.
#[must_use]
pub fn lines_of(drawing: &Drawing) -> Vec<Vec<[f64; 2]>> {
    let strokes = drawing.strokes().iter();
    strokes.map(|stroke| stroke.points.clone()).collect()
}
