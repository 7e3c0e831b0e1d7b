//! File formats for a Dobot Magician arm: from the bytes of a file to what is to be drawn, engraved
//! or played.
//!
//! ```text
//! bytes --read--> Plan       playback, G-code, Blockly, points, our own plan files
//!            \--> Artwork    SVG, HPGL, DXF, text: lines and areas on a sheet
//!             \-> Raster     images: grey cells
//! ```
//!
//! * [`read`](fn@read) parses a file of any [`Format`]. Each step and stroke of the content knows
//!   its place in the file ([`Origin`]). Whatever was left out becomes a note; a file that cannot
//!   be read is a [`Diagnostic`] with its place. No input panics.
//! * [`Plan`], [`Artwork`] and `Raster` are plain values. A [`Plan`] has its own file format and
//!   can be moved, scaled, rotated and repeated. An [`Artwork`] can be ordered, filled and placed
//!   in front of the arm ([`artwork`], [`fill`], [`Reach`]).
//! * [`lettering`] sets text in lines.
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
//! Every [`Format`] exists in every build. Reading one whose feature is absent returns a
//! [`Diagnostic`] that names the feature in [`missing`](Diagnostic::missing). Plans can always be
//! read and written, playback can always be written.
//!
//! This crate knows nothing of the arm's state. The crate `magician-program` decides what the arm
//! does with the content (options, checks, programs).
//!
//! Lengths are in mm, angles in degrees, times in seconds. A [`Plan`] uses the arm's coordinates.
//! An [`Artwork`] uses those of its sheet: x to the right, y up, from the lower left corner.
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
#[cfg(any(feature = "drawings", feature = "font-files"))]
mod gzip;
pub mod keywords;
pub mod lettering;
mod origin;
mod plan;
mod power;
pub mod raster;
pub mod reach;
mod recording;
pub mod simplify;
mod surface;
mod testgrid;

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

/// Compiles the example of the README with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
