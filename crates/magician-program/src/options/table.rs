//! Table of all options, deliberately in one file: one row each. To add an option, add its row here
//! and use its value.
//!
//! A row has its help sentence (and further text for longer help), its member of [`SetupOptions`]
//! with its type, and its facts. Everything else is derived from it: parsing of JSON, command
//! lines, presets and keywords, checks, the form of the page, and the tables in the docs.

use serde_json::Value;

use super::spec::{
    Change, area, choice, first_of, integer, list, number, pens, place, point, switch, switch_off,
    text,
};
use super::value::OptionMember;
use super::{Grid, ModeOption, OptionSpec, PenOptions, WorkOption};
use crate::Format::{self, Dxf, Gcode, Hpgl, Image as Picture, Svg, TestGrid, Text as Letters};
use crate::fill::{FillMode, MIN_SPACING};
use crate::formats::Dialect;
use crate::lettering::{Align, FontChoice};
use crate::raster::{ImageStyle, Trace};
use crate::setup::MAX_PASSES;
use crate::{
    BundledFont, Depths, FrameShape, Framing, Page, Paper, PartMode, Power, SystemFonts, TextLines,
    Tool, White,
};

use super::DefaultValue::{Number, Switch};
use super::OptionGroup::{Fill, Image, Laser, More, Parts, Pen, Place, Text};
use WorkOption::{Draw, Engrave};

/// Largest length and coordinate, mm: far beyond every sheet and arm, while an `f32` of this size,
/// as the arm uses, still resolves micrometres.
const MAX_LENGTH: f64 = 10_000.0;
/// Smallest speed, mm/s: a slower arm seems to stand still.
const MIN_SPEED: f64 = 0.01;
/// Largest angle, degrees: a hundred turns.
const MAX_DEGREES: f64 = 36_000.0;

const ALL: &[Format] = &Format::ALL;
/// Formats whose file does not define the settings of a run.
const WITHOUT_TEST_GRID: &[Format] = &[
    Svg,
    Dxf,
    Hpgl,
    Letters,
    Picture,
    Gcode,
    Format::Playback,
    Format::Blockly,
    Format::Points,
    Format::Plan,
];
/// Formats that are always placed in front of the arm.
const PLACED: &[Format] = &[Svg, Dxf, Hpgl, Letters, Picture, TestGrid];
/// Formats that are placed only on request.
const PROGRAMS: &[Format] = &[
    Gcode,
    Format::Playback,
    Format::Blockly,
    Format::Points,
    Format::Plan,
];
const DRAWINGS: &[Format] = &[Svg, Dxf, Hpgl];
const ARTWORK: &[Format] = &[Svg, Dxf, Hpgl, Letters];
const IMAGES: &[Format] = &[Picture];
const DRAWN: &[Format] = &[Svg, Dxf, Hpgl, Letters, Picture];
const FILL_PATTERNS: &[&str] = &["hatch", "cross", "contour"];

/// Change: the option applies to programs only once they are placed.
const ONCE_PLACED: &[(&[Format], Change)] = &[(PROGRAMS, Change::With("place"))];
const ONCE_PLACED_GCODE: &[(&[Format], Change)] = &[(&[Gcode], Change::With("place"))];
/// Change: the option applies to programs only once they are deduplicated, since programs are never
/// tidied unasked.
const ONCE_DEDUPED: &[(&[Format], Change)] = &[(PROGRAMS, Change::With("dedupe"))];

/// Generates the struct from its rows, and the functions that must name every member.
macro_rules! setup_options {
    ($(
        $about:literal, $($detail:literal,)?
        $field:ident $(as $name:literal)?: $type:ty = $spec:expr;
    )*) => {
        /// Options for drawing, engraving and running a file. Unset options follow the settings or
        /// the file. Lengths are mm, angles degrees, speeds mm/s.
        ///
        /// In JSON each option is a member under its name: numbers as numbers, points as arrays,
        /// switches as booleans. The rows of [`OPTIONS`](Self::OPTIONS) describe them.
        ///
        /// ```
        /// use magician_program::{Setup, SetupDefaults, SetupOptions};
        /// use serde_json::json;
        ///
        /// let fields = json!({"at": [230, 0], "scale": 0.5, "order": false});
        /// let options = SetupOptions::from_fields(fields.as_object().unwrap())?;
        /// let setup: Setup = options.setup(&SetupDefaults::default());
        /// assert_eq!((setup.placement.at, setup.order), (Some([230.0, 0.0]), false));
        /// let wrong = json!({"scale": -1});
        /// let error = SetupOptions::from_fields(wrong.as_object().unwrap()).unwrap_err();
        /// assert_eq!(error.message, "scale is a number above 0 and at most 10000, not -1");
        /// # Ok::<(), magician_program::OptionError>(())
        /// ```
        #[derive(Clone, Debug, Default, PartialEq)]
        #[non_exhaustive]
        pub struct SetupOptions {
            $(#[doc = $about] pub $field: $type,)*
        }

        impl SetupOptions {
            /// Table of the options, one row each.
            pub const OPTIONS: &'static [OptionSpec] = &[
                $($spec.named(name!($field $($name)?), $about, concat!($($detail)?)),)*
            ];

            /// Sets one option from a JSON value.
            ///
            /// # Errors
            /// The mistake in the value; `None` if the row's description is enough.
            pub(super) fn set(&mut self, name: &str, value: &Value) -> Result<(), Option<magician_host::Message>> {
                match name {
                    $(name!($field $($name)?) => self.$field = OptionMember::read(value)?,)*
                    _ => return Err(None),
                }
                Ok(())
            }

            /// Returns the value of each option in the order of the rows; `None` if it is not set.
            pub(super) fn values(&self) -> Vec<(&'static OptionSpec, Option<Value>)> {
                let values = [$(self.$field.to_json_if_set(),)*];
                Self::OPTIONS.iter().zip(values).collect()
            }

            /// Returns these options, completed by those of `under`.
            ///
            /// ```
            /// use magician_program::SetupOptions;
            ///
            /// let (mut said, mut preset) = (SetupOptions::default(), SetupOptions::default());
            /// (said.speed, preset.speed, preset.lift) = (Some(20.0), Some(50.0), Some(5.0));
            /// let both = said.or(&preset);
            /// assert_eq!((both.speed, both.lift), (Some(20.0), Some(5.0)));
            /// ```
            #[must_use]
            pub fn or(&self, under: &Self) -> Self {
                let under = under.without_replaced_by(self);
                Self {
                    $($field: if self.$field.is_unset() { &under.$field } else { &self.$field }.clone(),)*
                }
            }

            /// Unsets an option.
            pub(super) fn clear(&mut self, name: &str) {
                match name {
                    $(name!($field $($name)?) => self.$field = Default::default(),)*
                    _ => {}
                }
            }
        }
    };
}

/// Name of a member in interfaces: that of the field, unless the row gives another one.
macro_rules! name {
    ($field:ident) => {
        stringify!($field)
    };
    ($field:ident $name:literal) => {
        $name
    };
}

setup_options! {
    "Kind of work for drawings and images: draw with a pen, or engrave with the laser",
    "By default the tool decides: the laser engraves, every other tool draws.",
    work: Option<WorkOption> = choice(More, WorkOption::NAMES);

    "Font of text: a built-in font or a font file",
    "Built-in fonts draw letters in single strokes. A file is a TrueType, OpenType or SVG font, or stroke-order data for Chinese and \
     Japanese characters (KanjiVG, hanzi-writer).",
    font: Option<FontChoice> = first_of(Text, BundledFont::NAMES)
        .expects("sans, script or gothic", "NAME|FILE")
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Height of capital letters",
    size: Option<f64> = number(Text, "mm").above(0.0).at_most(MAX_LENGTH).default_value(Number(10.0))
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Width at which text wraps",
    wrap: Option<f64> = number(Text, "mm").above(0.0).at_most(MAX_LENGTH)
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Place a program (G-code, a plan, playback, points) like a drawing",
    "It is centred at the given point, else placed on the calibrated sheet, else where the arm has room for it. Setting a point, a page, a surface, fitting or a kind of work implies this option.",
    place: bool = switch(Place).for_formats(PROGRAMS).usual_for(&[Gcode]);

    "Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm",
    "The setting stays on the arm.",
    tool: Option<Tool> = first_of(Place, &["pen", "laser"])
        .expects("none, suction, gripper, pen, laser, or its bias X,Y,Z in mm", "NAME|X,Y,Z")
        .for_formats(WITHOUT_TEST_GRID).usual_for(&[Svg, Dxf, Hpgl, Picture, Letters, Gcode])
        .changes(ONCE_PLACED);

    "Fill visible shapes, and letters of outline fonts, with lines",
    "Parallel lines (hatch), two crossed sets of lines (cross), or rings from the edge inwards (contour). By default shapes are only outlined.",
    fill: Option<FillMode> = first_of(Fill, FillMode::NAMES).for_formats(ARTWORK).usual_for(&[Svg]);

    "Style in which the pen draws an image",
    "Outlines of dark areas, one stroke along each dark line, dots, wavy lines, or crossed hatching; the last three reproduce grey levels.",
    image: Option<ImageStyle> = first_of(Image, ImageStyle::NAMES)
        .of_work(Draw).for_formats(IMAGES).usual_for(IMAGES);

    "Height of the work surface",
    "This is the z of the arm's pose when the tool touches the surface.",
    surface: Option<f64> = number(Place, "mm").at_least(-MAX_LENGTH).at_most(MAX_LENGTH)
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED);

    "Position of the centre of the artwork",
    at: Option<[f64; 2]> = point(Place).at_least(-MAX_LENGTH).at_most(MAX_LENGTH)
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED);

    "Scale factor; 1 is the original size",
    "With a width or a height, the factor multiplies that size.",
    scale: Option<f64> = number(Place, "").above(0.0).at_most(MAX_LENGTH).default_value(Number(1.0))
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, TestGrid, Gcode]).changes(ONCE_PLACED_GCODE);

    "Width to scale to",
    width: Option<f64> = number(Place, "mm").above(0.0).at_most(MAX_LENGTH)
        .for_formats(WITHOUT_TEST_GRID).usual_for(IMAGES).changes(ONCE_PLACED);

    "Counter-clockwise rotation",
    rotate: Option<f64> = number(Place, "deg").at_least(-MAX_DEGREES).at_most(MAX_DEGREES).default_value(Number(0.0))
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED_GCODE);

    "Shrink the artwork until all of it is within the arm's reach and on the page",
    fit: bool = switch(Place).for_formats(ALL).usual_for(PLACED).changes(ONCE_PLACED);

    "Height to scale to, instead of a width",
    height: Option<f64> = number(Place, "mm").above(0.0).at_most(MAX_LENGTH).contradicts(&["width"])
        .for_formats(WITHOUT_TEST_GRID).changes(ONCE_PLACED);

    "Clip a drawing to its page",
    clip_page: bool = switch(Place).for_formats(DRAWINGS);

    "Paper size of the page to draw on; also a size in mm, such as 200x150",
    "The artwork keeps its position if its file has a page of that size; otherwise it is centred. The page lies at the given point, else \
     on the calibrated sheet, else where the arm has room for it.",
    page: Option<Paper> = choice(Place, Paper::NAMES)
        .expects("a3, a4, a5, a6 or letter, each also with -landscape, or WIDTHxHEIGHT in mm, such as 200x150", "NAME|WxH")
        .for_formats(ALL).changes(ONCE_PLACED);

    "Margin kept to the edges of the page when fitting",
    margin: Option<f64> = number(Place, "mm").at_least(0.0).at_most(MAX_LENGTH).default_value(Number(Page::DEFAULT_MARGIN))
        .needs("page", &[]).for_formats(ALL);

    "Rotate the artwork by 90 degrees if it fits better",
    turn: Option<bool> = switch_off(
        Place,
        "Never rotate the artwork by 90 degrees, neither to fit in front of the arm nor to become larger",
    ).for_formats(PLACED);

    "Mirror the artwork left to right",
    mirror: bool = switch(Place).for_formats(ALL);

    "Offset added to the position",
    by as "move": Option<[f64; 3]> = place(Place).at_least(-MAX_LENGTH).at_most(MAX_LENGTH).expects("", "DX,DY,DZ").for_formats(ALL);

    "Repeat the artwork at each position of a grid, such as 2x3:40x30",
    grid: Option<Grid> = text(Place, "")
        .expects("ROWSxCOLUMNS:DXxDY, such as 2x3:40x30", "ROWSxCOLUMNS:DXxDY").for_formats(ALL);

    "Use the coordinates of the file as arm coordinates, unchanged",
    raw: bool = switch(More).contradicts(&["place", "at", "page", "fit", "surface", "pen_z"])
        .for_formats(PROGRAMS);

    "Spacing of the fill lines",
    "Measured on the surface, independent of the scale.",
    fill_spacing: Option<f64> = number(Fill, "mm").at_least(MIN_SPACING).at_most(MAX_LENGTH)
        .default_text("0.8 with the pen, 0.2 with the laser").needs("fill", FILL_PATTERNS).for_formats(ARTWORK);

    "Angle of the fill lines, counter-clockwise from x",
    fill_angle: Option<f64> = number(Fill, "deg").at_least(-MAX_DEGREES).at_most(MAX_DEGREES).default_value(Number(45.0))
        .needs("fill", FILL_PATTERNS).with("fill", &["hatch", "cross"]).for_formats(ARTWORK);

    "Inset of the fill lines from the edge of the shape",
    fill_inset: Option<f64> = number(Fill, "mm").at_least(0.0).at_most(MAX_LENGTH)
        .default_text("half of the spacing").needs("fill", FILL_PATTERNS).for_formats(ARTWORK);

    "Handling of white lines and shapes",
    "Either skip them, except on darker shapes or if nothing else would be drawn; or draw all of them.",
    white: Option<White> = first_of(Fill, White::NAMES).for_formats(ARTWORK);

    "Alignment of lines of text",
    align: Option<Align> = first_of(Text, Align::NAMES).for_formats(&[Letters]);

    "Line spacing of text, as a multiple of the height of capital letters",
    line_height: Option<f64> = number(Text, "").above(0.0).at_most(1000.0).default_value(Number(1.8)).for_formats(&[Letters]);

    "Rendering of text in a drawing",
    "Either outlines, except for fonts whose name begins with Hershey or ends in 1-stroke or Single Line; or single strokes for all text.",
    text: Option<TextLines> = first_of(Text, TextLines::NAMES).for_formats(&[Svg]);

    "Use of installed fonts for text in a drawing",
    "Without them all text uses the built-in font, with the same result on every machine.",
    system_fonts: Option<SystemFonts> = first_of(Text, SystemFonts::NAMES).for_formats(&[Svg]);

    "Refuse text if the font lacks a character; by default the character is skipped, with a note",
    strict_text: bool = switch(Text).for_formats(ARTWORK);

    "Split a drawing into parts; the job pauses between them for a pen change",
    "Split by layer (also pens of a plot, tools of G-code) or by colour. By default a drawing is split by layer if parts are selected or have \
     pens, or if names of Inkscape layers contain % or !; otherwise it is not split.",
    parts: Option<PartMode> = choice(Parts, PartMode::NAMES)
        .for_formats(&[Svg, Dxf, Hpgl, Gcode]);

    "Parts to draw, each by its name, colour (#rrggbb or a CSS name) or number",
    "By default all parts are drawn.",
    only: Vec<String> = list(Parts).expects("a list of texts of at most 1000 characters", "NAME").for_formats(DRAWINGS);

    "Number of times to draw each part before the next one",
    passes: Option<u32> = integer(Parts).at_least(1.0).at_most(MAX_PASSES as f64).default_value(Number(1.0)).for_formats(WITHOUT_TEST_GRID);

    "Pens of the parts; the first pen that matches a part is used",
    "Each pen has a match (a name, a colour or a number) and any of surface_offset, lift, speed, power, passes and fill.",
    pens: Vec<PenOptions> = pens(Parts).for_formats(DRAWINGS);

    "Never pause for the operator, neither between parts nor where the program asks for it",
    no_pause: bool = switch(Parts).for_formats(WITHOUT_TEST_GRID);

    "Number of superimposed hatchings, or of dot sizes",
    levels: Option<u8> = integer(Image).at_least(1.0).at_most(64.0).default_text("6 hatchings, 64 dot sizes")
        .needs("image", &["halftone", "hatch"]).of_work(Draw).for_formats(IMAGES);

    "Largest size of spots in an image to remove; 0 keeps all",
    despeckle: Option<f64> = number(Image, "mm").at_least(0.0).at_most(MAX_LENGTH).default_value(Number(0.3)).of_work(Draw).for_formats(IMAGES);

    "Line width of the pen, for images",
    pen_width: Option<f64> = number(Image, "mm").above(0.0).at_most(MAX_LENGTH).default_value(Number(Trace::DEFAULT_PEN_WIDTH))
        .of_work(Draw).for_formats(IMAGES);

    "Spacing of the lines or dots of an image",
    spacing: Option<f64> = number(Image, "mm").above(0.0).at_most(MAX_LENGTH)
        .default_text("0.2 with the laser; with the pen, set by the style and the line width").for_formats(IMAGES);

    "Grey level below which a pixel counts as dark, if the image is drawn or burnt in black and white",
    threshold: Option<u8> = integer(Image).at_least(1.0).at_most(255.0).default_value(Number(128.0)).for_formats(IMAGES);

    "Area of an image to keep, in pixels from the upper left corner",
    crop: Option<[u32; 4]> = area(Image).for_formats(IMAGES);

    "Brightness adjustment of an image",
    brightness: Option<f64> = number(Image, "").at_least(-100.0).at_most(100.0).default_value(Number(0.0)).for_formats(IMAGES);

    "Contrast adjustment of an image",
    contrast: Option<f64> = number(Image, "").at_least(-100.0).at_most(100.0).default_value(Number(0.0)).for_formats(IMAGES);

    "Gamma, the exponent of the darkness; above 1 makes mid-tones lighter",
    gamma: Option<f64> = number(Image, "").above(0.0).at_most(100.0).default_value(Number(1.0)).for_formats(IMAGES);

    "Draw or burn the white areas instead of the black ones",
    invert: bool = switch(Image).for_formats(IMAGES);

    "Full laser power, or the range of all powers above 0, such as 5..80",
    power: Option<Power> = text(Laser, "%")
        .expects("percent above 0 and at most 100, such as 80 or 5..80", "P|LEAST..MOST")
        .with("tool", &["laser"]).of_work(Engrave).for_formats(WITHOUT_TEST_GRID);

    "Rendering of grey levels: as laser power, in black and white, or by dithering",
    mode: Option<ModeOption> = first_of(Laser, ModeOption::NAMES).of_work(Engrave).for_formats(IMAGES);

    "Burn all lines in the same direction: slower, but without errors from backlash",
    one_way: bool = switch(Laser).of_work(Engrave).for_formats(&[Picture, TestGrid]);

    "Overscan: run-up and run-out of the tool at the ends of a line",
    overscan: Option<f64> = number(Laser, "mm").above(0.0).at_most(MAX_LENGTH).default_text("derived from the speed")
        .of_work(Engrave).for_formats(&[Picture, TestGrid]);

    "Trace the frame of the job instead of marking it",
    "The frame is the bounding box along X and Y, the convex hull, or the outer contours.",
    frame: Option<FrameShape> = choice(Laser, FrameShape::NAMES).for_formats(ALL);

    "Laser power while tracing a frame",
    "By default the laser is off.",
    frame_power: Option<f64> = number(Laser, "%").above(0.0).at_most(Framing::MAX_POWER)
        .needs("frame", &[]).for_formats(ALL);

    "Pen lift between lines",
    lift: Option<f64> = number(Pen, "mm").above(0.0).at_most(MAX_LENGTH).default_text("10, or the value of the settings")
        .of_work(Draw).for_formats(WITHOUT_TEST_GRID);

    "Smallest pen lift, between lines that are close together",
    "The lift is half of the distance between the lines, at most the full lift.",
    hop: Option<f64> = number(Pen, "mm").above(0.0).at_most(MAX_LENGTH).default_value(Number(3.0)).of_work(Draw).for_formats(WITHOUT_TEST_GRID);

    "Travel speed between lines",
    travel_speed: Option<f64> = number(Pen, "mm/s").at_least(MIN_SPEED).at_most(MAX_LENGTH)
        .default_text("200, or the value of the settings").of_work(Draw).for_formats(WITHOUT_TEST_GRID);

    "Leave the pen down at the end and after a stop",
    stay: bool = switch(Pen).contradicts(&["park"]).for_formats(WITHOUT_TEST_GRID);

    "Handling of depths below the surface",
    "Either draw them on the surface, so that the pen never goes below it; or lower the pen to them.",
    depths: Option<Depths> = first_of(Pen, Depths::NAMES).for_formats(WITHOUT_TEST_GRID);

    "Reorder lines for the shortest travel",
    order: Option<bool> = switch_off(Pen, "Draw lines in the order of the file").of_work(Draw).for_formats(DRAWN);

    "Largest gap between line ends to join; 0 disables joining",
    merge: Option<f64> = number(Pen, "mm").at_least(0.0).at_most(MAX_LENGTH).default_value(Number(0.1))
        .for_formats(WITHOUT_TEST_GRID).changes(ONCE_DEDUPED);

    "Draw duplicate lines only once",
    "In a program, the lines are also joined and simplified as those of a drawing, but their order is kept.",
    dedupe: Option<bool> = switch_off(Pen, "Keep duplicate lines")
        .for_formats(WITHOUT_TEST_GRID).changes(&[(PROGRAMS, Change::Default(Switch(false)))]);

    "Tolerance of line simplification: a point is dropped if the line stays within this distance without it; 0 keeps all points",
    simplify: Option<f64> = number(Pen, "mm").at_least(0.0).at_most(MAX_LENGTH).default_value(Number(0.02))
        .for_formats(WITHOUT_TEST_GRID).changes(ONCE_DEDUPED);

    "Tolerance of curve flattening: largest distance of a line from its curve, at the drawn size",
    tolerance: Option<f64> = number(Pen, "mm").above(0.0).at_most(MAX_LENGTH).default_value(Number(0.05))
        .for_formats(&[Svg, Dxf, Hpgl, Letters, Picture, Gcode])
        .changes(&[(IMAGES, Change::Default(Number(0.1)))]);

    "Speed while drawing or burning",
    speed: Option<f64> = number(More, "mm/s").at_least(MIN_SPEED).at_most(MAX_LENGTH)
        .default_text("the value of the file or the settings").for_formats(WITHOUT_TEST_GRID);

    "Speed ratio of point-to-point moves",
    speed_ratio: Option<f64> = number(More, "%").at_least(1.0).at_most(100.0).for_formats(ALL);

    "Position at which to park the tool tip at the end",
    park: Option<[f64; 3]> = place(More).at_least(-MAX_LENGTH).at_most(MAX_LENGTH).for_formats(ALL);

    "Type of machine that a G-code file is for; the pen servo is moved by M3, M280 or M300",
    dialect: Option<Dialect> = choice(More, Dialect::NAMES)
        .default_text("laser if the file switches a spindle or sets a power and has no features of a mill")
        .for_formats(&[Gcode]);

    "Value of S for full laser power in a G-code file",
    s_max: Option<f64> = number(More, "").above(0.0).at_most(1e9).default_text("the value of the file, else 1000").for_formats(&[Gcode]);

    "Z at which the pen touches the surface in placed G-code",
    pen_z: Option<f64> = number(Place, "mm").at_least(-MAX_LENGTH).at_most(MAX_LENGTH)
        .default_text("the first depth at which the program draws").with("place", &[]).for_formats(&[Gcode]);

    "Start position of the tool for a G-code program that does not set it",
    start: Option<[f64; 3]> = place(More).at_least(-MAX_LENGTH).at_most(MAX_LENGTH).default_text("the current position of the tool").for_formats(&[Gcode]);

    "Tolerance of simplifying a recording: points closer than this to the line are dropped",
    "The remaining points keep their times, and the number of steps stays the same.",
    resample: Option<f64> = number(More, "mm").above(0.0).at_most(MAX_LENGTH).for_formats(&[Format::Points]);
}
