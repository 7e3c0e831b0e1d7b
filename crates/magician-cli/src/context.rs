//! What a verb works with: the global options, the output, and the arm once it is asked for.

use std::rc::Rc;

use magician::{Arm, Options, SimSpeed, Target};
use tokio::runtime::{Builder, Runtime};

use crate::args::{Cli, Global};
use crate::failure::{Failure, Kind};
use crate::interrupt::Signals;
use crate::output::Output;
use crate::verbs::version;

/// The surroundings of a verb. One lasts for a whole shell.
pub(crate) struct Context {
    pub(crate) global: Global,
    pub(crate) out: Output,
    runtime: Option<Rc<Runtime>>,
    arm: Option<Connected>,
    /// Whether more lines follow: Ctrl-C then stops the arm and keeps the connection.
    pub(crate) in_shell: bool,
}

/// How a verb treats the virtual arm in this process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sim {
    /// Speed of its clock where the port does not say.
    pub(crate) speed: SimSpeed,
    /// Whether it is taken without being asked for.
    pub(crate) unasked: bool,
}

impl Sim {
    fn target(self) -> Target {
        Target::Sim(self.speed)
    }
}

/// An open connection, and the `--port` it was opened for.
struct Connected {
    arm: Arm,
    port: Option<String>,
}

impl Context {
    pub(crate) fn new(global: Global, out: Output) -> Self {
        Self {
            global,
            out,
            runtime: None,
            arm: None,
            in_shell: false,
        }
    }

    /// Runs one command line and leaves: what it set going goes on if it ended well, and is
    /// stopped if not.
    pub(crate) fn run(&mut self, cli: Cli) -> Result<(), Failure> {
        let outcome = self.line(cli);
        self.leave(outcome.is_ok());
        outcome
    }

    /// Runs one command line and keeps the connection.
    pub(crate) fn line(&mut self, cli: Cli) -> Result<(), Failure> {
        self.global = cli.global;
        let outcome = match cli.verb {
            _ if cli.version => version::run(self),
            Some(verb) => verb.run(self),
            None => Err(Failure::usage("no verb given").hint("`magician --help` lists them")),
        };
        outcome.and(self.out.flush())
    }

    /// Ends the connection, if there is one.
    fn leave(&mut self, well: bool) {
        if let (Some(connected), Some(runtime)) = (self.arm.take(), &self.runtime) {
            if well {
                connected.arm.detach();
            }
            runtime.block_on(connected.arm.close());
        }
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

    /// The runtime that everything with a line to an arm runs on: one thread.
    pub(crate) fn runtime(&mut self) -> Result<Rc<Runtime>, Failure> {
        if let Some(runtime) = &self.runtime {
            return Ok(runtime.clone());
        }
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = Rc::new(runtime.map_err(|error| {
            let message = format!("the system gives no event loop: {error}");
            Failure::new(Kind::Port, message)
        })?);
        Ok(self.runtime.insert(runtime).clone())
    }

    /// Works with the arm, connecting first if need be. Ctrl-C ends the work; what it set going is
    /// then stopped as the connection ends.
    pub(crate) fn with_arm<T>(
        &mut self,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.with_arm_at(None, work)
    }

    /// As [`with_arm`](Self::with_arm), on a virtual arm of this speed where the port says `sim`
    /// without one, and where `or_sim` allows it, without a port at all.
    pub(crate) fn with_arm_at<T>(
        &mut self,
        sim: Option<Sim>,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            if self
                .arm
                .as_ref()
                .is_some_and(|open| open.port != self.global.port)
            {
                self.disconnect().await;
            }
            let work = async {
                let arm = match self.arm.take() {
                    Some(connected) => connected,
                    None => self.connect(sim).await?,
                };
                let arm = &self.arm.insert(arm).arm;
                work(arm, &mut self.out).await
            };
            let outcome = tokio::select! {
                outcome = work => outcome,
                _ = signals.next() => Err(Failure::interrupted()),
            };
            if outcome
                .as_ref()
                .is_err_and(|failure| failure.kind == Kind::Interrupted)
            {
                self.halt().await;
            }
            outcome
        })
    }

    /// Stops what was set going. Within a shell the connection lasts, if the arm obeys.
    async fn halt(&mut self) {
        let stopped = match &self.arm {
            Some(connected) if self.in_shell => connected.arm.stop().await.is_ok(),
            _ => false,
        };
        if !stopped {
            self.disconnect().await;
        }
    }

    /// Ends the connection; the arm stops what was set going over it.
    async fn disconnect(&mut self) {
        if let Some(connected) = self.arm.take() {
            connected.arm.close().await;
        }
    }

    async fn connect(&self, sim: Option<Sim>) -> Result<Connected, Failure> {
        let port = self.global.port.clone();
        let target = self.target(sim)?;
        let mut options = Options::default();
        options.timeout = self.global.timeout.unwrap_or(options.timeout);
        let arm = Arm::connect_with(&target, options).await?;
        Ok(Connected { arm, port })
    }

    /// Where the arm is.
    pub(crate) fn target(&self, sim: Option<Sim>) -> Result<Target, Failure> {
        let given = self.global.port.as_deref().filter(|port| !port.is_empty());
        let bare = given.is_some_and(|port| port.eq_ignore_ascii_case("sim"));
        Ok(match (given, sim) {
            (Some(_), Some(sim)) if bare => sim.target(),
            (Some(port), _) => port.parse()?,
            (None, Some(sim)) if sim.unasked => sim.target(),
            (None, _) => Target::discover()?,
        })
    }
}
