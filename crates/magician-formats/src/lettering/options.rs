//! Options for text layout.

use super::FontChoice;

use crate::keywords::keywords;

/// Options for text layout. Lengths are in mm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TextOptions {
    /// Font.
    pub font: FontChoice,
    /// Height of a capital.
    pub size: f64,
    /// Width at which lines are wrapped; `None` for no wrapping.
    pub wrap: Option<f64>,
    /// Alignment of lines.
    pub align: Align,
    /// Distance of baselines, in heights of a capital.
    pub line_height: f64,
}

impl Default for TextOptions {
    /// The bundled sans font, 10 mm high, left-aligned, not wrapped.
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

/// Alignment within the wrap width, or within the longest line without wrapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Align {
    /// Left-aligned.
    #[default]
    Left,
    /// Centred.
    Center,
    /// Right-aligned.
    Right,
}

keywords! {
    Align, "align":
    Left = "left",
    Center = "center",
    Right = "right",
}
