//! What people draw, teach and engrave with a Dobot Magician arm, as plans that are checked before anything moves.
//!
//! One way for all of it:
//!
//! ```text
//! file --read--> Plan                        playback, G-code, Blockly, points, our own plan files
//!           \--> Artwork --place, mark--> Plan   SVG, HPGL, DXF: lines on a sheet
//!            \-> Raster --engrave--> Plan        images: grey that becomes laser power
//! Plan --check--> Report     every refused_step with its line, column or element
//!      --Program, RemainingProgram--> Arm::start   from any step on, in iterations, with the time that is left
//! ```
//!
//! * [`read`](fn@read) takes the bytes of a file of any [`Format`]; what it gives says where in the file each step came from.
//! * [`Plan`] is a value: kept in a file of our own, compared, moved, scaled, rotated, repeated.
//! * [`PrepareRequest`] is the whole way: a file, options, what settings and the arm say, and where it begins; its
//!   [`PreparedProgram`] is what every door checks, shows and runs.
//! * [`check`](fn@check) follows a plan as the arm would and tells what is out of reach, how long it takes, how far the tool
//!   travels.
//!
//! Without features there is all that plans need: reading and writing their own files, placing, checking, rehearsals, resuming. The others build in what needs more; `default` is all of them.
//!
//! | feature | what it adds |
//! |---|---|
//! | `read` | all of `read-*` |
//! | `read-playback`, `read-blockly` | Teaching & Playback and DobotBlockly workspaces; playback files are written without it |
//! | `read-gcode`, `read-hpgl`, `read-dxf`, `read-svg` | drawings, and programs of plotters, pens and lasers |
//! | `read-points` | lists of points and recordings: CSV, JSON, text, MCAP |
//! | `read-text` | text to be written, in three single-line fonts; test grids of the laser |
//! | `font-files` | text in fonts of files: SVG fonts, TrueType and OpenType, orders of strokes |
//! | `text` | the font that texts in SVG are written with |
//! | `image` | PNG, JPEG, BMP, WebP, GIF and TIFF images, to be engraved or traced |
//!
//! Pictures of plans are those of the crate `magician-picture`; what they show is [`toolpath`].
//!
//! A [`Format`] that is not built in is known all the same; reading it is a [`Diagnostic`] that [`missing`](Diagnostic::missing) its feature.
//!
//! Lengths are mm, angles degrees, times seconds. A [`Plan`]'s coordinates are the arm's; an [`Artwork`]'s are those of its
//! sheet: x to the right, y up, from the lower left corner.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod artwork;
mod calibrate;
mod check;
#[cfg(any(feature = "read-svg", feature = "font-files"))]
mod curves;
mod diagnostic;
mod encoding;
mod ending;
pub mod fill;
#[cfg(all(feature = "text", feature = "read-svg"))]
mod font;
pub mod formats;
mod frame;
pub mod lettering;
mod options;
mod origin;
mod pace;
#[cfg(any(feature = "read-svg", feature = "font-files"))]
mod packed;
mod paper;
mod plan;
mod point_list;
mod power;
mod prepare;
mod program;
pub mod raster;
mod reach;
mod recording;
pub mod rehearse;
pub mod resume;
mod setup;
mod simplify;
mod surface;
mod testgrid;
pub mod toolpath;
pub mod turns;
pub mod wire;
mod words;

pub use artwork::{Artwork, FilledArea, Stroke, WouldFit};
pub use calibrate::{Tip, rounded_height};
pub use check::{
    DoubtfulSteps, PartFigures, RefusedStep, Report, check, foreign_coordinates, would_do_at,
    would_fit, would_fit_turned,
};
pub use diagnostic::{Diagnostic, DiagnosticCode, Missing};
pub use encoding::source_text;
pub use ending::Ending;
#[cfg(all(feature = "text", feature = "read-svg"))]
#[doc(hidden)]
pub use font::svg_options;
pub use formats::foreign;
pub use formats::{
    Content, Curves, Fills, Format, Parsed, ReadOptions, SystemFonts, TextLines, White, read,
};
pub use frame::{FrameShape, Framing};
pub use lettering::{Align, BundledFont, FontChoice, FontKind, TextOptions};
pub use options::{
    DefaultValue, Grid, ModeOption, Need, OptionError, OptionGroup, OptionKind, OptionSpec,
    PenMatch, PenOptions, SetupDefaults, SetupOptions, WorkOption,
};
pub use origin::{Lines, Origin};
pub use paper::Paper;
pub use plan::{
    Action, Color, Continuation, Grip, PLAN_SCHEMA, Pallet, Part, Pause, PauseCause, Plan, Step,
    Tool, Travel,
};
pub use point_list::point_list;
pub use power::Power;
pub use prepare::{
    OpenedFile, Preparation, PrepareError, PrepareRequest, PrepareStage, PreparedProgram,
    StartPosition,
};
pub use program::{BurnPlace, Program, RemainingProgram, StepNumbering, Timetable};
pub use raster::Raster;
pub use reach::{Fit, Reach, SheetTransform};
pub use recording::{CaptureMode, PoseReading, Recording};
pub use setup::{
    AppliedPlacement, Depths, Frame, Page, PartMatch, PartMode, PartRule, PartSummary, Placement,
    Prepared, Setup, Side, Work, tip,
};
pub use surface::Surface;
pub use testgrid::{Series, TestCell, TestGrid, TestGridOptions};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
