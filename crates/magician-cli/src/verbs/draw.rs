//! `draw`: a drawing with the pen.

use clap::Args;
use magician_program::Work;

use super::job::Job;
use super::job::options::{File, LaserFlags, Pen, PlacementOptions, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Draw a file with the pen: SVG, HPGL, DXF, outlines of an image
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician draw house.svg --preview out.svg        what will be drawn, and where
  magician draw house.svg --surface -58.5          the paper is at z -58.5
  magician draw house.svg --fit --speed 30
  magician draw photo.png --width 80 --threshold 100

`magician calibrate` measures the position of the paper once and for all. A drawing keeps its true size; if it does not fit it is refused, unless --fit makes it smaller.")]
pub(crate) struct Draw {
    #[command(flatten)]
    file: File,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    pen: Pen,
    #[command(flatten)]
    place: PlacementOptions,
    #[command(flatten)]
    way: RunFlags,
}

impl Draw {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let (trace, size) = (self.pen.trace(), self.pen.size());
        let job = Job {
            file: self.file,
            look: self.look,
            place: self.place,
            way: self.way,
            beam: LaserFlags::default(),
            pen: self.pen,
            work: Work::Draw(trace),
            size,
            pause: 0,
            runs: true,
        };
        job.run(context)
    }
}
