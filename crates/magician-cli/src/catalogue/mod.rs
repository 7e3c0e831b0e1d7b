//! The commands of the protocol as people look them up: by name, with help made from the table.

mod example;
mod explain;
mod find;
mod record;

use crate::args::Cli;
use crate::context::Context;
use crate::failure::Failure;

pub(crate) use explain::explain;
pub(crate) use find::{find, letters};
pub(crate) use record::{Entry, chapter_name};

/// The command that a verb is for; `None` when its help was asked for and has been given.
pub(crate) fn named(
    name: Option<String>,
    help: bool,
    verb: &str,
    context: &mut Context,
) -> Result<Option<String>, Failure> {
    match name {
        Some(name) if help => explain(&name, context).map(|()| None),
        Some(name) => Ok(Some(name)),
        None => {
            let mut description = Cli::description();
            if let Some(verb) = description.find_subcommand_mut(verb) {
                context.out.styled(&verb.render_long_help())?;
            }
            Ok(None)
        }
    }
}
