//! What a verb works with: the global options and the output.

use std::rc::Rc;

use tokio::runtime::{Builder, Runtime};

use crate::args::{Cli, Global};
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::verbs::version;

/// The surroundings of a verb.
pub(crate) struct Context {
    pub(crate) global: Global,
    pub(crate) out: Output,
    runtime: Option<Rc<Runtime>>,
}

impl Context {
    pub(crate) fn new(global: Global, out: Output) -> Self {
        Self {
            global,
            out,
            runtime: None,
        }
    }

    /// The runtime that everything with a line to an arm runs on: one thread.
    pub(crate) fn runtime(&mut self) -> Result<Rc<Runtime>, Failure> {
        if let Some(runtime) = &self.runtime {
            return Ok(runtime.clone());
        }
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = Rc::new(runtime.map_err(|error| {
            Failure::new(
                Kind::Port,
                format!("the system gives no event loop: {error}"),
            )
        })?);
        Ok(self.runtime.insert(runtime).clone())
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
