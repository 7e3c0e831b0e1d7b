//! `play`: runs a taught program, once or repeatedly.

use std::time::Duration;

use clap::Args;
use magician_program::WorkOption;

use super::job::Job;
use super::job::options::{File, OptionFlags, Plays, PreviewFlags, RunFlags};
use crate::context::Context;
use crate::failure::Failure;
use crate::options::seconds;

/// Play a taught program from DobotStudio or `magician teach`
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician play pick.playback
  magician play pick.playback --loops 10 --speed-ratio 80
  magician play pick.playback --loops 0 --pause 2     until Ctrl-C, with pauses of 2 s
  magician play drop.playback --grid 2x3:40x30        at each position of a pallet")]
pub(crate) struct Play {
    #[command(flatten)]
    file: File,
    /// Pause at the end of each loop, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pause: Option<Duration>,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    options: OptionFlags<Plays>,
    #[command(flatten)]
    way: RunFlags,
}

impl Play {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let pause = self.pause.unwrap_or_default().as_millis();
        let by_file = WorkOption::ByFile;
        let mut job = Job::new(by_file, self.file, self.look, &self.options, self.way)?;
        job.pause = u32::try_from(pause).unwrap_or(u32::MAX);
        job.run(context)
    }
}
