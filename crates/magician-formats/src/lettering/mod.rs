//! Text as lines: fonts, and how text is laid out with them.
//!
//! A font gives for a character the lines of its `Glyph` and how far the next one is. Three single-line fonts are built in
//! (`hershey`); their accents and the letters that they lack are composed (`compose`, `drawn`).

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
/// What gives the glyphs of a font.
pub(crate) trait Glyphs {
    /// How high a capital H is, in the font's units.
    fn cap_height(&self) -> f64;

    /// The glyph of a character, its curves followed within a tolerance, both in the font's units; none if the font does not have
    /// it.
    fn glyph(&self, character: char, tolerance: f64) -> Option<Glyph>;

    /// Whether its lines are the edges of its letters, which can be filled.
    fn is_outlined(&self) -> bool {
        false
    }

    /// Whether the order of its lines has a meaning.
    fn has_stroke_order(&self) -> bool {
        false
    }
}
