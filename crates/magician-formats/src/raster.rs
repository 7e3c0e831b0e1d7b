//! Grey images as the readers return them, and their size on the sheet.

mod adjust;

pub use adjust::Adjust;
use magician_host::message;

use crate::Diagnostic;

/// Size of an image on the sheet. The aspect ratio is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Size {
    /// The resolution in the file; without one [`Raster::DEFAULT_PIXEL_SIZE`] per pixel.
    #[default]
    Natural,
    /// Width, mm.
    Width(f64),
    /// Height, mm.
    Height(f64),
    /// Side of a square pixel, mm.
    Pixel(f64),
}

/// A grey image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// Title.
    pub title: String,
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Grey values row by row from the top, 0 black to 255 white, composed over white paper:
    /// transparent pixels are white.
    pub grey: Vec<u8>,
    /// Opacities in the same order, 0 transparent to 255 opaque; empty if the image is opaque.
    ///
    /// Transparent pixels are never drawn or burnt, and half-transparent ones half as much, even if
    /// the greys are inverted or adjusted.
    pub opacity: Vec<u8>,
    /// Width and height of a pixel, mm; `None` if the file has no resolution.
    pub pixel: Option<[f64; 2]>,
}

impl Raster {
    /// Side of a pixel if the file has no resolution, mm (DobotStudio engraves at 0.1 to 0.2).
    pub const DEFAULT_PIXEL_SIZE: f64 = 0.2;

    /// Returns width and height, mm.
    ///
    /// # Errors
    /// A [`Diagnostic`] if the image has no pixels, or the size is not positive and finite.
    pub fn size(&self, size: Size) -> Result<[f64; 2], Diagnostic> {
        self.validate()?;
        let pixel = self.pixel.unwrap_or([Self::DEFAULT_PIXEL_SIZE; 2]);
        let natural = [self.width as f64 * pixel[0], self.height as f64 * pixel[1]];
        let scale = match size {
            Size::Natural => 1.0,
            Size::Width(width) => width / natural[0],
            Size::Height(height) => height / natural[1],
            Size::Pixel(pitch) => {
                return check_positive([self.width as f64 * pitch, self.height as f64 * pitch]);
            }
        };
        check_positive(natural.map(|side| side * scale))
    }

    /// Checks that the numbers of pixels and opacities match width and height, and that the image
    /// is not empty.
    ///
    /// # Errors
    /// A [`Diagnostic`] that names both counts.
    pub fn validate(&self) -> Result<(), Diagnostic> {
        if self.width == 0 || self.height == 0 {
            return Err(Diagnostic::of_file(message!("the image has no pixels")));
        }
        if self.width.checked_mul(self.height) != Some(self.grey.len()) {
            return Err(Diagnostic::of_file(message!(
                "an image of {width} by {height} pixels cannot have {grey} of them",
                width = self.width,
                height = self.height,
                grey = self.grey.len()
            )));
        }
        if !self.opacity.is_empty() && self.opacity.len() != self.grey.len() {
            return Err(Diagnostic::of_file(message!(
                "an image of {width} by {height} pixels cannot have {opacity} opacities",
                width = self.width,
                height = self.height,
                opacity = self.opacity.len()
            )));
        }
        Ok(())
    }
}

/// Checks a size of an image, mm, and returns it.
///
/// # Errors
/// A [`Diagnostic`] if width or height is not positive and finite.
pub fn check_positive(size: [f64; 2]) -> Result<[f64; 2], Diagnostic> {
    if size.iter().all(|side| *side > 0.0 && side.is_finite()) {
        return Ok(size);
    }
    let [width, height] = size;
    Err(Diagnostic::of_file(message!(
        "an image cannot be {width} mm by {height} mm",
        width,
        height
    )))
}
