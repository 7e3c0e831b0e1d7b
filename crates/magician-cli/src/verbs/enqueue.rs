//! `enqueue`: sends one queued command of the protocol.

use clap::Args;
use magician::gate::refuse_unheld;
use serde::Serialize;

use super::set::{refuse_danger, writable};
use crate::catalogue::CommandArguments;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::values;

/// Queue any command of the protocol
#[derive(Args, Debug)]
#[command(
    disable_help_flag = true,
    override_usage = "magician enqueue [OPTIONS] NAME [KEY=VALUE]...",
    after_help = "\
Examples:
  magician enqueue PTPCmd ptp_mode=movl-xyz x=220 y=40 z=30 r=0 --start
  magician enqueue --help PTPCmd     explains the command

Prints the queue index assigned by the arm. The queue is started only with --start."
)]
pub(crate) struct Enqueue {
    #[command(flatten)]
    command: CommandArguments,
    /// Start the queue
    #[arg(long)]
    start: bool,
}

#[derive(Serialize)]
struct QueuedIndex {
    index: u64,
}

impl Enqueue {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let Some(name) = self.command.name("enqueue", context)? else {
            return Ok(());
        };
        let (row, layout) = writable(name)?;
        if !row.queueable {
            let message = format!("{} cannot be queued", row.set_name);
            return Err(Failure::usage(message)
                .hint(format!("`magician set {}` runs it at once", row.name)));
        }
        let params = values::params(row, layout, &self.command.fields)?;
        refuse_danger(row, context)?;
        let command = magician::Set::decode(row.id, &params)
            .map_err(|error| Failure::usage(format!("{}: {error}", row.name)))?;
        refuse_unheld(&command)?;
        context.permit([&command])?;
        if self.start {
            context.permit_queue()?;
        }
        let index = context.arm(StopPolicy::Order, async |arm, _| {
            if self.start {
                arm.laser().check_off().await?;
            }
            let index = arm.enqueue_set(&command).await?;
            if self.start {
                arm.queue().start().await?;
            }
            Ok(index.0)
        })?;
        context.show(&QueuedIndex { index }, |out| {
            out.line(format_args!("index {index}"))
        })
    }
}
