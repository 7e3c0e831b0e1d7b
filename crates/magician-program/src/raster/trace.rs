//! An image as lines of a pen.

use magician_host::message;
use magician_host::{Given, Setting};

use super::resample::resample;
use super::shade::{Shade, nothing};
use super::{Raster, Size, centerline, halftone, hatch, outline, specks, squiggle};
use crate::{Artwork, Diagnostic};
use magician_formats::words::words;

/// What a pen makes of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ImageStyle {
    /// The edges of what is dark.
    #[default]
    Outline,
    /// The middle of dark lines.
    Centerline,
    /// Dots, the larger the darker.
    Halftone,
    /// Lines that swing the more the darker it is.
    Squiggle,
    /// Straight lines, crossed where it is darker.
    Hatch,
}

words! {
    ImageStyle, "image":
    Outline = "outline",
    Centerline = "centerline",
    Halftone = "halftone",
    Squiggle = "squiggle",
    Hatch = "hatch",
}

impl ImageStyle {
    /// Whether its lines keep the greys; the others only tell dark from light.
    #[must_use]
    pub const fn is_shaded(self) -> bool {
        matches!(self, Self::Halftone | Self::Squiggle | Self::Hatch)
    }

    /// Whether it can have a number of levels.
    #[must_use]
    pub const fn has_levels(self) -> bool {
        matches!(self, Self::Halftone | Self::Hatch)
    }
}

/// How a pen draws an image. Lengths are mm in the size that the image has.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trace {
    /// What is made of it.
    pub style: ImageStyle,
    /// With outlines and centre lines: what is darker than this, 1 to 255, is dark.
    pub level: u8,
    /// How large the image becomes.
    pub size: Size,
    /// How far a line may be from an outline as the pixels have it, mm.
    pub tolerance: f64,
    /// Spots whose box has no side as long as this are specks, and left out, mm; none with 0.
    pub despeckle: f64,
    /// Sizes of dots (64 unless given), or hatchings laid over each other (6 unless given).
    pub levels: Option<u8>,
    /// From one row of dots or lines to the next; of a hatching where it is lightest. By the width of the pen unless given, mm.
    pub spacing: Option<f64>,
    /// Width of the line that the pen draws, mm.
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
            pen_width: Self::PEN_WIDTH,
        }
    }
}

/// Darker than this is more than the noise of white paper: a spot of it can be a speck.
const FAINT: u8 = 240;
/// As finely specks of shaded images are looked at, mm, but with no more pixels on a side than this.
const SPECK_PIXEL: f64 = 0.1;
const MOST_SIDE: usize = 2000;

impl Trace {
    /// Width of the line of a pen unless given, mm: a fine felt-tip pen.
    pub const PEN_WIDTH: f64 = 0.5;
    /// Hatchings unless given.
    const HATCHINGS: u8 = 6;

    /// From one row of dots or lines to the next.
    pub(super) fn spacing(&self) -> f64 {
        let widths = match self.style {
            ImageStyle::Hatch => f64::from(self.hatch_levels()),
            ImageStyle::Squiggle => 4.0,
            _ => 3.0,
        };
        self.spacing.unwrap_or(widths * self.pen_width)
    }

    pub(super) fn hatch_levels(&self) -> u8 {
        self.levels.unwrap_or(Self::HATCHINGS).max(1)
    }

    /// The same for an image that is drawn so much larger: the pen stays as wide, and what is counted is what is drawn.
    #[must_use]
    pub(crate) fn drawn_larger(&self, scale: f64) -> Self {
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
                    (Setting::Spacing, Given::Any("MM")),
                    "increases the distance between its lines",
                )
                .remedy(
                    (Setting::PenWidth, Given::Any("MM")),
                    "sets the width of the pen",
                ));
        }
        Ok(())
    }
}

/// An image as lines.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImageLines {
    /// The lines, on a sheet of the image's size.
    pub artwork: Artwork,
    /// How many specks were left out.
    pub specks: usize,
}

impl Trace {
    /// What a pen draws of an image.
    ///
    /// Outlines lie where the grey between two pixels passes the level, and along the edge of the image where the dark reaches
    /// it; dark is on their right. The other styles are for a pen of [this width](Self::pen_width): the share of the paper that
    /// it inks is the darkness of the image.
    ///
    /// # Errors
    /// Numbers that are none, an image without pixels, one in which nothing is dark, and more lines than an arm draws in a day.
    pub fn lines(&self, image: &Raster) -> Result<ImageLines, Diagnostic> {
        let page = image.size(self.size)?;
        self.validate()?;
        let (strokes, specks) = match self.style {
            ImageStyle::Outline => outline::strokes(image, page, self),
            ImageStyle::Centerline => centerline::strokes(image, page, self),
            ImageStyle::Halftone | ImageStyle::Squiggle | ImageStyle::Hatch => {
                let mut image = reduced(image, page, SPECK_PIXEL, MOST_SIDE);
                let pixel = [page[0] / image.width as f64, page[1] / image.height as f64];
                let specks = specks::whiten(&mut image, pixel, FAINT, self.despeckle);
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
            return Err(nothing(self, specks));
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

/// An image with pixels no smaller than this (mm), and no more than so many on a side.
pub(super) fn reduced(image: &Raster, page: [f64; 2], pixel: f64, most: usize) -> Raster {
    let shrink = (image.width.max(image.height) as f64 / most as f64).max(1.0);
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
