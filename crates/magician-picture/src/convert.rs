//! A plan as another kind of file.

use magician_host::Result as HostResult;
use magician_program::formats::playback::Playback;
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Diagnostic, DiagnosticCode, Plan, point_list};
use magician_sim::world::Drawing;

use crate::{DrawingOptions, drawing_svg};

/// Resolution of a PNG: about 200 dots an inch.
#[cfg(feature = "png")]
const PIXELS_PER_MM: f64 = 8.0;

/// What a plan becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Conversion {
    /// Our own plan file.
    Plan,
    /// A Teaching & Playback file of DobotStudio.
    Playback,
    /// The lines that it leaves, as SVG.
    Svg,
    /// The same as PNG.
    Png,
    /// A list of points.
    Points,
}

/// Why a plan does not become a file.
#[derive(Debug)]
#[non_exhaustive]
pub enum ConversionError {
    /// The format cannot say it.
    Refused(Diagnostic),
    /// A picture would be empty: nothing of what it draws is within reach.
    OutOfReach,
    /// A picture would be empty: it draws and burns nothing.
    DrawsNothing,
    /// It cannot be rehearsed.
    Rehearsal(magician_host::Error),
}

impl Conversion {
    /// By the ending of a file's name: `.plan.json` (or `.json`, `.plan`), `.playback` (or `.xml`), `.svg`, `.png`, `.csv`.
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

    /// The file, and what it cannot say.
    ///
    /// # Errors
    /// What cannot be said in this format at all.
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

    // One along a rail, for instance.
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
