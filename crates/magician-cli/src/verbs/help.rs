use clap::Args;

use crate::args::Cli;
use crate::catalogue;
use crate::context::Context;
use crate::failure::Failure;

/// Explain a verb, or a command of the protocol
#[derive(Args, Debug)]
pub(crate) struct Help {
    /// A verb, a command, or a verb and a command: `get PTPJointParams`
    words: Vec<String>,
}

impl Help {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let mut description = Cli::description();
        let (first, second) = (self.words.first(), self.words.get(1));
        let Some(first) = first else {
            return context.out.styled(&description.render_long_help());
        };
        let verb = description.find_subcommand_mut(first);
        match (verb, second) {
            (Some(_), Some(command)) => catalogue::explain(command, context),
            (Some(verb), None) => context.out.styled(&verb.render_long_help()),
            (None, _) => catalogue::explain(first, context),
        }
    }
}
