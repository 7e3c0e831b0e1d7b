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
//! Files are read by the crate `magician-formats`, whose values are here, too. Without features
//! there is all that plans need: reading and writing their own files, placing, checking, rehearsals,
//! resuming. Pictures of plans are those of the crate `magician-picture`; what they show is
//! [`toolpath`]. `readers` alone is on by default.
//!
//! | feature | what it adds |
//! |---|---|
//! | `readers` | every reader of files; features of `magician-formats` choose some of them |
//! | `system-fonts` | the installed fonts that texts in SVG name |
//!
//! Lengths are mm, angles degrees, times seconds. A [`Plan`]'s coordinates are the arm's; an [`Artwork`]'s are those of its
//! sheet: x to the right, y up, from the lower left corner.
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
pub mod turns;
pub mod wire;

pub use check::{
    DoubtfulSteps, PartFigures, RefusedStep, Report, check, foreign_coordinates, would_do_at,
    would_fit, would_fit_turned,
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
