//! Images as pen lines.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::resample::resample;
use super::shade::{Shade, nothing_to_draw};
use super::{Raster, Size, centerline, halftone, hatch, outline, specks, squiggle};
use crate::{Artwork, Diagnostic};
use magician_formats::keywords::keywords;

/// Style of drawing an image with a pen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ImageStyle {
    /// Outlines of dark areas.
    #[default]
    Outline,
    /// Centre lines of dark lines.
    Centerline,
    /// Dots, larger in dark areas.
    Halftone,
    /// Lines that oscillate more in dark areas.
    Squiggle,
    /// Straight lines, crossed in dark areas.
    Hatch,
}

keywords! {
    ImageStyle, "image":
    Outline = "outline",
    Centerline = "centerline",
    Halftone = "halftone",
    Squiggle = "squiggle",
    Hatch = "hatch",
}

impl ImageStyle {
    /// True if the style reproduces grey levels; other styles only separate dark from light.
    #[must_use]
    pub const fn is_shaded(self) -> bool {
        matches!(self, Self::Halftone | Self::Squiggle | Self::Hatch)
    }

    /// True if the number of levels can be set.
    #[must_use]
    pub const fn has_levels(self) -> bool {
        matches!(self, Self::Halftone | Self::Hatch)
    }
}

/// Options for drawing an image with a pen. Lengths are mm at the drawn size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trace {
    /// Style.
    pub style: ImageStyle,
    /// For outlines and centre lines: grey level, 1 to 255, below which a pixel is dark.
    pub level: u8,
    /// Size of the drawing.
    pub size: Size,
    /// Largest deviation of a line from the outline given by the pixels, mm.
    pub tolerance: f64,
    /// Size below which a spot is left out as a speck, mm: both sides of its bounding box are
    /// shorter. 0 keeps all.
    pub despeckle: f64,
    /// Number of dot sizes (default 64) or of hatching layers (default 6).
    pub levels: Option<u8>,
    /// Distance between rows of dots or lines, mm; for hatching, in the lightest areas. Derived
    /// from the pen width by default.
    pub spacing: Option<f64>,
    /// Width of the pen's line, mm.
    pub pen_width: f64,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            style: ImageStyle::default(),
            level: 128,
            size: Size::Natural,
            tolerance: 0.1,
            despeckle: 0.3,
            levels: None,
            spacing: None,
            pen_width: Self::DEFAULT_PEN_WIDTH,
        }
    }
}

/// Grey level below which a spot can be a speck: lighter pixels are noise of white paper.
const SPECK_LEVEL: u8 = 240;
/// Pixel size at which shaded styles look for specks, mm. Larger if the image would exceed
/// [`MAX_SIDE`].
const SPECK_PIXEL_SIZE: f64 = 0.1;
/// Largest side of an image in which shaded styles look for specks, pixels.
const MAX_SIDE: usize = 2000;

impl Trace {
    /// Default width of the pen's line, mm: a fine felt-tip pen.
    pub const DEFAULT_PEN_WIDTH: f64 = 0.5;
    /// Default number of hatching layers.
    const DEFAULT_HATCH_LAYERS: u8 = 6;

    /// Distance between rows of dots or lines, mm.
    pub(super) fn spacing(&self) -> f64 {
        let widths = match self.style {
            ImageStyle::Hatch => f64::from(self.hatch_levels()),
            ImageStyle::Squiggle => 4.0,
            _ => 3.0,
        };
        self.spacing.unwrap_or(widths * self.pen_width)
    }

    pub(super) fn hatch_levels(&self) -> u8 {
        self.levels.unwrap_or(Self::DEFAULT_HATCH_LAYERS).max(1)
    }

    /// Converts the options for lines that are scaled by `scale` afterwards, so that the pen width
    /// and all lengths hold at the drawn size.
    #[must_use]
    pub(crate) fn at_scale(&self, scale: f64) -> Self {
        Self {
            tolerance: self.tolerance / scale,
            despeckle: self.despeckle / scale,
            spacing: self.spacing.map(|spacing| spacing / scale),
            pen_width: self.pen_width / scale,
            ..self.clone()
        }
    }

    fn validate(&self) -> Result<(), Diagnostic> {
        let lengths = [
            ("tolerance", self.tolerance),
            ("size of a speck", self.despeckle),
        ];
        for (name, value) in lengths {
            if !(value >= 0.0 && value.is_finite()) {
                let why = message!(
                    "the {name} is {value} mm, it must be 0 or more",
                    name,
                    value
                );
                return Err(Diagnostic::of_file(why));
            }
        }
        let lengths = [
            ("width of the pen", self.pen_width),
            ("distance of the lines", self.spacing()),
        ];
        for (name, value) in lengths {
            if !(value > 0.0 && value.is_finite()) {
                let why = message!("the {name} is {value} mm, it must be above 0", name, value);
                return Err(Diagnostic::of_file(why));
            }
        }
        if self.style.is_shaded() && self.spacing() < self.pen_width * (1.0 - 1e-9) {
            let message =
                message!("lines that are closer together than the pen is wide keep no grey");
            return Err(Diagnostic::of_file(message)
                .remedy(
                    (Setting::Spacing, SettingValue::Any("MM")),
                    "increases the distance between its lines",
                )
                .remedy(
                    (Setting::PenWidth, SettingValue::Any("MM")),
                    "sets the width of the pen",
                ));
        }
        Ok(())
    }
}

/// Image as lines.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImageLines {
    /// Lines, on a page of the image's size.
    pub artwork: Artwork,
    /// Number of specks left out.
    pub specks: usize,
}

impl Trace {
    /// Converts an image to pen lines.
    ///
    /// Outlines run where the grey between two pixels crosses the level, and along the edge of the
    /// image where dark areas reach it; dark is on their right. Shaded styles assume a pen of [this
    /// width](Self::pen_width): the share of paper that it inks equals the darkness of the image.
    ///
    /// # Errors
    /// NaN or out-of-range options, an image without pixels or without dark areas, and more lines
    /// than an arm draws in a day.
    pub fn lines(&self, image: &Raster) -> Result<ImageLines, Diagnostic> {
        let page = image.size(self.size)?;
        self.validate()?;
        let (strokes, specks) = match self.style {
            ImageStyle::Outline => outline::strokes(image, page, self),
            ImageStyle::Centerline => centerline::strokes(image, page, self),
            ImageStyle::Halftone | ImageStyle::Squiggle | ImageStyle::Hatch => {
                let mut image = reduced(image, page, SPECK_PIXEL_SIZE, MAX_SIDE);
                let pixel = [page[0] / image.width as f64, page[1] / image.height as f64];
                let specks = specks::whiten(&mut image, pixel, SPECK_LEVEL, self.despeckle);
                let shade = Shade::new(&image, page, self.pen_width);
                let strokes = match self.style {
                    ImageStyle::Halftone => halftone::strokes(&shade, self)?,
                    ImageStyle::Squiggle => squiggle::strokes(&shade, self)?,
                    _ => hatch::strokes(&shade, self)?,
                };
                (strokes, specks)
            }
        };
        if strokes.is_empty() {
            return Err(nothing_to_draw(self, specks));
        }
        let artwork = Artwork {
            title: image.title.clone(),
            page: Some(page),
            strokes,
            ..Artwork::default()
        };
        Ok(ImageLines { artwork, specks })
    }
}

/// Reduces an image so that its pixels are at least `pixel` mm wide, and each side has at most
/// `most` pixels.
pub(super) fn reduced(image: &Raster, page: [f64; 2], pixel: f64, max_side: usize) -> Raster {
    let shrink = (image.width.max(image.height) as f64 / max_side as f64).max(1.0);
    let side = |pixels: usize, length: f64| {
        let wanted = (pixels as f64 / shrink).min((length / pixel).ceil());
        (wanted.round() as usize).clamp(1, pixels)
    };
    let (width, height) = (side(image.width, page[0]), side(image.height, page[1]));
    Raster {
        grey: resample(image, width, height),
        width,
        height,
        ..Raster::default()
    }
}
