//! Commands of the protocol for people: found by name, with help generated from the command table.

mod example;
mod explain;
mod find;
mod record;

use clap::Args;

use crate::brief::brief;
use crate::context::Context;
use crate::failure::Failure;

pub(crate) use explain::explain;
pub(crate) use find::{Names, find, kebab, normalised_name};
pub(crate) use record::{Entry, chapter_name};

/// The command that a verb is for, and its fields.
#[derive(Args, Debug)]
pub(crate) struct CommandArguments {
    /// Command: its name (as in the vendor's document or in Rust) or its id
    #[arg(required_unless_present_any = ["help", "short_help"], value_parser = Names, hide_possible_values = true)]
    name: Option<String>,
    /// Fields of the command; for a get, fields of the request
    #[arg(value_name = "KEY=VALUE")]
    pub(crate) fields: Vec<String>,
    /// Explain the command if one is given, otherwise this verb
    #[arg(long)]
    help: bool,
    /// Like --help, but shorter for the verb
    #[arg(short = 'h')]
    short_help: bool,
}

impl CommandArguments {
    /// Returns the name of the command, or `None` if help was asked for and has been shown.
    pub(crate) fn name(&self, verb: &str, context: &mut Context) -> Result<Option<&str>, Failure> {
        match self.name.as_deref() {
            Some(name) if self.help || self.short_help => explain(name, context).map(|()| None),
            Some(name) => Ok(Some(name)),
            None => {
                let description = (context.command_line.description)();
                let mut description = if self.short_help {
                    brief(description)
                } else {
                    description
                };
                let verb = description.find_subcommand_mut(verb);
                verb.map_or(Ok(()), |verb| context.show_styled(&verb.render_long_help()))?;
                Ok(None)
            }
        }
    }
}
