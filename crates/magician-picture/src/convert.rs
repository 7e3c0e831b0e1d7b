//! Conversion of plans to other kinds of files.

use magician_host::Result as HostResult;
use magician_program::formats::playback::Playback;
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Diagnostic, DiagnosticCode, Plan, point_list};
use magician_sim::world::Drawing;

use crate::{DrawingOptions, drawing_svg};

/// Resolution of a PNG, pixels per mm; about 200 dots per inch.
#[cfg(feature = "png")]
const PIXELS_PER_MM: f64 = 8.0;

/// Target of a conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Conversion {
    /// Our own plan file.
    Plan,
    /// A Teaching & Playback file of DobotStudio.
    Playback,
    /// The lines that the plan leaves, as SVG.
    Svg,
    /// The lines that the plan leaves, as PNG.
    Png,
    /// List of points.
    Points,
}

/// Reason why a plan cannot be converted.
#[derive(Debug)]
#[non_exhaustive]
pub enum ConversionError {
    /// The format cannot express it.
    Refused(Diagnostic),
    /// The picture would be empty, because everything drawn is out of reach.
    OutOfReach,
    /// The picture would be empty, because the plan draws and burns nothing.
    DrawsNothing,
    /// Rehearsing the plan failed.
    Rehearsal(magician_host::Error),
}

impl Conversion {
    /// Chooses the conversion by the extension of a file name: `.plan.json` (or `.json`, `.plan`),
    /// `.playback` (or `.xml`), `.svg`, `.png`, `.csv`. `None` for other names.
    ///
    /// ```
    /// use magician_picture::Conversion;
    ///
    /// assert_eq!(Conversion::of("pick.plan.json"), Some(Conversion::Plan));
    /// assert_eq!(Conversion::of("house.SVG"), Some(Conversion::Svg));
    /// assert_eq!(Conversion::of("house.dxf"), None);
    /// ```
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        let (stem, end) = name.rsplit_once('.')?;
        if stem.is_empty() || stem.ends_with(['/', '\\']) || end.contains(['/', '\\']) {
            return None;
        }
        match end.to_ascii_lowercase().as_str() {
            "json" | "plan" => Some(Self::Plan),
            "playback" | "xml" => Some(Self::Playback),
            "svg" => Some(Self::Svg),
            "png" => Some(Self::Png),
            "csv" => Some(Self::Points),
            _ => None,
        }
    }

    /// Returns the file, and notes about what it cannot express.
    ///
    /// # Errors
    /// A [`ConversionError`] if the format cannot express the plan at all, or the picture would be
    /// empty.
    pub fn file(self, plan: &Plan) -> Result<(Vec<u8>, Vec<Diagnostic>), ConversionError> {
        let lost = |what: &str| vec![Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut)];
        match self {
            Self::Plan => Ok((plan.to_json().into_bytes(), Vec::new())),
            Self::Playback => {
                let playback = Playback::from_plan(plan).map_err(ConversionError::Refused)?;
                Ok((playback.to_xml().into_bytes(), playback.notes().to_vec()))
            }
            Self::Points => {
                let lost = lost("a list of points has no speeds, tool or settings");
                Ok((point_list(plan).into_bytes(), lost))
            }
            Self::Svg | Self::Png => {
                let done: HostResult<_> = rehearse(plan, &RehearseOptions::default());
                let drawing = done.map_err(ConversionError::Rehearsal)?.drawing;
                if drawing.is_empty() {
                    return Err(if plan.steps.iter().any(|step| step.action.marks()) {
                        ConversionError::OutOfReach
                    } else {
                        ConversionError::DrawsNothing
                    });
                }
                let bytes = match self {
                    Self::Png => png(&drawing).map_err(ConversionError::Refused)?,
                    _ => svg(&drawing).into_bytes(),
                };
                let lost = lost(
                    "a picture has only the lines that are drawn: no speeds, no travel between them",
                );
                Ok((bytes, lost))
            }
        }
    }
}

fn svg(drawing: &Drawing) -> String {
    drawing_svg(drawing, &DrawingOptions::default())
}

#[cfg(feature = "png")]
fn png(drawing: &Drawing) -> Result<Vec<u8>, Diagnostic> {
    use crate::{PictureError, drawing_png, fitting};

    // A drawing along a rail, for instance, is too large at full resolution.
    let too_large = |error: &_| matches!(error, PictureError::Size(_));
    let made = fitting(PIXELS_PER_MM, too_large, |scale| {
        drawing_png(drawing, scale, &DrawingOptions::default())
    });
    made.map_err(|error| Diagnostic::of_file(error.to_string()))
}

#[cfg(not(feature = "png"))]
fn png(_: &Drawing) -> Result<Vec<u8>, Diagnostic> {
    let message = "this build cannot write PNG files: it lacks the feature png of magician-picture";
    Err(Diagnostic::of_file(message))
}

#[cfg(all(test, not(feature = "png")))]
mod tests {
    use super::*;

    #[test]
    fn png_in_a_build_without_pixels_is_refused_with_the_feature_that_it_lacks() {
        let refused = png(&Drawing::default()).unwrap_err();
        assert!(
            refused.message.contains("lacks the feature png"),
            "{refused}"
        );
    }
}
