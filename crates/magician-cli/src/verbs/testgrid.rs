//! `testgrid`: burns squares of many powers and speeds, to find settings for a material.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use magician_program::{Format, Series, TestGridOptions, WorkOption};

use super::convert;
use super::job::Job;
use super::job::options::{File, Grids, OptionFlags, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::positive;

/// Burn squares at many powers and speeds, to find settings for a material
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician testgrid --preview grid.png                    preview the grid and its position
  magician testgrid --power 20:80:4 --speed 10:30:3 --yes
  magician testgrid grid.plan.json                        a plan, to run later
  magician testgrid --port sim --picture grid.png

Columns are powers in percent, rows are speeds in mm/s: FROM:TO:COUNT. Each cell is burnt as \
`magician engrave` burns a black image at that power and speed, at full speed throughout: the laser \
is off while the arm accelerates. Labels are burnt at the lowest power and the highest speed.

The grid is placed like a drawing. `engrave.power` of `magician config` does not affect its powers. \
On a real arm nothing burns without --yes.")]
pub(crate) struct TestGrid {
    /// Write the plan to this file instead of running it: .plan.json, .playback, .svg, .png, .csv
    #[arg(value_hint = ValueHint::FilePath)]
    to: Option<PathBuf>,
    /// Powers of the columns, percent
    #[arg(long, value_name = "FROM:TO:COUNT", default_value = "10:100:5", value_parser = str::parse::<Series>)]
    power: Series,
    /// Speeds of the rows, mm/s
    #[arg(long, value_name = "FROM:TO:COUNT", default_value = "5:40:5", value_parser = str::parse::<Series>)]
    speed: Series,
    /// Side of a cell; the gap between cells is a quarter of it
    #[arg(long, value_name = "MM", default_value = "8", value_parser = positive)]
    cell: f64,
    /// Distance between the lines of a cell
    #[arg(long, value_name = "MM", default_value = "0.2", value_parser = positive)]
    spacing: f64,
    /// Do not burn labels
    #[arg(long)]
    no_labels: bool,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Grids>,
    #[command(flatten)]
    way: RunFlags,
}

impl TestGrid {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut grid = TestGridOptions::default();
        grid.power = self.power;
        grid.speed = self.speed;
        grid.cell = self.cell;
        grid.spacing = self.spacing;
        grid.labels = !self.no_labels;
        grid.check()
            .map_err(|(flag, message)| Failure::usage(format!("--{flag}: {message}")))?;
        let file = File::from_argument("test grid", Format::TestGrid);
        let work = WorkOption::Engrave;
        let looks = self.look.is_wanted();
        let mut job = Job::new(work, file, self.look, &self.options, self.way)?;
        job.text = Some(grid.to_json());
        let Some(to) = self.to else {
            return job.run(context);
        };
        if looks {
            convert::written(&mut job, &to, context)?;
            return job.run(context);
        }
        convert::converted(&mut job, &to, context)
    }
}
