//! Readers of file formats, one module each, and the options that they share.
//!
//! [`read`](fn@read) checks that the options suit the format, refuses files that are certainly of
//! another kind ([`foreign`](fn@foreign)), and calls the format's reader. A reader returns
//! [`Content`] and notes. To add a format, add a row to `kind.rs` and a directory here.

#[cfg(feature = "programs")]
mod blockly;
pub(crate) mod content;
mod curved;
#[cfg(feature = "drawings")]
mod dxf;
mod foreign;
#[cfg(feature = "programs")]
mod gcode;
mod gcode_options;
#[cfg(feature = "drawings")]
mod hpgl;
#[cfg(feature = "images")]
mod image;
mod kind;
#[cfg(any(feature = "programs", feature = "drawings"))]
mod notes;
#[cfg(feature = "lettering")]
mod plain_text;
pub mod playback;
#[cfg(feature = "programs")]
mod points;
mod rail;
#[cfg(any(feature = "programs", feature = "drawings"))]
mod span;
#[cfg(feature = "drawings")]
mod svg;
#[cfg(feature = "lettering")]
mod testgrid;
#[cfg(feature = "programs")]
mod xml;

pub(crate) use curved::Chords;
pub use curved::{CurvedFile, Curves};
pub use foreign::foreign;
pub use gcode_options::{Arcs, Dialect, GcodeOptions};

use magician_host::message;
use magician_host::{Remedy, Setting};

use crate::keywords::keywords;
use crate::lettering::TextOptions;
use crate::raster::Raster;
use crate::{Artwork, Diagnostic, DiagnosticCode, Plan, TestGrid};

/// Format of a file.
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
    /// PNG, JPEG, BMP, WebP, GIF, TIFF and netpbm images.
    Image,
    /// Lists of points and recordings: CSV, JSON, text, MCAP.
    Points,
    /// Plain text, to be written with the pen.
    Text,
    /// Test grids of the laser.
    TestGrid,
}

/// Options for reading a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Title of the content, usually the file's name without its extension.
    pub title: String,
    /// Largest distance of a chord from its curve, mm at the size drawn.
    pub tolerance: f64,
    /// Scale at which the content will be drawn, 1 being the true size, as far as the caller knows
    /// it. Code that places the content reads the file again ([`CurvedFile`]) if it is enlarged
    /// further.
    pub scale: f64,
    /// Options for G-code.
    pub gcode: GcodeOptions,
    /// Treatment of filled shapes.
    pub fills: Fills,
    /// Treatment of white in a drawing.
    pub white: White,
    /// True if everything beyond the page of a drawing is cut off.
    pub clip_page: bool,
    /// Tolerance for thinning a recording, mm; `None` keeps every point. The remaining points keep
    /// their times.
    pub resample: Option<f64>,
    /// Layout of plain text.
    pub text: TextOptions,
    /// Treatment of letters in the texts of drawings.
    pub text_lines: TextLines,
    /// Part of an image to keep: left, top, width, height, in pixels of the upright image. `None`
    /// keeps all of it.
    pub crop: Option<[u32; 4]>,
    /// Fonts for texts in drawings.
    pub system_fonts: SystemFonts,
    /// True if text with characters that the font lacks is refused. Otherwise these are left out
    /// with a note.
    pub strict_text: bool,
}

/// Treatment of filled shapes in a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fills {
    /// Draw the outline of a shape that has no stroke.
    #[default]
    Outline,
    /// Ignore fills.
    Ignore,
    /// Keep fills as [areas](Artwork::areas), even if the shape also has a stroke.
    Areas,
}

/// Treatment of letters in the texts of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TextLines {
    /// Draw the outlines of letters, except in fonts whose name says that they have single lines.
    #[default]
    Outline,
    /// Draw all letters in single lines.
    Stroke,
}

keywords! {
    TextLines, "text":
    Outline = "outline",
    Stroke = "stroke",
}

/// Fonts for texts in drawings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SystemFonts {
    /// The bundled font for every text, so that the result is the same on every machine.
    #[default]
    Off,
    /// The fonts that the drawing names, if installed. Needs the feature `system-fonts`.
    On,
}

keywords! {
    SystemFonts, "system_fonts":
    On = "on",
    Off = "off",
}

/// Treatment of white lines and shapes in a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum White {
    /// Draw white only on darker shapes, or if the drawing would otherwise be empty.
    #[default]
    Skip,
    /// Draw white as any other colour.
    Draw,
}

keywords! {
    White, "white":
    Skip = "skip",
    Draw = "draw",
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            title: String::new(),
            tolerance: 0.05,
            scale: 1.0,
            gcode: GcodeOptions::default(),
            fills: Fills::default(),
            white: White::default(),
            clip_page: false,
            resample: None,
            text: TextOptions::default(),
            text_lines: TextLines::default(),
            crop: None,
            system_fonts: SystemFonts::default(),
            strict_text: false,
        }
    }
}

/// Content of a file.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Content {
    /// Steps for the arm, in its own coordinates.
    Plan(Plan),
    /// Lines on a sheet, still to be placed in front of the arm.
    Artwork(Artwork),
    /// An image, to be engraved or traced.
    Image(Raster),
    /// A grid of squares to burn with many powers and speeds.
    TestGrid(TestGrid),
}

/// Result of reading a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed<T = Content> {
    /// Content.
    pub content: T,
    /// Notes about parts left out and assumptions made. They are not errors.
    pub notes: Vec<Diagnostic>,
}

/// Reads a file of a format.
///
/// # Errors
/// The first [`Diagnostic`] that makes the file unreadable, with its place. For a format that this
/// build cannot read, [`missing`](Diagnostic::missing) names its [`Format::feature`].
pub fn read(format: Format, bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    if format != Format::Points {
        only_recordings(options.resample)?;
    }
    if format != Format::Image {
        only_images(options.crop)?;
    }
    curved::read(format, bytes, options)
}

/// Reads a file and flattens its curves to the tolerance of `chords`.
fn lines(
    format: Format,
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    let reader = format.reader()?;
    // Empty text gets its own message from its reader, because users also type text.
    if bytes.is_empty() && format != Format::Text {
        return Err(Diagnostic::of_file(message!("the file is empty")));
    }
    foreign::check(bytes)?;
    let mut reading = reader(bytes, options, chords)?;
    if options.clip_page {
        let note = reading.clip_to_page();
        reading.notes.extend(note);
    }
    Ok(reading)
}

/// Refuses resampling for anything but a recording.
fn only_recordings(resample: Option<f64>) -> Result<(), Diagnostic> {
    match resample {
        None => Ok(()),
        Some(_) => Err(Diagnostic::of_file(
            message!("only a recording can be resampled: a CSV file with t, x, y, z, or an MCAP file with /pose"),
        )
        .with(Remedy::without(Setting::Resample))),
    }
}

/// Refuses cropping for anything but an image.
fn only_images(crop: Option<[u32; 4]>) -> Result<(), Diagnostic> {
    match crop {
        None => Ok(()),
        Some(_) => Err(
            Diagnostic::of_file(message!("only an image can be cropped"))
                .with(Remedy::without(Setting::Crop)),
        ),
    }
}

/// Tolerance of the page's edge, mm. It absorbs the rounding of coordinates in a file.
const PAGE_EDGE_TOLERANCE: f64 = 1e-3;

impl Parsed {
    /// Cuts off everything beyond the page and returns a note about it.
    fn clip_to_page(&mut self) -> Option<Diagnostic> {
        let page = match &self.content {
            Content::Artwork(artwork) => artwork.page,
            _ => None,
        };
        let (Content::Artwork(artwork), Some([width, height])) = (&mut self.content, page) else {
            let message = message!("the file has no page size: nothing is cut off");
            return Some(Diagnostic::of_file(message).coded(DiagnosticCode::Assumed));
        };
        let window = [
            [-PAGE_EDGE_TOLERANCE; 2],
            [width + PAGE_EDGE_TOLERANCE, height + PAGE_EDGE_TOLERANCE],
        ];
        let mut cut = 0;
        for filled in &mut artwork.areas {
            filled.area = filled.area.within(window);
        }
        artwork.areas.retain(|filled| !filled.area.rings.is_empty());
        let strokes = std::mem::take(&mut artwork.strokes);
        for stroke in strokes {
            let pieces = stroke.within(window);
            cut += usize::from(pieces != [stroke]);
            artwork.strokes.extend(pieces);
        }
        let message = match cut {
            1 => message!(
                "lines beyond the page ({width:.1} by {height:.1} mm) are cut off: 1 line",
                width,
                height
            ),
            _ => message!(
                "lines beyond the page ({width:.1} by {height:.1} mm) are cut off: {cut} lines",
                width,
                height,
                cut
            ),
        };
        (cut > 0).then(|| Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut))
    }
}
