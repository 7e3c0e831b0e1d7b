//! Flags shared by verbs that run a file.

mod flags;
mod preset_name;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use magician_program::Format;

pub(crate) use flags::{
    Draws, Engraves, Frames, Grids, Makes, OptionFlags, Plays, RunsAll, Writes,
};

#[cfg(test)]
pub(crate) use flags::OptionSubset;
pub(crate) use preset_name::PresetName;

/// The file.
#[derive(Args, Debug)]
pub(crate) struct File {
    /// File to run; `-` reads stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(super) file: PathBuf,
    /// File type, if neither name nor content shows it: playback, svg, gcode, image, dxf, hpgl,
    /// blockly, points, text, testgrid, plan
    #[arg(long, value_name = "FORMAT")]
    pub(super) format: Option<Format>,
}

/// Looks at what would come, without a move.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Check and preview, without motion")]
pub(crate) struct PreviewFlags {
    /// Only check the file; exit status 10 if the arm cannot do all of it
    #[arg(long)]
    pub(super) check: bool,
    /// Only estimate time and lengths
    #[arg(long)]
    pub(super) estimate: bool,
    /// Only write a preview to a .svg or .png file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) preview: Option<PathBuf>,
    /// Do everything except sending; -v or --json prints the commands
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Only list the parts into which --parts divides the file (default: layers), with name,
    /// colour, lines, length and time
    #[arg(long, conflicts_with_all = ["check", "estimate", "preview", "dry_run"])]
    pub(super) list_parts: bool,
}

/// Flags of a run.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunFlags {
    /// Preset for flags that are not given; `magician preset list` lists presets
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
    /// With --resume: restart a burn this far before the point where the laser went out, along its
    /// line [default: 0]
    #[arg(long, value_name = "MM", requires = "resume", value_parser = non_negative)]
    pub(super) overlap: Option<f64>,
    /// Record the run to a .mcap, .csv or .jsonl file (see `magician record --help`); if writing
    /// fails, the run continues and the exit status is 4
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) record: Option<PathBuf>,
    /// With --record: readings per second of the arm's clock, 1 to 50 [default: 20]
    #[arg(long, value_name = "HZ", requires = "record", value_parser = sample_rate)]
    pub(super) rate: Option<f64>,
    /// With --record: write the units into the second line of a .csv file
    #[arg(long, requires = "record")]
    pub(super) units: bool,
    /// On a virtual arm: write the lines of pen or laser, and the sheet if known, to a .svg or .png
    /// file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) picture: Option<PathBuf>,
    /// With --picture: also show the arm's base
    #[arg(long, requires = "picture")]
    pub(super) whole: bool,
    /// First run the commands that an earlier program left in the queue
    #[arg(long)]
    pub(super) keep: bool,
    /// Refuse to run if the arm was not homed since power-up
    #[arg(long, conflicts_with = "unhomed")]
    pub(super) require_homed: bool,
    /// Run even if the arm is not known to be homed since power-up; positions may be wrong
    #[arg(long)]
    pub(super) unhomed: bool,
    /// Show a full-screen display during the run: drawing progress, time left, queue, line to the
    /// arm
    #[arg(long)]
    pub(super) tui: bool,
}

impl File {
    /// Creates a file that is given as an argument or on stdin, of this format.
    pub(crate) fn from_argument(file: &str, format: Format) -> Self {
        Self {
            file: file.into(),
            format: Some(format),
        }
    }
}

/// Parses a rate in readings a second, 1 to 50: a line at 115,200 baud carries about 50.
fn sample_rate(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| (1.0..=50.0).contains(value));
    value.ok_or_else(|| "expected 1 to 50 readings a second".to_owned())
}

/// Parses a number of at least 0.
fn non_negative(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    let value = value.filter(|value| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| "expected a number from 0".to_owned())
}
