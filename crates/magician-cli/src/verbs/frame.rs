//! `frame`: traces the outline of a job without leaving a mark.

use clap::Args;
use magician_program::FrameShape;

use super::job::Job;
use super::job::options::{File, Frames, OptionFlags, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Go round what a file would draw or burn, with the laser off or the pen up
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician frame photo.png --tool laser --width 60           its box, once
  magician frame photo.png --tool laser --width 60 --repeat  until Ctrl-C, while you shift the wood
  magician frame house.svg --tool pen --shape hull           10 mm above the paper
  magician frame logo.svg --tool laser --shape outline --preview out.svg

It takes the flags of `magician draw` and `magician engrave`: with the same ones it goes round the same place. It goes by --tool, else by the tool in force on the \
arm, else by `magician config set tool`, and its first line says so: with the laser as `magician engrave`, at the height of the work with the laser off; with the pen, \
and where the tool is unknown, as `magician draw`, --lift above the paper.

`box` is the smallest box along the arm's X and Y; `hull` a rubber band round all lines; `outline` the outer contours, where lines less than 4 mm apart count as one \
shape. Where the corners of the box, or the outline, are out of reach, it goes round the hull and says so.

--frame-power lights the laser on the way, to see its spot: a laser blinds at 5 percent too, so that it needs --yes.")]
pub(crate) struct Frame {
    #[command(flatten)]
    file: File,
    /// Outline to trace: box, hull or outline
    #[arg(long, value_name = "box|hull|outline", default_value = "box", value_parser = str::parse::<FrameShape>)]
    shape: FrameShape,
    /// Go round until Ctrl-C
    #[arg(long, conflicts_with = "loops")]
    repeat: bool,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Frames>,
    #[command(flatten)]
    way: RunFlags,
}

impl Frame {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        self.job()?.run(context)
    }

    /// Creates the job from the flags.
    pub(super) fn job(mut self) -> Result<Job, Failure> {
        self.options.set_option("frame", self.shape.name());
        let mut job = Job::new(None, self.file, self.look, &self.options, self.way)?;
        job.repeats = self.repeat;
        Ok(job)
    }
}
