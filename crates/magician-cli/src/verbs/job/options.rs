//! The flags that verbs which run a file share.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueHint};
use magician_program::formats::Dialect;
use magician_program::raster::{Size, Trace};
use magician_program::{Format, Power, Tool, White};

use crate::options::number;

/// The file.
#[derive(Args, Debug)]
pub(crate) struct File {
    /// File to run; `-` reads it from stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(super) file: PathBuf,
    /// File type, if name and content do not tell: playback, svg, gcode, image, dxf, hpgl, blockly, points, plan
    #[arg(long, value_name = "FORMAT")]
    pub(super) format: Option<Format>,
    /// What a G-code file is for: pen, laser, or servo (a pen that M3, M280 or M300 lifts by angles); if not given, a laser
    /// where it switches a spindle or sets a power and nothing in it is a mill's
    #[arg(long, value_name = "pen|laser|servo", value_parser = dialect)]
    pub(super) dialect: Option<Dialect>,
    /// The S of a G-code file that is the laser's full power ($30 of its controller); if not given, what the file says of it,
    /// else 1000
    #[arg(long, value_name = "N", value_parser = positive)]
    pub(super) s_max: Option<f64>,
    /// White lines and shapes of an SVG: `skip` leaves them out, but on darker shapes and where nothing else would be drawn,
    /// `draw` draws them all
    #[arg(
        long,
        value_name = "skip|draw",
        default_value = "skip",
        hide_default_value = true
    )]
    pub(super) white: White,
    /// Leave out points of a recording nearer than this to the line, mm; the others keep their times
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) resample: Option<f64>,
}

/// How strong what burns is.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The laser")]
pub(crate) struct Beam {
    /// Make full power P percent, of whatever burns; with LEAST..MOST all that is above 0 is from LEAST to MOST
    #[arg(long, value_name = "P|LEAST..MOST", value_parser = power)]
    pub(super) power: Option<Power>,
}

/// Looks at what would come, without a move.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Look first, move nothing")]
pub(crate) struct Look {
    /// Only check it: exit status 10 if the arm cannot do all of it
    #[arg(long)]
    pub(super) check: bool,
    /// Only estimate its time and lengths
    #[arg(long)]
    pub(super) estimate: bool,
    /// Only draw a preview: a .svg or .png file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) preview: Option<PathBuf>,
    /// Do everything but send it; -v or --json prints the commands
    #[arg(long)]
    pub(super) dry_run: bool,
}

/// Where it goes.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Tool and place")]
pub(crate) struct Place {
    /// Tool on the arm: none, suction, gripper, pen, laser, or its bias X,Y,Z in mm; the arm keeps it
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    pub(super) tool: Option<Tool>,
    /// Height of the paper or the wood: the z of `magician pose` when the tool touches it, mm
    #[arg(long, value_name = "Z", allow_hyphen_values = true, value_parser = number::<f64>)]
    pub(super) surface: Option<f64>,
    /// Where the tool stands when a G-code program begins, mm; where it is, if not given
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub(super) start: Option<[f64; 3]>,
    /// Take the coordinates of G-code, a plan, a playback file or points as the file's own, and place it: the middle of what it
    /// draws at --at, else on the sheet, else where there is room. --at, --fit and --surface imply it, `draw` and `engrave` too
    #[arg(long)]
    pub(super) place: bool,
    /// Take its coordinates as the arm's, as they stand
    #[arg(long, conflicts_with_all = ["place", "at", "fit", "surface"])]
    pub(super) raw: bool,
    /// Z of placed G-code at which its pen touches the surface, mm; the lowest at which it draws, if not given
    #[arg(long, value_name = "Z", allow_hyphen_values = true, conflicts_with = "raw", value_parser = number::<f64>)]
    pub(super) pen_z: Option<f64>,
    /// Put its middle at this x and y, mm
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    pub(super) at: Option<[f64; 2]>,
    /// Scale it by FACTOR
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub(super) scale: Option<f64>,
    /// Rotate it counter-clockwise, degrees
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = number::<f64>)]
    pub(super) rotate: Option<f64>,
    /// Shrink it until the arm reaches all of it, turned by 90 degrees where that lets it be larger
    #[arg(long)]
    pub(super) fit: bool,
    /// With --fit: do not turn it
    #[arg(long, requires = "fit")]
    pub(super) no_turn: bool,
    /// Cut off what lies beyond the page of a drawing
    #[arg(long)]
    pub(super) clip_page: bool,
    /// Mirror it, left to right
    #[arg(long)]
    pub(super) mirror: bool,
    /// Move it by so much, mm
    #[arg(long = "move", value_name = "DX,DY,DZ", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub(super) by: Option<[f64; 3]>,
    /// Do it once at each place of a grid, such as 2x3:40x30
    #[arg(
        long,
        visible_alias = "pallet",
        value_name = "ROWSxCOLUMNS:DXxDY",
        allow_hyphen_values = true
    )]
    pub(super) grid: Option<Grid>,
}

/// How it runs.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The run")]
pub(crate) struct Way {
    /// Speed of the tool along lines that it draws or burns, mm/s
    #[arg(long, value_name = "MM/S", value_parser = positive)]
    pub(super) speed: Option<f64>,
    /// Share of the set speed for moves from point to point, percent
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(super) speed_ratio: Option<f64>,
    /// Repeat it N times (0: until Ctrl-C)
    #[arg(long, value_name = "N")]
    pub(super) loops: Option<u64>,
    /// Begin at this step, counted from 1
    #[arg(long, value_name = "STEP", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) from: Option<u64>,
    /// Resume the last run of this file where it was interrupted
    #[arg(long, conflicts_with = "from")]
    pub(super) resume: bool,
    /// Write what the arm does meanwhile to a .mcap, .csv or .jsonl file; `magician record --help` has more. If it cannot be
    /// written any more the work goes on, and the exit status is 4
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) record: Option<PathBuf>,
    /// On a virtual arm: write what pen or laser left, and the sheet if it is known, to a .svg or .png file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) picture: Option<PathBuf>,
    /// With --picture: the arm's base too
    #[arg(long, requires = "picture")]
    pub(super) whole: bool,
    /// Run what an earlier program left in the queue first
    #[arg(long)]
    pub(super) keep: bool,
    /// Refuse an arm that was not homed since it was switched on
    #[arg(long, conflicts_with = "unhomed")]
    pub(super) require_homed: bool,
    /// Draw or engrave with an arm that was not homed since it was switched on: it may go to the wrong place
    #[arg(long)]
    pub(super) unhomed: bool,
    /// Take the whole terminal while it runs: the sheet as it fills up, the time left, the queue, the line
    #[arg(long)]
    pub(super) tui: bool,
    /// Leave the pen down at the end and after a stop
    #[arg(long, conflicts_with = "park")]
    pub(super) stay: bool,
    /// When all is done, go up and park the tool's tip at this place, mm
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub(super) park: Option<[f64; 3]>,
}

/// How lines are drawn with a pen.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "The pen")]
pub(crate) struct Pen {
    /// How far the pen is lifted between lines, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) lift: Option<f64>,
    /// Speed between lines, mm/s
    #[arg(long, value_name = "MM/S", value_parser = positive)]
    pub(super) travel_speed: Option<f64>,
    /// Draw the lines in the order of the file
    #[arg(long)]
    pub(super) no_order: bool,
    /// How far a line may be from the curve that it stands for, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) tolerance: Option<f64>,
    /// Of an image: what is darker is outlined, 1 to 255
    #[arg(long, value_name = "GREY", value_parser = clap::value_parser!(u8).range(1..))]
    pub(super) threshold: Option<u8>,
    /// Width of an image, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(super) width: Option<f64>,
}

impl Pen {
    /// The usual pen, lifted so far.
    pub(crate) fn lifted(lift: Option<f64>) -> Self {
        Self {
            lift,
            ..Self::default()
        }
    }

    /// How the outlines of an image are found.
    pub(crate) fn trace(&self) -> Trace {
        let mut trace = Trace::default();
        trace.level = self.threshold.unwrap_or(trace.level);
        trace.tolerance = self.tolerance.unwrap_or(trace.tolerance);
        trace
    }

    /// How large an image becomes.
    pub(crate) fn size(&self) -> Size {
        self.width.map_or(Size::Natural, Size::Width)
    }
}

/// Places in rows and columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// From one column to the next in x, from one row to the next in y, mm.
    pub(super) pitch: [f64; 2],
}

impl FromStr for Grid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = (|| {
            let (counts, pitch) = text.split_once(':')?;
            let (rows, columns) = counts.split_once('x')?;
            let (dx, dy) = pitch.split_once('x')?;
            let grid = Self {
                rows: rows.trim().parse().ok().filter(|count| *count > 0)?,
                columns: columns.trim().parse().ok().filter(|count| *count > 0)?,
                pitch: [dx.trim().parse().ok()?, dy.trim().parse().ok()?],
            };
            let finite = grid.pitch.iter().all(|pitch: &f64| pitch.is_finite());
            finite.then_some(grid)
        })();
        parsed.ok_or_else(|| "expected ROWSxCOLUMNS:DXxDY, such as 2x3:40x30".to_owned())
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

/// Whom G-code is for.
fn dialect(text: &str) -> Result<Dialect, String> {
    match text {
        "pen" => Ok(Dialect::Pen),
        "laser" => Ok(Dialect::Laser),
        "servo" => Ok(Dialect::Servo),
        _ => Err("expected pen, laser or servo".to_owned()),
    }
}

/// Power of what is to burn: above 0.
fn power(text: &str) -> Result<Power, String> {
    let power = text.parse::<Power>()?;
    match power.range() {
        [_, most] if most > 0.0 => Ok(power),
        _ => Err("expected percent above 0, such as 80 or 5..80".to_owned()),
    }
}

/// Above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".to_owned())
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
    fn grids_and_numbers() {
        let grid = Grid {
            rows: 2,
            columns: 3,
            pitch: [40.0, -30.5],
        };
        assert_eq!("2x3:40x-30.5".parse(), Ok(grid));
        for wrong in ["", "2x3", "0x3:1x1", "2x3:1", "axb:1x1", "2x3:nanx1"] {
            assert!(wrong.parse::<Grid>().is_err(), "{wrong}");
        }
        assert_eq!(numbers::<3>("1,-2, 3.5"), Ok([1.0, -2.0, 3.5]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,inf", "a,b,c"] {
            assert!(numbers::<3>(wrong).is_err(), "{wrong}");
        }
    }
}
