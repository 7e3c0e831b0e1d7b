//! `home`: homes the arm.

use clap::Args;
use magician::report::PoseReport;
use magician::{RunOptions, commands};

use super::pose::ShowPose;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::progress::announce_wait;

/// Home the arm: find its reference, move to the home point, clear alarms
#[derive(Args, Debug)]
pub(crate) struct Home {
    /// First run the commands that an earlier program left in the queue
    #[arg(long)]
    keep: bool,
}

impl Home {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let quiet = context.global.json;
        if self.keep {
            context.permit_queue()?;
        }
        let pose = context.arm(StopPolicy::Move, async |arm, _| {
            let home = arm.home_with(RunOptions::default().keep(self.keep));
            announce_wait(quiet, "homing", home).await?;
            Ok(arm.get::<commands::Pose>().await?)
        })?;
        let answer = PoseReport::from(pose);
        context.show(&answer, |out| {
            out.line(format_args!("home: {}", answer.line()))
        })
    }
}
