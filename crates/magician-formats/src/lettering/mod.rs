//! Text in lines: fonts and layout.
//!
//! A font returns a `Glyph` per character: its polylines, and the distance to the next character.
//! Three single-line fonts are bundled (`hershey`). They have only ASCII; accented letters are
//! composed (`compose`), and other missing letters and signs are drawn (`drawn`). Further fonts
//! come from files (`files`).

mod choice;
#[cfg(feature = "lettering")]
mod compose;
#[cfg(feature = "lettering")]
mod drawn;
#[cfg(feature = "font-files")]
mod files;
#[cfg(feature = "lettering")]
mod glyph;
#[cfg(feature = "lettering")]
mod hershey;
#[cfg(feature = "lettering")]
mod layout;
#[cfg(feature = "lettering")]
mod loaded;
#[cfg(feature = "lettering")]
mod marks;
mod options;
#[cfg(any(feature = "font-files", feature = "drawings"))]
mod outlines;
#[cfg(feature = "lettering")]
mod placed;
#[cfg(any(feature = "font-files", feature = "drawings"))]
mod svg_font;

pub use choice::{BundledFont, FontChoice, FontKind};
pub use options::{Align, TextOptions};

#[cfg(feature = "lettering")]
pub(crate) use {
    glyph::Glyph,
    layout::{LaidText, lay_out},
    loaded::LoadedFont,
    placed::lacks,
};

#[cfg(feature = "drawings")]
pub(crate) use placed::Lettering;

#[cfg(feature = "drawings")]
pub(crate) use {outlines::cap_height, svg_font::SvgFont};

#[cfg(feature = "lettering")]
/// A source of glyphs.
pub(crate) trait Glyphs {
    /// Height of a capital H, in units of the font.
    fn cap_height(&self) -> f64;

    /// Returns the glyph of a character with its curves flattened to a tolerance, both in units of
    /// the font. `None` if the font lacks the character.
    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph>;

    /// True if the lines are outlines of letters, which can be filled.
    fn is_outlined(&self) -> bool {
        false
    }

    /// True if the order of the lines must be kept.
    fn has_stroke_order(&self) -> bool {
        false
    }
}
