//! `draw`: draws a file with the pen.

use clap::Args;
use magician_program::WorkOption;

use super::job::Job;
use super::job::options::{Draws, File, OptionFlags, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Draw a file with the pen: SVG, HPGL, DXF, an image
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician draw house.svg --preview out.svg        preview the drawing and its position
  magician draw house.svg --surface -58.5          the paper is at z -58.5
  magician draw house.svg --fit --speed 30
  magician draw logo.png --width 80 --threshold 100
  magician draw sketch.jpg --image centerline --width 150
  magician draw photo.jpg --image hatch --width 120 --pen-width 0.4

`magician calibrate` measures and saves the position of the paper. A drawing keeps its true size; if \
it does not fit, it is refused unless --fit shrinks it.")]
pub(crate) struct Draw {
    #[command(flatten)]
    file: File,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Draws>,
    #[command(flatten)]
    way: RunFlags,
}

impl Draw {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        self.job()?.run(context)
    }

    /// Creates the job from the flags.
    pub(super) fn job(self) -> Result<Job, Failure> {
        Job::new(
            WorkOption::Draw,
            self.file,
            self.look,
            &self.options,
            self.way,
        )
    }
}
