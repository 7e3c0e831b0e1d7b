//! `run`: checks and runs a file of any format.

use clap::Args;
use magician_program::WorkOption;

use super::job::Job;
use super::job::options::{File, OptionFlags, PreviewFlags, RunFlags, RunsAll};
use crate::context::Context;
use crate::failure::Failure;

/// Run a file: taught program, G-code, drawing or image
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician run pick.playback                       a program taught in DobotStudio
  magician run drawing.svg --check                 check it, without an arm
  magician run drawing.svg --preview out.svg       preview the drawing and its position
  magician run part.gcode --port sim --picture out.png
  magician run part.gcode --resume                 resume after Ctrl-C or a pulled cable

During a run at a terminal, p pauses and resumes, space and s stop like Ctrl-C, + and - change the \
speed, and Ctrl-Z pauses the run before it suspends this program. --tui shows the drawing as it \
progresses.

Everything is checked before the first byte is sent. Drawings are drawn with the pen (more options: \
`magician draw`), images are engraved (`magician engrave`). Burning with a real arm needs --yes.")]
pub(crate) struct Run {
    #[command(flatten)]
    file: File,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<RunsAll>,
    #[command(flatten)]
    way: RunFlags,
}

impl Run {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let by_file = WorkOption::ByFile;
        let mut job = Job::new(by_file, self.file, self.look, &self.options, self.way)?;
        if job.options.frame.is_some() {
            // An outline is traced with whatever tool is mounted.
            job.options.work = None;
        }
        job.run(context)
    }
}
