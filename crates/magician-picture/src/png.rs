//! Rasteriser of our SVG pictures to PNG.

use magician_formats::svg_options;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg;

use crate::{Preview, Snapshot};

/// Largest number of pixels of a picture. It bounds memory.
pub(crate) const MAX_PIXELS: f64 = 64e6;
/// Number of times a scale is halved for a picture that would be too large.
const MAX_HALVINGS: usize = 4;
/// Units of an SVG (96 per inch) per millimetre.
const UNITS_PER_MM: f64 = 96.0 / 25.4;

/// Reason why a picture cannot be made.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PictureError {
    /// The scale is not positive and finite.
    Scale(f64),
    /// The picture would have too many pixels: width and height.
    Size([f64; 2]),
    /// The picture cannot be drawn or encoded.
    Drawing(String),
}

impl std::fmt::Display for PictureError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Scale(scale) => {
                write!(
                    f,
                    "a picture needs more than 0 pixels per millimetre, not {scale}"
                )
            }
            Self::Size([width, height]) => write!(
                f,
                "the picture would be {width:.0} by {height:.0} pixels, limit {MAX_PIXELS} \
                    pixels: use fewer pixels per millimetre"
            ),
            Self::Drawing(why) => write!(f, "the picture cannot be drawn: {why}"),
        }
    }
}

impl std::error::Error for PictureError {}

/// Becomes an error of the driver: invalid input.
impl From<PictureError> for magician_host::Error {
    fn from(error: PictureError) -> Self {
        Self::invalid(error.to_string())
    }
}

/// Draws a picture at a scale, and halves the scale up to four times while the picture is
/// `too_large`.
///
/// # Errors
/// The error of `draw` at the last scale.
pub fn fitting<E>(
    pixels_per_mm: f64,
    too_large: impl Fn(&E) -> bool,
    draw: impl Fn(f64) -> Result<Vec<u8>, E>,
) -> Result<Vec<u8>, E> {
    let mut scale = pixels_per_mm;
    for _ in 0..MAX_HALVINGS {
        match draw(scale) {
            Err(error) if too_large(&error) => scale /= 2.0,
            result => return result,
        }
    }
    draw(scale)
}

impl Preview {
    /// Rasterises the SVG to PNG at this resolution.
    ///
    /// # Errors
    /// [`PictureError`] if the scale is not positive and finite or the picture would be too large.
    pub fn to_png(&self, pixels_per_mm: f64) -> Result<Vec<u8>, PictureError> {
        to_png(self.to_svg(), pixels_per_mm)
    }
}

impl Snapshot {
    /// Rasterises the SVG to PNG at this resolution.
    ///
    /// # Errors
    /// [`PictureError`] if the scale is not positive and finite or the picture would be too large.
    pub fn to_png(&self, pixels_per_mm: f64) -> Result<Vec<u8>, PictureError> {
        to_png(self.to_svg(), pixels_per_mm)
    }
}

/// Rasterises any SVG to PNG at this resolution.
///
/// # Errors
/// [`PictureError`] if the scale is not positive and finite, the picture would be too large, or the
/// text is not an SVG.
pub fn to_png(svg: &str, pixels_per_mm: f64) -> Result<Vec<u8>, PictureError> {
    if !(pixels_per_mm > 0.0 && pixels_per_mm.is_finite()) {
        return Err(PictureError::Scale(pixels_per_mm));
    }
    let drawing_error = |why: String| PictureError::Drawing(why);
    let tree = usvg::Tree::from_str(svg, &svg_options())
        .map_err(|error| drawing_error(error.to_string()))?;
    let scale = pixels_per_mm / UNITS_PER_MM;
    let size = [tree.size().width(), tree.size().height()];
    let size = size.map(|side| (f64::from(side) * scale).ceil());
    if size[0] * size[1] > MAX_PIXELS {
        return Err(PictureError::Size(size));
    }
    let pixels = Pixmap::new(size[0] as u32, size[1] as u32);
    let mut pixels = pixels.ok_or(PictureError::Size(size))?;
    pixels.fill(Color::WHITE);
    let scale = scale as f32;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixels.as_mut(),
    );
    pixels
        .encode_png()
        .map_err(|error| drawing_error(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ArmView;

    #[test]
    fn oversize_picture_is_reduced() {
        let limited_to = |max_scale: f64| {
            move |scale: f64| {
                if scale > max_scale {
                    Err("large")
                } else {
                    Ok(scale.to_string().into_bytes())
                }
            }
        };
        let large = |error: &&str| *error == "large";
        assert_eq!(fitting(8.0, large, limited_to(8.0)).unwrap(), b"8");
        assert_eq!(fitting(8.0, large, limited_to(3.0)).unwrap(), b"2");
        assert_eq!(fitting(8.0, large, limited_to(0.5)).unwrap(), b"0.5");
        assert_eq!(fitting(8.0, large, limited_to(0.4)), Err("large"));
        assert_eq!(fitting(8.0, large, |_| Err("other")), Err("other"));
    }

    #[test]
    fn arm_is_drawn_at_any_positive_scale() {
        let snapshot = Snapshot::of_arm(&ArmView::default());
        assert!(snapshot.to_png(2.0).unwrap().starts_with(b"\x89PNG"));
        assert!(snapshot.to_png(0.0).is_err());
    }
}
