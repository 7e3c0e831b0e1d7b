//! Programs for a Dobot Magician arm from drawings, images, G-code and taught points, as plans that
//! are checked before anything moves.
//!
//! All input takes one route:
//!
//! ```text
//! file --read--> Plan                        playback, G-code, Blockly, points, our own plan files
//!           \--> Artwork --place, mark--> Plan   SVG, HPGL, DXF: lines on a sheet
//!            \-> Raster --engrave--> Plan        images: grey that becomes laser power
//! Plan --check--> Report     every refused_step with its line, column or element
//!      --Program, RemainingProgram--> Arm::start   from any step on, in iterations, with the time that is left
//! ```
//!
//! * [`read`](fn@read) reads the bytes of a file of any [`Format`]. Each step knows where in the
//!   file it came from.
//! * [`Plan`] is a value: it can be stored in a plan file, compared, moved, scaled, rotated and
//!   repeated.
//! * [`PrepareRequest`] covers the whole route: file, options, settings, state of the arm, start
//!   step. Every front end checks, shows and runs the resulting [`PreparedProgram`].
//! * [`check`](fn@check) follows a plan as the arm would and reports refused steps, duration and
//!   lengths.
//!
//! The crate `magician-formats` reads files; its values are re-exported here. Without features this
//! crate has all that plans need: plan files, placement, check, rehearsal, resuming. The crate
//! `magician-picture` draws plans from their [`toolpath`]. Only `readers` is on by default.
//!
//! | feature | what it adds |
//! |---|---|
//! | `readers` | every reader of files; features of `magician-formats` choose some of them |
//! | `system-fonts` | the installed fonts that texts in SVG name |
//!
//! Lengths are mm, angles degrees, times seconds. The coordinates of a [`Plan`] are the arm's.
//! Those of an [`Artwork`] are its sheet's: x to the right, y up, from the lower left corner.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod check;
mod continuation;
mod ending;
mod frame;
mod options;
mod paper;
mod point_list;
mod prepare;
mod program;
pub mod raster;
pub mod rehearse;
pub mod resume;
mod setup;
pub mod toolpath;
pub mod wire;
pub mod yielding;

pub use check::{
    DoubtfulSteps, PartFigures, RefusedStep, Report, check, foreign_coordinates, would_fit,
    would_fit_at, would_fit_turned,
};
pub use continuation::Continuation;
pub use ending::Ending;
pub use frame::{FrameShape, Framing};
pub use magician_formats::{
    Action, Align, Artwork, BundledFont, CaptureMode, Color, Content, Curves, Diagnostic,
    DiagnosticCode, FilledArea, Fills, Fit, FittedSurface, FontChoice, FontKind, Format, Grip,
    Lines, Missing, Origin, PLAN_SCHEMA, Pallet, Parsed, Part, Pause, PauseCause, Plan,
    PoseReading, Power, Raster, Reach, ReadOptions, Recording, Series, SheetCorner, SheetTransform,
    Step, Stroke, Surface, SystemFonts, TestCell, TestGrid, TestGridOptions, TextLines,
    TextOptions, Tip, Tool, TouchedCorners, Travel, White, WouldFit, artwork, fill, foreign,
    formats, lettering, read, rounded_height, rounded_surface, source_text,
};
pub use options::{
    DefaultValue, Grid, ModeOption, Need, OptionError, OptionGroup, OptionKind, OptionSpec,
    PenMatch, PenOptions, SetupDefaults, SetupOptions, WorkOption,
};
pub use paper::Paper;
pub use point_list::point_list;
pub use prepare::{
    OpenedFile, Preparation, PrepareError, PrepareRequest, PrepareStage, PreparedProgram,
    StartPosition,
};
pub use program::{BurnPlace, Program, RemainingProgram, StepNumbering, Timetable};
pub use setup::{
    AppliedPlacement, Depths, Frame, Page, PartMatch, PartMode, PartRule, PartSummary, Placement,
    Prepared, Setup, Side, Work, tip,
};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
