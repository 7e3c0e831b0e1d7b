//! The flags that verbs which run a file share.

mod drawing;

use std::io::Read;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use magician_program::fill::FillMode;
use magician_program::formats::Dialect;
use magician_program::raster::ImageStyle;
use magician_program::{
    Align, Depths, FontChoice, Format, Framing, Grid, Paper, PartMode, PenOptions, Power,
    SetupOptions, SystemFonts, TextLines, Tool, White,
};

pub(crate) use drawing::{
    DrawingFlags, FillFlags, ImageFlags, ImageStyleFlags, PartFlags, TextFlags, TidyFlags,
    TraceFlags,
};

use crate::options::number;
use crate::usage::WrongFile;
use crate::verbs::preset::PresetName;

/// The file.
#[derive(Args, Debug)]
pub(crate) struct File {
    /// File to run; `-` reads stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(super) file: PathBuf,
    /// File type, if neither name nor content shows it: playback, svg, gcode, image, dxf, hpgl, blockly, points, text, testgrid, plan
    #[arg(long, value_name = "FORMAT")]
    pub(super) format: Option<Format>,
    #[command(flatten)]
    reading: ReadingFlags,
}

/// How it is read.
#[derive(Args, Debug, Default)]
pub(crate) struct ReadingFlags {
    /// Machine of a G-code file: pen, laser, or servo (M3, M280 or M300 lifts the pen by an angle); default: laser if the
    /// file switches a spindle or sets a power and has nothing of a mill's
    #[arg(long, value_name = "pen|laser|servo", value_parser = str::parse::<Dialect>)]
    dialect: Option<Dialect>,
    /// S of full laser power in a G-code file ($30 of its controller); default: as the file says, else 1000
    #[arg(long, value_name = "N", value_parser = positive)]
    s_max: Option<f64>,
    /// White lines and shapes of an SVG: `skip` leaves them out, except on darker shapes and where nothing else would be
    /// drawn; `draw` draws them all [default: skip]
    #[arg(long, value_name = "skip|draw", value_parser = str::parse::<White>)]
    white: Option<White>,
    /// Drop points of a recording that are closer than this to the line, mm; the others keep their times. It smooths the way:
    /// the number of steps stays
    #[arg(long, value_name = "MM", value_parser = positive)]
    resample: Option<f64>,
    /// Largest distance of a line from its curve, mm, in the size in which it is drawn [default: 0.05]
    #[arg(long, value_name = "MM", value_parser = positive)]
    tolerance: Option<f64>,
    /// Letters of text in an SVG: `outline` draws their edges, except in fonts whose name begins with Hershey or ends in 1-stroke or
    /// Single Line; `stroke` draws all in single lines
    #[arg(long, value_name = "outline|stroke", value_parser = str::parse::<TextLines>)]
    text: Option<TextLines>,
    /// Text in an SVG: `on` writes it in the fonts that it names where they are installed; `off` in the built-in one alone, on
    /// every machine alike [default: on]
    #[arg(long, value_name = "on|off", value_parser = str::parse::<SystemFonts>)]
    system_fonts: Option<SystemFonts>,
    /// Refuse text if its font lacks a character; otherwise that is left out, with a note
    #[arg(long)]
    strict_text: bool,
}

/// How strong what burns is.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The laser")]
pub(crate) struct LaserFlags {
    /// Scale the laser so that full power is P percent; LEAST..MOST maps all power above 0 to that range
    #[arg(long, value_name = "P|LEAST..MOST", value_parser = power)]
    power: Option<Power>,
}

/// Looks at what would come, without a move.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Look first, move nothing")]
pub(crate) struct PreviewFlags {
    /// Only check: exit status 10 if the arm cannot do all of it
    #[arg(long)]
    pub(super) check: bool,
    /// Only estimate time and lengths
    #[arg(long)]
    pub(super) estimate: bool,
    /// Only draw a preview: a .svg or .png file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) preview: Option<PathBuf>,
    /// Do everything but send; -v or --json prints the commands
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Only list the parts that --parts divides it into (layers unless given): name, colour, lines, length, time
    #[arg(long, conflicts_with_all = ["check", "estimate", "preview", "dry_run"])]
    pub(super) list_parts: bool,
}

/// Where it goes.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Tool and place")]
pub(crate) struct PlacementOptions {
    /// Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm; it stays set on the arm
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    tool: Option<Tool>,
    /// Height of the work surface, mm: the z of `magician pose` when the tool touches it
    #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = number::<f64>)]
    surface: Option<f64>,
    /// Where a G-code program begins, mm; default: where the tool is
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    start: Option<[f64; 3]>,
    /// Place G-code, a plan, a playback file or points like a drawing, its centre at --at, else on the sheet, else where
    /// there is room; implied by --at, --page, --fit, --surface, `draw` and `engrave`
    #[arg(long)]
    place: bool,
    /// Take the file's coordinates as the arm's, unchanged
    #[arg(long, conflicts_with_all = ["place", "at", "page", "fit", "surface"])]
    raw: bool,
    /// Z at which the pen of placed G-code touches the surface, mm; default: the first depth at which it draws
    #[arg(long, value_name = "Z", allow_hyphen_values = true, conflicts_with = "raw", value_parser = number::<f64>)]
    pen_z: Option<f64>,
    /// Depths below the surface: `flatten` draws them on the surface, a pen never goes below it; `keep` takes the pen down to
    /// them [default: flatten]
    #[arg(long, value_name = "flatten|keep", value_parser = str::parse::<Depths>)]
    depths: Option<Depths>,
    /// Put its centre at this x and y, mm
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    at: Option<[f64; 2]>,
    /// Put it on a page of paper, as its file has it on a page of that size, else its centre on the centre of the page: a3, a4,
    /// a5, a6 or letter, each also with -landscape, or WIDTHxHEIGHT in mm. The page lies at --at, else on the calibrated sheet, else where there is room
    #[arg(long, value_name = "NAME|WxH")]
    page: Option<Paper>,
    /// With --page: what --fit makes smaller keeps this far from the edges of the page, mm [default: 10]
    #[arg(long, value_name = "MM", requires = "page", value_parser = from_zero)]
    margin: Option<f64>,
    /// Scale by FACTOR
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    scale: Option<f64>,
    /// Make it this wide, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    width: Option<f64>,
    /// Make it this high, mm
    #[arg(long, value_name = "MM", value_parser = positive, conflicts_with = "width")]
    height: Option<f64>,
    /// Rotate counter-clockwise by DEGREES
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = number::<f64>)]
    rotate: Option<f64>,
    /// Shrink it until the arm reaches all of it, and the page has room for it; rotate it by 90 degrees where that allows a larger
    /// size
    #[arg(long)]
    fit: bool,
    /// Do not rotate it by 90 degrees, neither to fit in front of the arm nor to be larger with --fit
    #[arg(long)]
    no_turn: bool,
    /// Clip a drawing at its page
    #[arg(long)]
    clip_page: bool,
    /// Mirror left to right
    #[arg(long)]
    mirror: bool,
    /// Move by DX,DY,DZ, mm
    #[arg(long = "move", value_name = "DX,DY,DZ", allow_hyphen_values = true, value_parser = numbers::<3>)]
    by: Option<[f64; 3]>,
    /// Repeat it at each position of a grid, such as 2x3:40x30
    #[arg(
        long,
        visible_alias = "pallet",
        value_name = "ROWSxCOLUMNS:DXxDY",
        allow_hyphen_values = true
    )]
    grid: Option<Grid>,
}

/// How fast it works.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The run")]
pub(crate) struct SpeedFlag {
    /// Speed along the lines that are drawn or burnt, mm/s
    #[arg(long, value_name = "MM/S", value_parser = positive)]
    speed: Option<f64>,
}

/// How it moves, and ends.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The run")]
pub(crate) struct MotionFlags {
    /// Speed ratio of point-to-point moves, percent
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    speed_ratio: Option<f64>,
    /// Leave the pen down at the end and after a stop
    #[arg(long, conflicts_with = "park")]
    stay: bool,
    /// At the end, lift the tool and park its tip at this position, mm
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    park: Option<[f64; 3]>,
}

/// How it runs.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The run")]
pub(crate) struct RunFlags {
    #[command(flatten)]
    motion: MotionFlags,
    /// Take flags that are not given from this preset; `magician preset list` lists them
    #[arg(long, value_name = "NAME", value_parser = PresetName, hide_possible_values = true)]
    pub(super) preset: Option<String>,
    /// Repeat N times (0: until Ctrl-C)
    #[arg(long, value_name = "N")]
    pub(super) loops: Option<u64>,
    /// Start at this step, counted from 1
    #[arg(long, value_name = "STEP", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) from: Option<u64>,
    /// Resume the last run of this file where it was interrupted
    #[arg(long, conflicts_with = "from")]
    pub(super) resume: bool,
    /// With --resume: begin MM before the place where the light of a burn went out, along its line [default: 0]
    #[arg(long, value_name = "MM", requires = "resume", value_parser = from_zero)]
    pub(super) overlap: Option<f64>,
    /// Record the run to a .mcap, .csv or .jsonl file; more in `magician record --help`. If writing fails, the run goes
    /// on and the exit status is 4
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) record: Option<PathBuf>,
    /// With --record: readings per second of the arm's clock [default: 20]
    #[arg(long, value_name = "HZ", requires = "record", value_parser = sample_rate)]
    pub(super) rate: Option<f64>,
    /// With --record: in a .csv file, write the units into a second line
    #[arg(long, requires = "record")]
    pub(super) units: bool,
    /// On a virtual arm: write the lines of pen or laser, and the sheet if known, to a .svg or .png file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) picture: Option<PathBuf>,
    /// With --picture: show the arm's base too
    #[arg(long, requires = "picture")]
    pub(super) whole: bool,
    /// First run the commands that an earlier program left in the queue
    #[arg(long)]
    pub(super) keep: bool,
    /// Refuse an arm that was not homed since power-up
    #[arg(long, conflicts_with = "unhomed")]
    pub(super) require_homed: bool,
    /// Run even if the arm is not known to be homed since power-up: it may go to the wrong place
    #[arg(long)]
    pub(super) unhomed: bool,
    /// Full-screen display during the run: the sheet as it fills up, time left, queue, line
    #[arg(long)]
    pub(super) tui: bool,
}

/// How lines are drawn with a pen.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The pen")]
pub(crate) struct Pen {
    /// Pen lift between lines, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    lift: Option<f64>,
    /// Least pen lift between lines that are near each other, mm; it is half of the way between them, up to --lift [default: 3]
    #[arg(long, value_name = "MM", value_parser = positive)]
    hop: Option<f64>,
    /// Speed between lines, mm/s
    #[arg(long, value_name = "MM/S", value_parser = positive)]
    travel_speed: Option<f64>,
    /// Draw the lines in the order of the file
    #[arg(long)]
    no_order: bool,
}

impl File {
    /// What an argument or stdin says, of this format.
    pub(crate) fn given(file: &str, format: Format) -> Self {
        Self {
            file: file.into(),
            format: Some(format),
            reading: ReadingFlags::default(),
        }
    }

    pub(super) fn say(&self, options: &mut SetupOptions) {
        self.reading.say(options);
    }
}

impl ReadingFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.dialect = self.dialect;
        options.s_max = self.s_max;
        options.white = self.white;
        options.resample = self.resample;
        options.tolerance = self.tolerance;
        options.text = self.text;
        options.system_fonts = self.system_fonts;
        options.strict_text = self.strict_text;
    }
}

impl LaserFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.power = self.power;
    }
}

impl PlacementOptions {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.tool = self.tool;
        options.surface = self.surface;
        options.start = self.start;
        options.place = self.place;
        options.raw = self.raw;
        options.pen_z = self.pen_z;
        options.depths = self.depths;
        options.at = self.at;
        options.scale = self.scale;
        options.width = self.width;
        options.height = self.height;
        options.rotate = self.rotate;
        options.fit = self.fit;
        options.turn = self.no_turn.then_some(false);
        options.page = self.page;
        options.margin = self.margin;
        options.clip_page = self.clip_page;
        options.mirror = self.mirror;
        options.by = self.by;
        options.grid = self.grid;
    }
}

impl SpeedFlag {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.speed = self.speed;
    }
}

impl MotionFlags {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.speed_ratio = self.speed_ratio;
        options.stay = self.stay;
        options.park = self.park;
    }
}

impl RunFlags {
    pub(super) fn say(&self, options: &mut SetupOptions) {
        self.motion.say(options);
    }
}

impl Pen {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.lift = self.lift;
        options.hop = self.hop;
        options.travel_speed = self.travel_speed;
        options.order = self.no_order.then_some(false);
    }
}

/// Numbers with commas between them.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parsed = parsed
        .ok()
        .filter(|all| all.iter().all(|number| number.is_finite()));
    parsed
        .and_then(|all| all.try_into().ok())
        .ok_or_else(|| format!("expected {N} numbers with commas between them"))
}

/// The pens of a file.
#[derive(Clone, Debug, Default)]
struct Pens(Vec<PenOptions>);

fn pens(path: &str) -> Result<Pens, WrongFile> {
    let read = magician_job::pens::read(path.as_ref());
    read.map(Pens).map_err(WrongFile)
}

/// A font that is built in, or a file.
fn font(text: &str) -> Result<FontChoice, String> {
    /// The largest file of a font that is read, bytes.
    const LARGEST: u64 = 128 << 20;
    text.parse().or_else(|unknown| {
        let read = std::fs::File::open(text).and_then(|file| {
            let mut bytes = Vec::new();
            file.take(LARGEST).read_to_end(&mut bytes)?;
            Ok(bytes)
        });
        let bytes = read.map_err(|error| format!("{unknown}; as a file: {error}"))?;
        Ok(FontChoice::file(text, bytes))
    })
}

/// Power of what is to burn: above 0.
fn power(text: &str) -> Result<Power, String> {
    let power = text.parse::<Power>()?;
    match power.range() {
        [_, most] if most > 0.0 => Ok(power),
        _ => Err("expected percent above 0, such as 80 or 5..80".to_owned()),
    }
}

/// Power of a laser that lights a frame.
pub(crate) fn frame_power(text: &str) -> Result<f64, String> {
    let most = Framing::MOST_POWER;
    let power = text.trim_end_matches('%').parse::<f64>().ok();
    power
        .filter(|power| *power > 0.0 && *power <= most)
        .ok_or_else(|| format!("expected percent above 0 and at most {most}"))
}

/// Above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".to_owned())
}

/// Readings a second: a line at 115200 baud carries about 50.
fn sample_rate(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| (1.0..=50.0).contains(value));
    value.ok_or_else(|| "expected 1 to 50 readings a second".to_owned())
}

/// 0 or above.
fn from_zero(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| "expected a number from 0".to_owned())
}

/// -100 to 100.
fn of_100(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| (-100.0..=100.0).contains(value));
    value.ok_or_else(|| "expected a number from -100 to 100".to_owned())
}

/// Four whole numbers of pixels, the last two above 0.
fn crop(text: &str) -> Result<[u32; 4], String> {
    let parsed: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parsed = parsed.ok().and_then(|all| <[u32; 4]>::try_from(all).ok());
    parsed
        .filter(|[_, _, width, height]| *width > 0 && *height > 0)
        .ok_or_else(|| "expected X,Y,W,H in pixels, such as 100,50,800,600".to_owned())
}

/// 1 to 100.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    let value = text.trim_end_matches('%').parse::<f64>().ok();
    value
        .filter(|value| (1.0..=100.0).contains(value))
        .ok_or_else(|| "expected 1 to 100 percent".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_commas_between_them() {
        assert_eq!(numbers::<3>("1,-2, 3.5"), Ok([1.0, -2.0, 3.5]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,inf", "a,b,c"] {
            assert!(numbers::<3>(wrong).is_err(), "{wrong}");
        }
    }
}
