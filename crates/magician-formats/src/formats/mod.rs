//! The files people have, each read by a module of its own.

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
#[cfg(feature = "lettering")]
mod words;
#[cfg(feature = "programs")]
mod xml;

pub(crate) use curved::Chords;
pub use curved::{CurvedFile, Curves};
pub use foreign::foreign;
pub use gcode_options::{Arcs, Dialect, GcodeOptions};

use magician_host::message;
use magician_host::{Remedy, Setting};

use crate::lettering::TextOptions;
use crate::raster::Raster;
use crate::words::words;
use crate::{Artwork, Diagnostic, DiagnosticCode, Plan, TestGrid};

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
    /// PNG, JPEG, BMP, WebP, GIF, TIFF and netpbm images.
    Image,
    /// Lists of points: CSV, JSON, text.
    Points,
    /// Text, to be written.
    Text,
    /// Test grids of the laser.
    TestGrid,
}

/// How a file is read, where it leaves a choice.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// What it is called in what is made of it; the file's name without its ending, as a rule.
    pub title: String,
    /// Largest distance of a line from its curve, mm in the size in which it is drawn.
    pub tolerance: f64,
    /// Size in which it is drawn, 1 being the true one, as far as that is known. What places the
    /// lines reads the file again ([`CurvedFile`]) where they are drawn larger.
    pub scale: f64,
    /// What G-code leaves open.
    pub gcode: GcodeOptions,
    /// What becomes of filled shapes that have no line of their own.
    pub fills: Fills,
    /// What becomes of white in a drawing.
    pub white: White,
    /// Whether what lies beyond the page of a drawing is cut off.
    pub clip_page: bool,
    /// Points of a recording that are nearer to the line than this are left out, mm; the times of the others stay.
    pub resample: Option<f64>,
    /// How text is set.
    pub text: TextOptions,
    /// How the letters of texts in drawings are drawn.
    pub text_lines: TextLines,
    /// What is kept of an image, in its pixels as it is seen upright: from the left, from the top, width, height.
    pub crop: Option<[u32; 4]>,
    /// Whether texts in drawings are written in the fonts that are installed.
    pub system_fonts: SystemFonts,
    /// Whether text is refused of which the font lacks a character; that is left out otherwise.
    pub strict_text: bool,
}

/// What becomes of filled shapes without a line in a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fills {
    /// Their edge is drawn.
    #[default]
    Outline,
    /// They are left out.
    Ignore,
    /// What is filled is kept as [areas](Artwork::areas), also where there is a line around it.
    Areas,
}

/// How the letters of texts in a drawing are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TextLines {
    /// By their outlines, but for those of fonts whose name says that they have single lines.
    #[default]
    Outline,
    /// All in single lines.
    Stroke,
}

words! {
    TextLines, "text":
    Outline = "outline",
    Stroke = "stroke",
}

/// Whether texts in drawings are written in the fonts that they name, where those are installed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SystemFonts {
    /// All are written in the one that is built in, on every machine alike.
    #[default]
    Off,
    /// They are, with feature `system-fonts`.
    On,
}

words! {
    SystemFonts, "system_fonts":
    On = "on",
    Off = "off",
}

/// What becomes of white lines and shapes in a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum White {
    /// They are drawn on darker shapes, and where nothing else would be drawn; otherwise they are left out.
    #[default]
    Skip,
    /// They are drawn.
    Draw,
}

words! {
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

/// What was in a file.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Content {
    /// What the arm is to do, in its own coordinates.
    Plan(Plan),
    /// Lines on a sheet, to be placed before the arm.
    Artwork(Artwork),
    /// An image, to be engraved or traced.
    Image(Raster),
    /// A grid of squares to be burnt with many powers and speeds.
    TestGrid(TestGrid),
}

/// A file that was understood.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed<T = Content> {
    /// What was in it.
    pub content: T,
    /// What was left out or taken in a certain way; nothing of it is an error.
    pub notes: Vec<Diagnostic>,
}

/// Reads a file of this format.
///
/// # Errors
/// The first [`Diagnostic`] that makes it unreadable, with its place; for a format that this build does not read one that
/// [`missing`](Diagnostic::missing) its [`Format::feature`].
pub fn read(format: Format, bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    if format != Format::Points {
        only_recordings(options.resample)?;
    }
    if format != Format::Image {
        only_images(options.crop)?;
    }
    curved::read(format, bytes, options)
}

/// Reads the lines of a file, its curves as these chords.
fn lines(
    format: Format,
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    let reader = format.reader()?;
    // Text is given as it is, too, and has an answer of its own.
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

/// Refuses to thin what is no recording.
fn only_recordings(resample: Option<f64>) -> Result<(), Diagnostic> {
    match resample {
        None => Ok(()),
        Some(_) => Err(Diagnostic::of_file(
            message!("only a recording can be resampled: a CSV file with t, x, y, z, or an MCAP file with /pose"),
        )
        .with(Remedy::without(Setting::Resample))),
    }
}

/// Refuses to crop what is no image.
fn only_images(crop: Option<[u32; 4]>) -> Result<(), Diagnostic> {
    match crop {
        None => Ok(()),
        Some(_) => Err(
            Diagnostic::of_file(message!("only an image can be cropped"))
                .with(Remedy::without(Setting::Crop)),
        ),
    }
}

/// What is no farther beyond the edge of a page is on it, mm: numbers are rounded.
const ON_THE_EDGE: f64 = 1e-3;

impl Parsed {
    /// Cuts off what lies beyond the page; what there is to be said of that.
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
            [-ON_THE_EDGE; 2],
            [width + ON_THE_EDGE, height + ON_THE_EDGE],
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
