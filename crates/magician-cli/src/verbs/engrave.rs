//! `engrave`: burns an image or a drawing with the laser.

use clap::Args;
use magician_program::WorkOption;

use super::job::Job;
use super::job::options::{Engraves, File, OptionFlags, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Burn a file with the laser: an image line by line, or a drawing
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician engrave photo.png --width 60 --preview out.png
  magician engrave --frame photo.png --width 60    trace its outline first, laser off
  magician engrave photo.png --width 60 --power 5..70 --yes
  magician engrave logo.svg --power 80 --speed 10 --yes
  magician engrave job.gcode --power 50 --check
  magician engrave photo.png --mode dither --spacing 0.25 --port sim --picture out.png

A laser blinds and starts fires: wear goggles for its wavelength, keep the space behind the work \
clear, and never leave it unattended. On a real arm nothing burns without --yes; --check, --estimate \
and --preview move nothing.")]
pub(crate) struct Verb {
    #[command(flatten)]
    file: File,
    /// With --frame: repeat until Ctrl-C
    #[arg(long, requires = "frame", conflicts_with = "loops")]
    repeat: bool,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Engraves>,
    #[command(flatten)]
    way: RunFlags,
}

impl Verb {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        self.job()?.run(context)
    }

    /// Creates the job from the flags.
    pub(super) fn job(self) -> Result<Job, Failure> {
        let engrave = WorkOption::Engrave;
        let mut job = Job::new(engrave, self.file, self.look, &self.options, self.way)?;
        job.repeats = self.repeat;
        Ok(job)
    }
}
