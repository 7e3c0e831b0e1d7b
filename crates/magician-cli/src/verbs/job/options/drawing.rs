//! The flags of what is drawn: letters, shapes, lines, parts and images.

use clap::{Args, ValueHint};

use super::*;

/// How the lines of a drawing come about.
#[derive(Args, Debug, Default)]
pub(crate) struct DrawingFlags {
    #[command(flatten)]
    fill: FillFlags,
    #[command(flatten)]
    text: TextFlags,
    #[command(flatten)]
    tidy: TidyFlags,
    #[command(flatten)]
    parts: PartFlags,
}

impl DrawingFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        self.fill.say(options);
        self.text.say(options);
        self.tidy.say(options);
        self.parts.say(options);
    }
}

/// How text is written.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Text")]
pub(crate) struct TextFlags {
    /// Font of text: sans, script, gothic, or a file [default: sans]
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath, value_parser = font)]
    font: Option<FontChoice>,
    /// Height of a capital in text, mm [default: 10]
    #[arg(long, value_name = "MM", value_parser = positive)]
    size: Option<f64>,
    /// Break lines of text at this width, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    wrap: Option<f64>,
    /// Alignment of lines of text [default: left]
    #[arg(long, value_name = "left|center|right", value_parser = str::parse::<Align>)]
    align: Option<Align>,
    /// Distance between lines of text, in heights of a capital [default: 1.8]
    #[arg(long, value_name = "X", value_parser = positive)]
    line_height: Option<f64>,
}

/// How shapes are filled.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Fill")]
pub(crate) struct FillFlags {
    /// Fill the visible shapes of an SVG, and letters of an outline font, with lines; without it they are outlined [default: none]
    #[arg(long, value_name = "none|hatch|cross|contour", value_parser = str::parse::<FillMode>)]
    fill: Option<FillMode>,
    /// Distance of the lines, mm on the surface [default: 0.8 with the pen, 0.2 with the laser]
    #[arg(long, value_name = "MM", requires = "fill", value_parser = positive)]
    fill_spacing: Option<f64>,
    /// Direction of the lines, counter-clockwise from x [default: 45]
    #[arg(long, value_name = "DEGREES", requires = "fill", allow_hyphen_values = true, value_parser = number::<f64>)]
    fill_angle: Option<f64>,
    /// Distance of the lines from the edge, mm [default: half the distance of the lines]
    #[arg(long, value_name = "MM", requires = "fill", value_parser = number::<f64>)]
    fill_inset: Option<f64>,
}

/// Parts of a drawing, and their pens.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Layers, pens and colours")]
pub(crate) struct PartFlags {
    /// Divide a drawing into parts, and pause between them to change the pen: none, layer (layers, pens of a plot, tools of
    /// G-code), color [default: none; layer with --only or --pens, and if Inkscape layers have names with % or !]
    #[arg(long, value_name = "none|layer|color", value_parser = str::parse::<PartMode>)]
    parts: Option<PartMode>,
    /// Only draw the part of this name, colour (#rrggbb or a CSS name) or number; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Draw each part N times before the next
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    passes: Option<u32>,
    /// Pens of the parts, a TOML file of [[pen]] tables: match, surface_offset, lift, speed, power, passes, fill
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, value_parser = pens)]
    pens: Option<Pens>,
    /// Never pause for a person, neither between parts nor at M0, M1, M6 and T
    #[arg(long)]
    no_pause: bool,
}

/// How lines are tidied.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Lines of a drawing")]
pub(crate) struct TidyFlags {
    /// Join ends of lines that are no farther apart than this, mm; 0 joins none [default: 0.1]
    #[arg(long, value_name = "MM", value_parser = from_zero)]
    merge: Option<f64>,
    /// Draw lines that are there twice twice
    #[arg(long)]
    no_dedupe: bool,
    /// Tidy G-code, plans, playback and points too: draw a line that is there twice once, apply --merge and --simplify
    #[arg(long, conflicts_with = "no_dedupe")]
    dedupe: bool,
    /// Drop points that are closer than this to the line without them, mm; 0 drops none [default: 0.02]
    #[arg(long, value_name = "MM", value_parser = from_zero)]
    simplify: Option<f64>,
}

/// How an image is changed before it is drawn or burnt.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Images")]
pub(crate) struct ImageFlags {
    /// Crop an image to W by H pixels, from pixel X,Y counted from its upper left corner; --width is of what is left
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop)]
    crop: Option<[u32; 4]>,
    /// Make an image lighter, -100 to 100
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = of_100)]
    brightness: Option<f64>,
    /// Give an image more contrast, -100 to 100
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = of_100)]
    contrast: Option<f64>,
    /// Exponent of the darkness; above 1 makes mid-tones lighter
    #[arg(long, value_name = "EXPONENT", value_parser = positive)]
    gamma: Option<f64>,
    /// Draw or burn what is white instead of what is black
    #[arg(long)]
    invert: bool,
    /// Distance between the lines or dots of an image, mm [default: 0.2 with the laser; with the pen by --image and --pen-width]
    #[arg(long, value_name = "MM", value_parser = positive)]
    spacing: Option<f64>,
}

/// What a pen makes of an image.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Images with the pen")]
pub(crate) struct TraceFlags {
    #[command(flatten)]
    style: ImageStyleFlags,
    /// With outline and centerline: what is darker than this is dark, 1 to 255 [default: 128]
    #[arg(long, value_name = "GREY", value_parser = clap::value_parser!(u8).range(1..))]
    threshold: Option<u8>,
}

/// What a pen makes of an image, apart from what counts as dark.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Images with the pen")]
pub(crate) struct ImageStyleFlags {
    /// Draw an image as: outline (edges of what is dark), centerline (one stroke along each dark line), halftone (dots), squiggle
    /// (swinging lines), hatch (crossed hatchings); the last three keep its greys [default: outline]
    #[arg(long, value_name = "STYLE", value_parser = str::parse::<ImageStyle>)]
    image: Option<ImageStyle>,
    /// With hatch: number of hatchings [default: 6]; with halftone: number of sizes of dots [default: 64]
    #[arg(long, value_name = "N", requires = "image", value_parser = clap::value_parser!(u8).range(1..=64))]
    levels: Option<u8>,
    /// Leave out spots smaller than this, mm; 0 keeps all [default: 0.3]
    #[arg(long, value_name = "MM", value_parser = from_zero)]
    despeckle: Option<f64>,
    /// Width of the line that the pen draws, mm; halftone, squiggle and hatch are made for it [default: 0.5]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pen_width: Option<f64>,
}

impl TextFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.font = self.font.clone();
        options.size = self.size;
        options.wrap = self.wrap;
        options.align = self.align;
        options.line_height = self.line_height;
    }
}

impl FillFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.fill = self.fill;
        options.fill_spacing = self.fill_spacing;
        options.fill_angle = self.fill_angle;
        options.fill_inset = self.fill_inset;
    }
}

impl PartFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.parts = self.parts;
        options.only.clone_from(&self.only);
        options.passes = self.passes;
        options.pens = self.pens.clone().unwrap_or_default().0;
        options.no_pause = self.no_pause;
    }
}

impl TidyFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.merge = self.merge;
        options.dedupe = match (self.dedupe, self.no_dedupe) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        };
        options.simplify = self.simplify;
    }
}

impl ImageFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.crop = self.crop;
        options.brightness = self.brightness;
        options.contrast = self.contrast;
        options.gamma = self.gamma;
        options.invert = self.invert;
        options.spacing = self.spacing;
    }
}

impl TraceFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        self.style.say(options);
        options.threshold = self.threshold;
    }
}

impl ImageStyleFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.image = self.image;
        options.levels = self.levels;
        options.despeckle = self.despeckle;
        options.pen_width = self.pen_width;
    }
}
