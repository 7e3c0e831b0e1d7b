//! Table of all options, deliberately in one file: one row each. To add an option, add its row here
//! and use its value.
//!
//! A row has its help sentence (with further text for where there is room), its member of
//! [`SetupOptions`] with its type, and its facts. Everything else is derived from it: parsing of
//! JSON, command lines, presets and keywords, checks, the form of the page, and the tables in the
//! docs.

use serde_json::Value;

use super::spec::{
    Change, area, choice, first_of, integer, list, number, pens, place, point, switch, switch_off,
    text,
};
use super::value::Member;
use super::{Grid, ModeOption, OptionSpec, PenOptions, WorkOption};
use crate::Format::{self, Dxf, Gcode, Hpgl, Image as Picture, Svg, TestGrid, Text as Letters};
use crate::fill::{FillMode, LEAST_SPACING};
use crate::formats::Dialect;
use crate::lettering::{Align, FontChoice};
use crate::raster::{ImageStyle, Trace};
use crate::setup::MOST_PASSES;
use crate::{
    BundledFont, Depths, FrameShape, Framing, Page, Paper, PartMode, Power, SystemFonts, TextLines,
    Tool, White,
};

use super::DefaultValue::{Number, Switch};
use super::OptionGroup::{Fill, Image, Laser, More, Parts, Pen, Place, Text};
use WorkOption::{Draw, Engrave};

/// Largest length and coordinate, mm: far beyond every sheet and arm, while an `f32` of this size,
/// as the arm uses, still resolves micrometres.
const FAR: f64 = 10_000.0;
/// Smallest speed, mm/s: a slower arm looks like one at rest.
const LEAST_SPEED: f64 = 0.01;
/// Largest angle, degrees: a hundred turns.
const MOST_DEGREES: f64 = 36_000.0;

const ALL: &[Format] = &Format::ALL;
/// Formats whose file does not define the settings of a run.
const NO_GRID: &[Format] = &[
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
const FILLED: &[&str] = &["hatch", "cross", "contour"];

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
                    $(name!($field $($name)?) => self.$field = Member::read(value)?,)*
                    _ => return Err(None),
                }
                Ok(())
            }

            /// Returns the value of each option in the order of the rows; `None` if it is not set.
            pub(super) fn values(&self) -> Vec<(&'static OptionSpec, Option<Value>)> {
                let values = [$(self.$field.given(),)*];
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
                let under = under.agreeing_with(self);
                Self {
                    $($field: if self.$field.is_open() { &under.$field } else { &self.$field }.clone(),)*
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
    "Work that is made of drawings and images: the pen draws, or the laser engraves",
    "Without it the tool decides: the laser engraves, every other tool draws.",
    work: Option<WorkOption> = choice(More, WorkOption::NAMES);

    "Font of text: a built-in one, or a file",
    "The letters of a built-in font are single lines. A file is TrueType, OpenType, an SVG font, or the order of strokes of Chinese and \
     Japanese characters (KanjiVG, hanzi-writer).",
    font: Option<FontChoice> = first_of(Text, BundledFont::NAMES)
        .expects("sans, script or gothic", "NAME|FILE")
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Height of a capital in text",
    size: Option<f64> = number(Text, "mm").above(0.0).to(FAR).or(Number(10.0))
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Width at which lines of text are broken",
    wrap: Option<f64> = number(Text, "mm").above(0.0).to(FAR)
        .for_formats(&[Letters]).usual_for(&[Letters]);

    "Place a program (G-code, a plan, playback, points) like a drawing",
    "Its centre goes to the given point, else onto the sheet, else where there is room. A point, a page, a surface, fitting and both works imply it.",
    place: bool = switch(Place).for_formats(PROGRAMS).usual_for(&[Gcode]);

    "Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm",
    "It stays set on the arm.",
    tool: Option<Tool> = first_of(Place, &["pen", "laser"])
        .expects("none, suction, gripper, pen, laser, or its bias X,Y,Z in mm", "NAME|X,Y,Z")
        .for_formats(NO_GRID).usual_for(&[Svg, Dxf, Hpgl, Picture, Letters, Gcode])
        .changes(ONCE_PLACED);

    "Fill visible shapes, and letters of outline fonts, with lines",
    "Parallel lines, others across them as well, or rings from the edge inwards; without them shapes are outlined.",
    fill: Option<FillMode> = first_of(Fill, FillMode::NAMES).for_formats(ARTWORK).usual_for(&[Svg]);

    "Treatment of an image that the pen draws",
    "Edges of what is dark, one stroke along each dark line, dots, swinging lines, or crossed hatchings; the last three keep its greys.",
    image: Option<ImageStyle> = first_of(Image, ImageStyle::NAMES)
        .of_work(Draw).for_formats(IMAGES).usual_for(IMAGES);

    "Height of the work surface",
    "It is the z of the arm's pose when the tool touches it.",
    surface: Option<f64> = number(Place, "mm").from(-FAR).to(FAR)
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED);

    "Position of its centre",
    at: Option<[f64; 2]> = point(Place).from(-FAR).to(FAR)
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED);

    "Scale factor; 1 is the true size",
    "With a width or a height it multiplies that size.",
    scale: Option<f64> = number(Place, "").above(0.0).to(FAR).or(Number(1.0))
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, TestGrid, Gcode]).changes(ONCE_PLACED_GCODE);

    "Width that it is scaled to",
    width: Option<f64> = number(Place, "mm").above(0.0).to(FAR)
        .for_formats(NO_GRID).usual_for(IMAGES).changes(ONCE_PLACED);

    "Counter-clockwise rotation",
    rotate: Option<f64> = number(Place, "deg").from(-MOST_DEGREES).to(MOST_DEGREES).or(Number(0.0))
        .for_formats(ALL).usual_for(&[Svg, Dxf, Hpgl, Letters, Picture, TestGrid, Gcode])
        .changes(ONCE_PLACED_GCODE);

    "Shrink it until the arm reaches all of it, and the page has room for it",
    fit: bool = switch(Place).for_formats(ALL).usual_for(PLACED).changes(ONCE_PLACED);

    "Height that it is scaled to, instead of a width",
    height: Option<f64> = number(Place, "mm").above(0.0).to(FAR).contradicts(&["width"])
        .for_formats(NO_GRID).changes(ONCE_PLACED);

    "Clip a drawing at its page",
    clip_page: bool = switch(Place).for_formats(DRAWINGS);

    "Page of paper that it lies on; a size in mm, such as 200x150, is taken too",
    "It lies there as its file has it on a page of that size, else centre on centre. The page lies at the given point, else on the \
     calibrated sheet, else where there is room.",
    page: Option<Paper> = choice(Place, Paper::NAMES)
        .expects("a3, a4, a5, a6 or letter, each also with -landscape, or WIDTHxHEIGHT in mm, such as 200x150", "NAME|WxH")
        .for_formats(ALL).changes(ONCE_PLACED);

    "Distance from the edges of the page that fitting keeps",
    margin: Option<f64> = number(Place, "mm").from(0.0).to(FAR).or(Number(Page::MARGIN))
        .needs("page", &[]).for_formats(ALL);

    "Rotate it by 90 degrees where that fits better",
    turn: Option<bool> = switch_off(
        Place,
        "Never rotate it by 90 degrees, neither to lie in front of the arm nor to be larger",
    ).for_formats(PLACED);

    "Mirror it left to right",
    mirror: bool = switch(Place).for_formats(ALL);

    "Shift from where it lies",
    by as "move": Option<[f64; 3]> = place(Place).from(-FAR).to(FAR).expects("", "DX,DY,DZ").for_formats(ALL);

    "Repeat it at each position of a grid, such as 2x3:40x30",
    grid: Option<Grid> = text(Place, "")
        .expects("ROWSxCOLUMNS:DXxDY, such as 2x3:40x30", "ROWSxCOLUMNS:DXxDY").for_formats(ALL);

    "Take the coordinates of the file as the arm's, unchanged",
    raw: bool = switch(More).contradicts(&["place", "at", "page", "fit", "surface", "pen_z"])
        .for_formats(PROGRAMS);

    "Distance of the lines that fill a shape",
    "It is measured on the surface, whatever the scale.",
    fill_spacing: Option<f64> = number(Fill, "mm").from(LEAST_SPACING).to(FAR)
        .usually("0.8 with the pen, 0.2 with the laser").needs("fill", FILLED).for_formats(ARTWORK);

    "Direction of the lines that fill a shape, counter-clockwise from x",
    fill_angle: Option<f64> = number(Fill, "deg").from(-MOST_DEGREES).to(MOST_DEGREES).or(Number(45.0))
        .needs("fill", FILLED).with("fill", &["hatch", "cross"]).for_formats(ARTWORK);

    "Distance of the lines that fill a shape from its edge",
    fill_inset: Option<f64> = number(Fill, "mm").from(0.0).to(FAR)
        .usually("half the distance of the lines").needs("fill", FILLED).for_formats(ARTWORK);

    "Treatment of white lines and shapes",
    "They are left out, except on darker shapes and where nothing else would be drawn; or all are drawn.",
    white: Option<White> = first_of(Fill, White::NAMES).for_formats(ARTWORK);

    "Alignment of lines of text",
    align: Option<Align> = first_of(Text, Align::NAMES).for_formats(&[Letters]);

    "Distance from one line of text to the next, in heights of a capital",
    line_height: Option<f64> = number(Text, "").above(0.0).to(1000.0).or(Number(1.8)).for_formats(&[Letters]);

    "Treatment of the letters of texts in a drawing",
    "Their edges, except in fonts whose name begins with Hershey or ends in 1-stroke or Single Line; or all in single lines.",
    text: Option<TextLines> = first_of(Text, TextLines::NAMES).for_formats(&[Svg]);

    "Use of the installed fonts that texts in a drawing name",
    "Without them all is written in the built-in font, on every machine alike.",
    system_fonts: Option<SystemFonts> = first_of(Text, SystemFonts::NAMES).for_formats(&[Svg]);

    "Refuse text if its font lacks a character; otherwise that is left out, with a note",
    strict_text: bool = switch(Text).for_formats(ARTWORK);

    "Division of a drawing into parts, between which the job pauses for a change of the pen",
    "Layers (also pens of a plot and tools of G-code), or colours. Layers are taken where parts are chosen or have pens, and if names \
     of Inkscape layers have % or !; else there are no parts.",
    parts: Option<PartMode> = choice(Parts, PartMode::NAMES)
        .for_formats(&[Svg, Dxf, Hpgl, Gcode]);

    "Parts that are drawn, each by its name, its colour (#rrggbb or of CSS) or its number",
    "Without them all parts are drawn.",
    only: Vec<String> = list(Parts).expects("a list of texts of at most 1000 characters", "NAME").for_formats(DRAWINGS);

    "Number of times that each part is drawn before the next",
    passes: Option<u32> = integer(Parts).from(1.0).to(MOST_PASSES as f64).or(Number(1.0)).for_formats(NO_GRID);

    "Pens of the parts; the first that is for a part counts",
    "Each has a match (a name, a colour or a number) and any of surface_offset, lift, speed, power, passes and fill.",
    pens: Vec<PenOptions> = pens(Parts).for_formats(DRAWINGS);

    "Never pause for a person, neither between parts nor where the program says so",
    no_pause: bool = switch(Parts).for_formats(NO_GRID);

    "Number of hatchings that are laid over each other, or of sizes of dots",
    levels: Option<u8> = integer(Image).from(1.0).to(64.0).usually("6 hatchings, 64 sizes of dots")
        .needs("image", &["halftone", "hatch"]).of_work(Draw).for_formats(IMAGES);

    "Size of the largest spots of an image that are left out; 0 keeps all",
    despeckle: Option<f64> = number(Image, "mm").from(0.0).to(FAR).or(Number(0.3)).of_work(Draw).for_formats(IMAGES);

    "Width of the line that the pen draws, for an image",
    pen_width: Option<f64> = number(Image, "mm").above(0.0).to(FAR).or(Number(Trace::PEN_WIDTH))
        .of_work(Draw).for_formats(IMAGES);

    "Distance between the lines or dots of an image",
    spacing: Option<f64> = number(Image, "mm").above(0.0).to(FAR)
        .usually("0.2 with the laser; with the pen by its treatment and its width").for_formats(IMAGES);

    "Grey below which an image counts as dark, where it is drawn or burnt in black and white",
    threshold: Option<u8> = integer(Image).from(1.0).to(255.0).or(Number(128.0)).for_formats(IMAGES);

    "Part of an image that is kept, in its pixels from the upper left corner",
    crop: Option<[u32; 4]> = area(Image).for_formats(IMAGES);

    "Lightening of an image",
    brightness: Option<f64> = number(Image, "").from(-100.0).to(100.0).or(Number(0.0)).for_formats(IMAGES);

    "Additional contrast of an image",
    contrast: Option<f64> = number(Image, "").from(-100.0).to(100.0).or(Number(0.0)).for_formats(IMAGES);

    "Exponent of the darkness; above 1 makes mid-tones lighter",
    gamma: Option<f64> = number(Image, "").above(0.0).to(100.0).or(Number(1.0)).for_formats(IMAGES);

    "Draw or burn what is white instead of what is black",
    invert: bool = switch(Image).for_formats(IMAGES);

    "Full power of the laser, or the range of all power above 0, such as 5..80",
    power: Option<Power> = text(Laser, "%")
        .expects("percent above 0 and at most 100, such as 80 or 5..80", "P|LEAST..MOST")
        .with("tool", &["laser"]).of_work(Engrave).for_formats(NO_GRID);

    "Use of grey levels: as power, in black and white, or as denser dots",
    mode: Option<ModeOption> = first_of(Laser, ModeOption::NAMES).of_work(Engrave).for_formats(IMAGES);

    "Burn all lines in the same direction: slower, but free of backlash",
    one_way: bool = switch(Laser).of_work(Engrave).for_formats(&[Picture, TestGrid]);

    "Run-up and run-out of the tool at the ends of a line",
    overscan: Option<f64> = number(Laser, "mm").above(0.0).to(FAR).usually("as the speed needs")
        .of_work(Engrave).for_formats(&[Picture, TestGrid]);

    "Go round what would be marked, instead of marking it",
    "Its box along X and Y, its convex hull, or its outer contours.",
    frame: Option<FrameShape> = choice(Laser, FrameShape::NAMES).for_formats(ALL);

    "Power of the laser on a frame",
    "Without it the laser is off.",
    frame_power: Option<f64> = number(Laser, "%").above(0.0).to(Framing::MOST_POWER)
        .needs("frame", &[]).for_formats(ALL);

    "Pen lift between lines",
    lift: Option<f64> = number(Pen, "mm").above(0.0).to(FAR).usually("10, or as the settings say")
        .of_work(Draw).for_formats(NO_GRID);

    "Least pen lift, between lines that are near each other",
    "It is half of the way between them, up to the whole lift.",
    hop: Option<f64> = number(Pen, "mm").above(0.0).to(FAR).or(Number(3.0)).of_work(Draw).for_formats(NO_GRID);

    "Speed between lines",
    travel_speed: Option<f64> = number(Pen, "mm/s").from(LEAST_SPEED).to(FAR)
        .usually("200, or as the settings say").of_work(Draw).for_formats(NO_GRID);

    "Leave the pen down at the end and after a stop",
    stay: bool = switch(Pen).contradicts(&["park"]).for_formats(NO_GRID);

    "Treatment of depths below the surface",
    "They are drawn on the surface, and a pen never goes below it; or the pen goes down to them.",
    depths: Option<Depths> = first_of(Pen, Depths::NAMES).for_formats(NO_GRID);

    "Draw lines in the order that travels least",
    order: Option<bool> = switch_off(Pen, "Draw lines in the order of the file").of_work(Draw).for_formats(DRAWN);

    "Largest gap between ends of lines that are joined; 0 joins none",
    merge: Option<f64> = number(Pen, "mm").from(0.0).to(FAR).or(Number(0.1))
        .for_formats(NO_GRID).changes(ONCE_DEDUPED);

    "Draw a line that is there twice once",
    "In a program it tidies the lines as those of a drawing, but leaves their order.",
    dedupe: Option<bool> = switch_off(Pen, "Draw a line that is there twice as often as it is there")
        .for_formats(NO_GRID).changes(&[(PROGRAMS, Change::Default(Switch(false)))]);

    "Distance below which a point is left out whose line goes on almost the same without it; 0 keeps all",
    simplify: Option<f64> = number(Pen, "mm").from(0.0).to(FAR).or(Number(0.02))
        .for_formats(NO_GRID).changes(ONCE_DEDUPED);

    "Largest distance of a line from its curve, in the size in which it is drawn",
    tolerance: Option<f64> = number(Pen, "mm").above(0.0).to(FAR).or(Number(0.05))
        .for_formats(&[Svg, Dxf, Hpgl, Letters, Picture, Gcode])
        .changes(&[(IMAGES, Change::Default(Number(0.1)))]);

    "Speed along the lines that are drawn or burnt",
    speed: Option<f64> = number(More, "mm/s").from(LEAST_SPEED).to(FAR)
        .usually("as the file or the settings say").for_formats(NO_GRID);

    "Speed ratio of point-to-point moves",
    speed_ratio: Option<f64> = number(More, "%").from(1.0).to(100.0).for_formats(ALL);

    "Position where the tip of the tool is parked at the end",
    park: Option<[f64; 3]> = place(More).from(-FAR).to(FAR).for_formats(ALL);

    "Machine of a G-code file; the servo of a pen is moved by M3, M280 or M300",
    dialect: Option<Dialect> = choice(More, Dialect::NAMES)
        .usually("the laser if the file switches a spindle or sets a power and has nothing of a mill's")
        .for_formats(&[Gcode]);

    "S of full laser power in a G-code file",
    s_max: Option<f64> = number(More, "").above(0.0).to(1e9).usually("as the file says, else 1000").for_formats(&[Gcode]);

    "Z at which the pen of placed G-code touches the surface",
    pen_z: Option<f64> = number(Place, "mm").from(-FAR).to(FAR)
        .usually("the first depth at which it draws").with("place", &[]).for_formats(&[Gcode]);

    "Position of the tool where a G-code program begins that does not say so",
    start: Option<[f64; 3]> = place(More).from(-FAR).to(FAR).usually("where the tool is").for_formats(&[Gcode]);

    "Distance below which points of a recording are left out that are close to the line",
    "The others keep their times, and the number of steps stays.",
    resample: Option<f64> = number(More, "mm").above(0.0).to(FAR).for_formats(&[Format::Points]);
}
