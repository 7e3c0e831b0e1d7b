//! What a person is asked before a file of a format is done: the options that are seldom left out, and all the others.

mod table;

pub(super) use table::{OF_WORK, OfWork};

use serde::Serialize;

use super::SetupOptions;
use crate::Format;

/// What an option is, for a form.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AskedOption {
    /// The member of [`SetupOptions`].
    pub name: &'static str,
    /// What it is.
    pub kind: AskedKind,
    /// `mm`, `mm/s`, `deg`, `%`, `px`, or nothing.
    pub unit: &'static str,
    /// What may be chosen.
    pub choices: &'static [&'static str],
    /// What holds where it is not given, if that does not depend on something else.
    pub default: Option<DefaultValue>,
    /// The least number.
    pub least: Option<f64>,
    /// The number that it is above.
    pub above: Option<f64>,
    /// The greatest number.
    pub most: Option<f64>,
    /// The option with which alone it counts; without one it counts always. `work` is not asked: the
    /// tool decides it where it is not given, the laser engraves and every other tool draws.
    pub with: Option<&'static str>,
    /// The values of that option with which this one counts; if there are none, that one must be on.
    pub when: &'static [&'static str],
    /// What it belongs to.
    pub group: AskedGroup,
    /// Whether it is seldom left out.
    pub usual: bool,
    /// What it is for.
    pub about: &'static str,
}

/// What the value of an option is, and how JSON has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum AskedKind {
    /// One of a few words.
    Choice,
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// x and y: an array of two numbers.
    Point,
    /// x, y and z: an array of three numbers.
    Place,
    /// From the left, from the top, width and height: an array of four whole numbers.
    Area,
    /// True or false.
    Switch,
    /// Text.
    Text,
    /// An array of texts.
    List,
    /// An array of objects as [`PenOptions`](super::PenOptions).
    Pens,
}

impl AskedKind {
    /// All of them, by their names in interfaces.
    pub const NAMES: [&'static str; 10] = [
        "choice", "number", "integer", "point", "place", "area", "switch", "text", "list", "pens",
    ];
}

/// What an option belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum AskedGroup {
    /// With which tool, where, how large.
    Place,
    /// How shapes are filled.
    Fill,
    /// How text is set.
    Text,
    /// Which parts there are, and which are drawn.
    Parts,
    /// What is made of an image.
    Image,
    /// How it is burnt.
    Laser,
    /// How the pen goes.
    Pen,
    /// The rest.
    More,
}

impl AskedGroup {
    /// All of them, by their names in interfaces.
    pub const NAMES: [&'static str; 8] = [
        "place", "fill", "text", "parts", "image", "laser", "pen", "more",
    ];
}

/// The value of an option that is not given.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum DefaultValue {
    /// A number.
    Number(f64),
    /// One of the choices.
    Word(&'static str),
    /// On or off.
    Switch(bool),
}

impl SetupOptions {
    /// The options that count for a file of this format, those that are seldom left out first.
    ///
    /// ```
    /// use magician_program::{Format, SetupOptions};
    ///
    /// let all = SetupOptions::all_asked(Format::Svg);
    /// let inset = all.iter().find(|option| option.name == "fill_inset").unwrap();
    /// assert_eq!((inset.with, inset.least), (Some("fill"), Some(0.0)));
    /// assert!(all.len() > 30);
    /// ```
    #[must_use]
    pub fn all_asked(format: Format) -> Vec<AskedOption> {
        table::of(format)
    }

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
    pub fn asked(format: Format) -> Vec<AskedOption> {
        let mut all = Self::all_asked(format);
        all.retain(|option| option.usual);
        all
    }
}

#[cfg(test)]
mod tests;
