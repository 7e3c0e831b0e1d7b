//! What pen and laser have drawn, as a file at the end.

use std::path::PathBuf;

use magician_sim::serve::{self, Handle};
use magician_sim::world::Drawing;

use crate::failure::Failure;

/// Resolution of a PNG: about 200 dots an inch.
const PIXELS_PER_MM: f64 = 8.0;

/// Where the picture goes, and as what.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    path: PathBuf,
    format: Format,
}

#[derive(Clone, Copy, Debug)]
enum Format {
    Svg,
    Png,
}

impl Picture {
    /// The end of the name says what it is.
    pub(super) fn at(path: PathBuf) -> Result<Self, &'static str> {
        let end = path.extension().map(|end| end.to_ascii_lowercase());
        let format = match end.as_deref().and_then(|end| end.to_str()) {
            Some("svg") => Format::Svg,
            Some("png") => Format::Png,
            _ => return Err("a picture is a .svg or .png file"),
        };
        Ok(Self { path, format })
    }

    /// Writes what the arms have drawn, a file for each.
    pub(super) async fn write(&self, arms: &[Handle], numbered: bool) -> Result<(), Failure> {
        for (number, arm) in (1..).zip(arms) {
            let drawing = arm.with(|runner| runner.controller().drawing());
            // An arm that is not served any more has been told of already.
            let Ok(drawing) = drawing.await else {
                continue;
            };
            let path = if numbered {
                serve::numbered(&self.path, number)
            } else {
                self.path.clone()
            };
            let wrong = |error: &dyn std::fmt::Display| {
                Failure::invalid(format!("{} cannot be written: {error}", path.display()))
            };
            let bytes = self.bytes(&drawing).map_err(|error| wrong(&error))?;
            std::fs::write(&path, bytes).map_err(|error| wrong(&error))?;
        }
        Ok(())
    }

    fn bytes(&self, drawing: &Drawing) -> Result<Vec<u8>, magician_sim::world::PictureError> {
        match self.format {
            Format::Svg => Ok(drawing.to_svg().into_bytes()),
            Format::Png => drawing.to_png(PIXELS_PER_MM),
        }
    }
}
