//! `frame`: traces the outline of a job without leaving a mark.

use clap::Args;
use magician_program::FrameShape;

use super::job::Job;
use super::job::options::{File, Frames, OptionFlags, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Trace the outline of a job, with the laser off or the pen up
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician frame photo.png --tool laser --width 60           its bounding box, once
  magician frame photo.png --tool laser --width 60 --repeat  until Ctrl-C, to position the wood
  magician frame house.svg --tool pen --shape hull           10 mm above the paper
  magician frame logo.svg --tool laser --shape outline --preview out.svg

Takes the flags of `magician draw` and `magician engrave`; with the same flags it traces the same \
place. The tool is --tool, else the tool in force on the arm, else `tool` of `magician config`; the \
first line of the output names it. With the laser it moves as `magician engrave` does, at the height \
of the work with the laser off; with the pen or an unknown tool as `magician draw` does, --lift \
above the paper.

`box` is the smallest rectangle along the arm's X and Y axes; `hull` the convex hull of all lines; \
`outline` the outer contours, where lines less than 4 mm apart count as one shape. If corners of the \
box, or the outline, are out of reach, it traces the hull and says so.

--frame-power lights the laser while tracing, to show its spot. A laser blinds even at 5 percent, so this needs --yes.")]
pub(crate) struct Frame {
    #[command(flatten)]
    file: File,
    /// Outline to trace: box, hull or outline
    #[arg(long, value_name = "box|hull|outline", default_value = "box", value_parser = str::parse::<FrameShape>)]
    shape: FrameShape,
    /// Repeat until Ctrl-C
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
