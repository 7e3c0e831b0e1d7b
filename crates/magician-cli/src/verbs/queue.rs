//! `queue`: shows and controls the command queue of the arm.

use clap::{Args, Subcommand};
use serde::Serialize;

use crate::columns::Columns;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;

/// Show, start, stop or clear the command queue
#[derive(Args, Debug)]
pub(crate) struct Queue {
    #[command(subcommand)]
    action: Option<Action>,
}

#[derive(Clone, Copy, Debug, Subcommand)]
enum Action {
    /// Show progress and free space
    Status,
    /// Start the queue
    Start,
    /// Finish the current command and hold the rest
    Stop,
    /// Drop the waiting commands; the current motion may stop midway
    Clear,
}

#[derive(Serialize)]
struct Status {
    current_index: u64,
    left_space: u32,
}

impl Queue {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let action = self.action.unwrap_or(Action::Status);
        let policy = match action {
            Action::Status => StopPolicy::Look,
            Action::Start => StopPolicy::HandOver,
            Action::Stop | Action::Clear => StopPolicy::Order,
        };
        if let Action::Start = action {
            context.permit_queue()?;
        }
        let (status, capacity) = context.arm(policy, async |arm, _| {
            match action {
                Action::Status => (),
                Action::Start => {
                    arm.laser().check_off().await?;
                    arm.queue().start().await?;
                }
                Action::Stop => arm.stop_gentle().await?,
                Action::Clear => arm.queue().clear().await?,
            }
            let status = Status {
                current_index: arm.queue().current_index().await?.0,
                left_space: arm.queue().left_space().await?,
            };
            let (_, capacity) = arm.stats().await?;
            Ok((status, capacity))
        })?;
        context.show(&status, |out| {
            let taken = capacity.saturating_sub(status.left_space);
            let mut columns = Columns::default();
            columns.row(["finished", &finished(status.current_index)]);
            columns.row(["in the queue", &counted(taken)]);
            columns.row(["room for", &format!("{} more", status.left_space)]);
            columns.write(out)
        })
    }
}

/// Describes the progress of the queue.
pub(crate) fn finished(index: u64) -> String {
    match index {
        0 => "nothing yet".to_owned(),
        index => format!("up to index {index}"),
    }
}

fn counted(commands: u32) -> String {
    match commands {
        0 => "nothing".to_owned(),
        1 => "1 command".to_owned(),
        count => format!("{count} commands"),
    }
}
