//! Files that people draw, teach and engrave with a Dobot Magician arm, from their bytes to their
//! content.
//!
//! ```text
//! bytes --read--> Plan       playback, G-code, Blockly, points, our own plan files
//!            \--> Artwork    SVG, HPGL, DXF, text: lines and areas on a sheet
//!             \-> Raster     images: grey cells
//! ```
//!
//! * [`read`](fn@read) takes the bytes of a file of any [`Format`]; its content says where in the
//!   file each step and stroke came from ([`Origin`]). What was left out is a note, what cannot be
//!   read a [`Diagnostic`] with its place. No bytes panic.
//! * [`Plan`], [`Artwork`] and `Raster` are values: [`Plan`] has a file format of our own, and is
//!   moved, scaled, rotated and repeated; [`Artwork`] is put in order, filled and laid before the
//!   arm ([`artwork`], [`fill`], [`Reach`]).
//! * [`lettering`] sets text as lines.
//!
//! | feature | what it reads |
//! |---|---|
//! | `drawings` | SVG, DXF and HPGL, with the texts in them |
//! | `programs` | G-code, Teaching & Playback, DobotBlockly, lists of points and recordings |
//! | `lettering` | text to be written, in three single-line fonts; test grids of the laser |
//! | `font-files` | fonts for such text: SVG fonts, TrueType and OpenType, orders of strokes |
//! | `images` | PNG, JPEG, BMP, WebP, GIF, TIFF and netpbm |
//! | `system-fonts` | the installed fonts that texts in SVG name; not on by default |
//!
//! A [`Format`] that is not built in is known all the same; reading it is a [`Diagnostic`] that
//! [`missing`](Diagnostic::missing) its feature. Plans are always read and written, playback is
//! always written.
//!
//! What becomes of a file on an arm (options, checks, programs) is decided in the crate
//! `magician-program`.
//!
//! Lengths are mm, angles degrees, times seconds. A [`Plan`]'s coordinates are the arm's; an
//! [`Artwork`]'s are those of its sheet: x to the right, y up, from the lower left corner.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod artwork;
mod calibrate;
#[cfg(any(feature = "drawings", feature = "font-files"))]
mod curves;
mod diagnostic;
mod encoding;
pub mod fill;
#[cfg(feature = "drawings")]
mod font;
pub mod formats;
pub mod lettering;
mod origin;
#[cfg(any(feature = "drawings", feature = "font-files"))]
mod packed;
mod plan;
mod power;
pub mod raster;
pub mod reach;
mod recording;
pub mod simplify;
mod surface;
mod testgrid;
pub mod words;

pub use artwork::{Artwork, FilledArea, Stroke, WouldFit};
pub use calibrate::{
    FittedSurface, SheetCorner, Tip, TouchedCorners, rounded_height, rounded_surface,
};
pub use diagnostic::{Diagnostic, DiagnosticCode, Missing};
pub use encoding::source_text;
#[cfg(feature = "drawings")]
#[doc(hidden)]
pub use font::svg_options;
pub use formats::foreign;
pub use formats::{
    Content, Curves, Fills, Format, Parsed, ReadOptions, SystemFonts, TextLines, White, read,
};
pub use lettering::{Align, BundledFont, FontChoice, FontKind, TextOptions};
pub use origin::{Lines, Origin};
pub use plan::{
    Action, Color, Grip, PLAN_SCHEMA, Pallet, Part, Pause, PauseCause, Plan, Step, Tool, Travel,
};
pub use power::Power;
pub use raster::Raster;
pub use reach::{Fit, Reach, SheetTransform};
pub use recording::{CaptureMode, PoseReading, Recording};
pub use surface::Surface;
pub use testgrid::{Series, TestCell, TestGrid, TestGridOptions};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
