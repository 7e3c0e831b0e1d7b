use clap::Args;
use magician::commands;

use super::pose::Answer;
use crate::context::Context;
use crate::failure::Failure;
use crate::saved::Access;

/// Stop the arm: motion, queue and laser
#[derive(Args, Debug)]
#[command(after_help = "\
Stops the motion, drops what waits in the queue, switches the laser off, and makes sure that the arm stands. \
A convenience, not a safety function: the arm has a power switch.")]
pub(crate) struct Stop {
    /// Let the command under way finish and hold the rest of the queue
    #[arg(long)]
    gentle: bool,
}

impl Stop {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let pose = context.with_arm(Access::Stops, async |arm, _| {
            match self.gentle {
                true => arm.stop_gentle().await?,
                false => arm.stop().await?,
            }
            Ok(arm.get::<commands::Pose>().await?)
        })?;
        if !self.gentle {
            context.stands();
        }
        let answer = Answer::from(pose);
        let what = match self.gentle {
            true => "stopping",
            false => "stopped",
        };
        context.show(&answer, |out| {
            out.line(format_args!("{what}: {}", answer.line()))
        })
    }
}
