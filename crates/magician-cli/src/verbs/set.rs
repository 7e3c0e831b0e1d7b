//! `set`: writes a value by a command of the protocol.

use clap::Args;
use magician::gate::refuse_unheld;
use magician::{Ctrl, Set as Command, sets_in_motion};
use magician_protocol::{LayoutInfo, Row};
use serde_json::json;

use crate::catalogue::{self, CommandArguments};
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::values;

/// Set any value of the protocol, or run any of its commands, at once
#[derive(Args, Debug)]
#[command(
    disable_help_flag = true,
    override_usage = "magician set [OPTIONS] NAME [KEY=VALUE]...",
    after_help = "\
Examples:
  magician set PTPCommonParams velocity_ratio=80 acceleration_ratio=60
  magician set PTPJointParams velocity=100,100,100,100 acceleration=80,80,80,80
  magician set --help PTPCmd     explains the command"
)]
pub(crate) struct Set {
    #[command(flatten)]
    command: CommandArguments,
}

impl Set {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let Some(name) = self.command.name("set", context)? else {
            return Ok(());
        };
        let (row, layout) = writable(name)?;
        let params = values::params(row, layout, &self.command.fields)?;
        refuse_danger(row, context)?;
        let command = Command::decode(row.id, &params);
        let command = command.map_err(|error| Failure::usage(format!("{}: {error}", row.name)))?;
        refuse_unheld(&command)?;
        let policy = if context.permit([&command])? {
            StopPolicy::lights(context)
        } else {
            StopPolicy::Order
        };
        if let Command::QueuedCmdStartExec(_) | Command::ClearAlarmsState(_) = command {
            context.permit_queue()?;
        }
        let begins = sets_in_motion(&command);
        context.arm(policy, async |arm, _| {
            if begins {
                arm.laser().check_off().await?;
            }
            Ok(arm.raw(row.id, Ctrl::SET, &params).await?)
        })?;
        // The answer to a set has no fields.
        context.show(&json!({}), |_| Ok(()))
    }
}

/// Finds the command of a name that can be set.
pub(crate) fn writable(name: &str) -> Result<(&'static Row, &'static LayoutInfo), Failure> {
    let row = match Row::find_writable(name) {
        Ok(row) => row,
        Err(_) => catalogue::find(name)?,
    };
    match row.set {
        Some(layout) => Ok((row, layout)),
        None => Err(Failure::usage(format!(
            "{} cannot be set, only read",
            row.name
        ))),
    }
}

/// Refuses a dangerous command without `--yes`.
pub(crate) fn refuse_danger(row: &Row, context: &Context) -> Result<(), Failure> {
    let Some(danger) = row.danger().filter(|_| !context.global.yes) else {
        return Ok(());
    };
    let message = format!("{} {danger}; nothing was sent", row.set_name);
    Err(Failure::usage(message).hint("--yes sends it anyway"))
}
