//! The files people have, each read by a module of its own.

mod blockly;
mod dxf;
mod flaw;
mod gcode;
mod hpgl;
mod image;
mod kind;
pub mod playback;
mod points;
pub(crate) mod svg;
mod xml;

pub use gcode::{Arcs, Dialect, GcodeOptions};

use crate::plan::file;
use crate::raster::Raster;
use crate::{Artwork, Plan, Problem};

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Our own plan file.
    Plan,
    /// DobotStudio's Teaching & Playback.
    Playback,
    /// G-code of pens and lasers.
    Gcode,
    /// SVG drawings.
    Svg,
    /// HPGL plots.
    Hpgl,
    /// DXF drawings.
    Dxf,
    /// DobotBlockly workspaces.
    Blockly,
    /// PNG, JPEG and BMP images.
    Image,
    /// Lists of points: CSV, JSON, text.
    Points,
}

/// How a file is read, where it leaves a choice.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ReadOptions {
    /// What it is called in what is made of it; the file's name without its ending, as a rule.
    pub title: String,
    /// How far a line may be from the curve that it stands for, mm.
    pub tolerance: f64,
    /// What G-code leaves open.
    pub gcode: GcodeOptions,
    /// What becomes of filled shapes that have no line of their own.
    pub fills: Fills,
}

/// What becomes of filled shapes without a line in a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Fills {
    /// Their edge is drawn.
    #[default]
    Outline,
    /// They are left out.
    Ignore,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            title: String::new(),
            tolerance: 0.05,
            gcode: GcodeOptions::default(),
            fills: Fills::default(),
        }
    }
}

/// What was in a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Content {
    /// What the arm is to do, in its own coordinates.
    Plan(Plan),
    /// Lines on a sheet, to be placed before the arm.
    Artwork(Artwork),
    /// An image, to be engraved or traced.
    Image(Raster),
}

/// A file that was understood.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading<T = Content> {
    /// What was in it.
    pub content: T,
    /// What was left out or taken in a certain way; nothing of it is an error.
    pub notes: Vec<Problem>,
}

/// Reads a file of this format.
///
/// # Errors
/// The first [`Problem`] that makes it unreadable, with its place.
pub fn read(format: Format, bytes: &[u8], options: &ReadOptions) -> Result<Reading, Problem> {
    match format {
        Format::Plan => file::read(bytes, options).map(Reading::of_plan),
        Format::Playback => playback::read(bytes, options),
        Format::Gcode => gcode::read(bytes, options),
        Format::Svg => svg::read(bytes, options),
        Format::Hpgl => hpgl::read(bytes, options),
        Format::Dxf => dxf::read(bytes, options),
        Format::Blockly => blockly::read(bytes, options),
        Format::Image => image::read(bytes, options),
        Format::Points => points::read(bytes, options),
    }
}

impl Reading {
    fn of_plan(read: Reading<Plan>) -> Self {
        Self {
            content: Content::Plan(read.content),
            notes: read.notes,
        }
    }
}
