//! `get`: reads a value by a command of the protocol.

use clap::Args;
use magician_protocol::{Ctrl, Direction, Row, describe};

use crate::catalogue::{self, CommandArguments};
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::values;

/// Read any value of the protocol
#[derive(Args, Debug)]
#[command(
    disable_help_flag = true,
    override_usage = "magician get [OPTIONS] NAME [KEY=VALUE]...",
    after_help = "\
Examples:
  magician get Pose
  magician get IODO address=4
  magician get --help IODO     explains the command"
)]
pub(crate) struct Get {
    #[command(flatten)]
    command: CommandArguments,
}

impl Get {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let Some(name) = self.command.name("get", context)? else {
            return Ok(());
        };
        let row = readable(name)?;
        let params = match row.query {
            Some(query) => values::params(row, query, &self.command.fields)?,
            None => Vec::new(),
        };
        let json = context.global.json;
        context.arm(StopPolicy::Look, async |arm, out| {
            let reply = arm.raw(row.id, Ctrl::GET, &params).await?;
            let frame = reply.frame();
            let answer = describe(&frame, Direction::Reply);
            let answer = answer.map_err(|error| {
                Failure::unexpected(format!("{}: invalid reply: {error}", row.get_name))
            })?;
            if json {
                out.json(&answer)
            } else {
                values::columns(&answer, 0)?.write(out)
            }
        })
    }
}

fn readable(name: &str) -> Result<&'static Row, Failure> {
    Row::find_readable(name).or_else(|_| {
        let row = catalogue::find(name)?;
        Err(Failure::usage(format!(
            "{} cannot be read, only set",
            row.name
        )))
    })
}
