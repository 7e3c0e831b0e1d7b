//! What a verb works with: the global options and the output.

use crate::args::{Cli, Global};
use crate::failure::Failure;
use crate::output::Output;
use crate::verbs::version;

/// The surroundings of a verb.
pub(crate) struct Context {
    pub(crate) global: Global,
    pub(crate) out: Output,
}

impl Context {
    pub(crate) fn new(global: Global, out: Output) -> Self {
        Self { global, out }
    }

    /// Runs one command line to its end.
    pub(crate) fn run(&mut self, cli: Cli) -> Result<(), Failure> {
        let outcome = match cli.verb {
            _ if cli.version => version::run(self),
            Some(verb) => verb.run(self),
            None => Err(Failure::usage("no verb given").hint("`magician --help` lists them")),
        };
        outcome.and(self.out.flush())
    }

    /// Shows an object as JSON with `--json`, otherwise as the lines that `text` writes.
    pub(crate) fn show<T: serde::Serialize>(
        &mut self,
        value: &T,
        text: impl FnOnce(&mut Output) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self.global.json {
            true => self.out.json(value),
            false => text(&mut self.out),
        }
    }
}
