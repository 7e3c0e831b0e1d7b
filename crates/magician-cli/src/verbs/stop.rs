use clap::Args;
use magician::commands;
use magician::report::PoseReport;
use magician_job::report::left_on;

use super::pose::ShowPose;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;

/// Stop the arm: motion, queue, laser and motors
#[derive(Args, Debug)]
#[command(after_help = "\
Stops the motion, drops the waiting commands, switches the laser and both motor outputs off, and \
    checks that the arm has stopped. Suction cup and gripper stay as they are, so that nothing falls: a note says what is still on. This is not a safety function: in an emergency use the arm's power switch.")]
pub(crate) struct Stop {
    /// Finish the command under way and hold the rest of the queue
    #[arg(long)]
    gentle: bool,
}

impl Stop {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let policy = match self.gentle {
            true => StopPolicy::Hold,
            false => StopPolicy::Stop,
        };
        let (pose, outputs) = context.arm(policy, async |arm, _| {
            match self.gentle {
                true => arm.stop_gentle().await?,
                false => arm.stop().await?,
            }
            Ok((
                arm.get::<commands::Pose>().await?,
                arm.read_outputs().await?,
            ))
        })?;
        // A command under way may switch them still.
        if !self.gentle {
            for note in left_on(&outputs) {
                context.note(&note);
            }
        }
        let answer = PoseReport::from(pose);
        let what = match self.gentle {
            true => "stopping",
            false => "stopped",
        };
        context.show(&answer, |out| {
            out.line(format_args!("{what}: {}", answer.line()))
        })
    }
}
