//! A plan as another kind of file.

use std::fmt::Write as _;

use magician_host::Result as HostResult;
use magician_protocol::Set;
use magician_protocol::commands::{PtpCmd, PtpWithLCmd};
use magician_sim::world::{Drawing, PictureOptions};

#[cfg(not(feature = "picture"))]
use crate::Missing;
use crate::formats::playback::Playback;
use crate::rehearse::{RehearseOptions, rehearse};
use crate::{Action, Diagnostic, DiagnosticCode, Plan, Travel};

/// Resolution of a PNG: about 200 dots an inch.
#[cfg(feature = "picture")]
const PIXELS_PER_MM: f64 = 8.0;

/// What a plan becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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
    /// use magician_program::Conversion;
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
                Ok((points(plan).into_bytes(), lost))
            }
            Self::Svg | Self::Png => {
                let done: HostResult<_> = rehearse(plan, &RehearseOptions::default());
                let drawing = done.map_err(ConversionError::Rehearsal)?.drawing;
                if drawing.is_empty() {
                    return Err(match plan.steps.iter().any(|step| step.action.marks()) {
                        true => ConversionError::OutOfReach,
                        false => ConversionError::DrawsNothing,
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
    drawing.to_svg_with(&PictureOptions::default())
}

#[cfg(feature = "picture")]
fn png(drawing: &Drawing) -> Result<Vec<u8>, Diagnostic> {
    use magician_sim::world::PictureError;

    // One along a rail, for instance.
    let too_large = |error: &_| matches!(error, PictureError::Size { .. });
    let made = crate::preview::fitting(PIXELS_PER_MM, too_large, |scale| {
        drawing.to_png_with(scale, &PictureOptions::default())
    });
    made.map_err(|error| Diagnostic::of_file(error.to_string()))
}

#[cfg(not(feature = "picture"))]
fn png(_: &Drawing) -> Result<Vec<u8>, Diagnostic> {
    let message =
        "this build cannot write PNG files: it lacks the feature picture of magician-program";
    Err(Diagnostic::of_file(message).with_missing(Some(Missing::Feature("picture"))))
}

/// Each step with the point that it leads to.
fn points(plan: &Plan) -> String {
    // A program that moves along a rail has a column for its positions.
    let on_rail = plan.uses_rail();
    let mut text = "step,action,x,y,z,r,line,name".to_owned();
    text.push_str(if on_rail { ",l\n" } else { "\n" });
    for (nth, step) in plan.steps.iter().enumerate() {
        let rail = without_rail(&step.action);
        let (action, l) = match &rail {
            Some((action, l)) => (action, l.to_string()),
            None => (&step.action, String::new()),
        };
        let point = action
            .target()
            .map(|point| point.map(|value| value.to_string()));
        let [x, y, z] = point.unwrap_or_default();
        let r = match action {
            Action::Move { to: [.., r], .. } | Action::Arc { to: [.., r], .. } => r.to_string(),
            _ => String::new(),
        };
        let line = match step.origin.line {
            0 => String::new(),
            line => line.to_string(),
        };
        let name = plan.name_of(&step.origin).map(quoted).unwrap_or_default();
        let word = word(action);
        // Writing to a string cannot fail.
        let _ = write!(text, "{},{word},{x},{y},{z},{r},{line},{name}", nth + 1);
        if on_rail {
            let _ = write!(text, ",{l}");
        }
        text.push('\n');
    }
    text
}

/// A move that takes the rail along as the same move without it, and the position on the rail.
fn without_rail(action: &Action) -> Option<(Action, f32)> {
    let Action::Command(command) = action else {
        return None;
    };
    let Set::PtpWithLCmd(ptp) = **command else {
        return None;
    };
    let PtpWithLCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
        l,
    } = ptp;
    let alone = PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    };
    Some((Action::from(Set::from(alone)), l))
}

fn word(action: &Action) -> &'static str {
    match action {
        Action::Move { by, .. } => match by {
            Travel::Joints => "movj",
            Travel::Line => "movl",
            Travel::Jump => "jump",
        },
        Action::Joints { .. } => "joints",
        Action::Shift { .. } => "shift",
        Action::Arc { .. } => "arc",
        Action::Path { .. } => "path",
        Action::Burn { .. } => "burn",
        Action::Suction(_) => "suction",
        Action::Gripper(_) => "gripper",
        Action::Laser(_) => "laser",
        Action::Wait(_) => "wait",
        Action::Home => "home",
        Action::Command(command) => command.row().set_name,
        Action::Part(_) | Action::Pause(_) => action.name(),
    }
}

/// As CSV has a text with anything in it.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
