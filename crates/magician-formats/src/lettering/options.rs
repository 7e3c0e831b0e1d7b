//! How text is set.

use super::FontChoice;

use crate::words::words;

/// How text is set. Lengths are mm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TextOptions {
    /// With which font.
    pub font: FontChoice,
    /// Height of a capital.
    pub size: f64,
    /// The width that lines are broken at; they are not if none is given.
    pub wrap: Option<f64>,
    /// Where lines that are shorter than others lie.
    pub align: Align,
    /// From one baseline to the next, in heights of a capital.
    pub line_height: f64,
}

impl Default for TextOptions {
    /// Sans, 10 mm high.
    fn default() -> Self {
        Self {
            font: FontChoice::default(),
            size: 10.0,
            wrap: None,
            align: Align::default(),
            line_height: 1.8,
        }
    }
}

/// Where lines lie that are shorter than the width: that at which they are broken, else that of the longest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Align {
    /// They begin at the left.
    #[default]
    Left,
    /// Their middles lie below each other.
    Center,
    /// They end at the right.
    Right,
}

words! {
    Align, "align":
    Left = "left",
    Center = "center",
    Right = "right",
}
