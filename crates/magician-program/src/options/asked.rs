//! What a person is asked before a file of a format is done: the options that are seldom left out.

use serde::Serialize;

use super::SetupOptions;
use crate::Format;
use crate::fill::FillMode;
use crate::lettering::BundledFont;
use crate::raster::ImageStyle;

/// An option that a person is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct AskedOption {
    /// The member of [`SetupOptions`].
    pub name: &'static str,
    /// What it is: `choice`, `number`, `point` (x and y) or `switch`.
    pub kind: &'static str,
    /// `mm`, `deg`, or nothing.
    pub unit: &'static str,
    /// What may be chosen; the first one unless a person chooses.
    pub choices: &'static [&'static str],
    /// The switch with which alone it is asked; without one it is asked always.
    pub with: Option<&'static str>,
    /// What it is for.
    pub about: &'static str,
}

const fn asked(
    name: &'static str,
    kind: &'static str,
    unit: &'static str,
    about: &'static str,
) -> AskedOption {
    AskedOption {
        name,
        kind,
        unit,
        choices: &[],
        with: None,
        about,
    }
}

const TOOL: AskedOption = AskedOption {
    choices: &["pen", "laser"],
    ..asked("tool", "choice", "", "Tool on the arm")
};
const SURFACE: AskedOption = asked("surface", "number", "mm", "Height of the work surface");
const AT: AskedOption = asked("at", "point", "mm", "Where its centre goes");
const WIDTH: AskedOption = asked("width", "number", "mm", "How wide it becomes");
const IMAGE: AskedOption = AskedOption {
    choices: ImageStyle::NAMES,
    ..asked("image", "choice", "", "What the pen makes of an image")
};
const SCALE: AskedOption = asked("scale", "number", "", "Its size, 1 being the true one");
const ROTATE: AskedOption = asked("rotate", "number", "deg", "Turned counter-clockwise");
const FILL: AskedOption = AskedOption {
    choices: FillMode::NAMES,
    ..asked("fill", "choice", "", "Lines that shapes are filled with")
};
const FONT: AskedOption = AskedOption {
    choices: BundledFont::NAMES,
    ..asked("font", "choice", "", "Font of text")
};
const SIZE: AskedOption = asked("size", "number", "mm", "Height of a capital");
const WRAP: AskedOption = asked("wrap", "number", "mm", "Width that lines are broken at");
const FIT: AskedOption = asked("fit", "switch", "", "Made smaller until it can be reached");
const PLACE: AskedOption = asked(
    "place",
    "switch",
    "",
    "A file of coordinates is placed like a drawing",
);

const fn placed(option: AskedOption) -> AskedOption {
    AskedOption {
        with: Some("place"),
        ..option
    }
}

const PLACED: [AskedOption; 6] = [
    PLACE,
    placed(TOOL),
    placed(SURFACE),
    placed(AT),
    placed(SCALE),
    placed(ROTATE),
];

impl SetupOptions {
    /// What a person is asked before a file of this format is done: nothing where the file says it all.
    ///
    /// ```
    /// use magician_program::{Format, SetupOptions};
    ///
    /// let names = |format| SetupOptions::asked(format).iter().map(|option| option.name).collect::<Vec<_>>();
    /// assert_eq!(names(Format::Image), ["tool", "image", "surface", "at", "width", "rotate", "fit"]);
    /// assert!(names(Format::Playback).is_empty());
    /// ```
    #[must_use]
    pub const fn asked(format: Format) -> &'static [AskedOption] {
        match format {
            Format::Svg => &[TOOL, FILL, SURFACE, AT, SCALE, ROTATE, FIT],
            Format::Dxf | Format::Hpgl => &[TOOL, SURFACE, AT, SCALE, ROTATE, FIT],
            Format::Image => &[TOOL, IMAGE, SURFACE, AT, WIDTH, ROTATE, FIT],
            Format::Text => &[FONT, SIZE, WRAP, TOOL, SURFACE, AT, ROTATE, FIT],
            Format::TestGrid => &[SURFACE, AT, SCALE, ROTATE, FIT],
            Format::Gcode => &PLACED,
            Format::Playback | Format::Blockly | Format::Points | Format::Plan => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_an_option_of_its_kind() {
        let options = SetupOptions::keys();
        for format in Format::ALL {
            for option in SetupOptions::asked(format) {
                assert!(options.iter().any(|key| key == option.name), "{option:?}");
                let value = match option.kind {
                    "choice" => serde_json::json!(option.choices[0]),
                    "number" => serde_json::json!(1.5),
                    "point" => serde_json::json!([200, 0]),
                    kind => serde_json::json!(kind == "switch"),
                };
                let fields = serde_json::Map::from_iter([(option.name.to_owned(), value)]);
                assert!(SetupOptions::from_fields(&fields).is_ok(), "{option:?}");
            }
        }
    }
}
