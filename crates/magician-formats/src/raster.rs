//! Grey images, as readers make them.

mod adjust;

pub use adjust::Adjust;
use magician_host::message;

use crate::Diagnostic;

/// How large an image becomes; its sides keep their ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Size {
    /// As the file says; where it does not, [`Raster::PIXEL`] for a pixel.
    #[default]
    Natural,
    /// So wide, mm.
    Width(f64),
    /// So high, mm.
    Height(f64),
    /// Square pixels of this side, mm.
    Pixel(f64),
}

/// A grey image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// What it is called.
    pub title: String,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Row by row from the top, 0 black to 255 white, as it shows over white paper: what is transparent is white.
    pub grey: Vec<u8>,
    /// In the same order, 0 transparent to 255 opaque; empty if all of it is opaque. What is transparent is never drawn nor
    /// burnt, and half of it half as much, however the greys are changed.
    pub opacity: Vec<u8>,
    /// Width and height of a pixel, mm, where the file says so.
    pub pixel: Option<[f64; 2]>,
}

impl Raster {
    /// How large a pixel is of an image that does not say so, mm (DobotStudio engraves at 0.1 to 0.2).
    pub const PIXEL: f64 = 0.2;

    /// As many mm across and down.
    ///
    /// # Errors
    /// An image without pixels, or a size that is none.
    pub fn size(&self, size: Size) -> Result<[f64; 2], Diagnostic> {
        self.validate()?;
        let pixel = self.pixel.unwrap_or([Self::PIXEL; 2]);
        let natural = [self.width as f64 * pixel[0], self.height as f64 * pixel[1]];
        let scale = match size {
            Size::Natural => 1.0,
            Size::Width(width) => width / natural[0],
            Size::Height(height) => height / natural[1],
            Size::Pixel(pitch) => {
                return positive([self.width as f64 * pitch, self.height as f64 * pitch]);
            }
        };
        positive(natural.map(|side| side * scale))
    }

    /// Checks that it has as many pixels and opacities as its width and height say, and at least
    /// one.
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

/// The width and height of an image, mm.
///
/// # Errors
/// A [`Diagnostic`] if one is not positive and finite.
pub fn positive(size: [f64; 2]) -> Result<[f64; 2], Diagnostic> {
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
