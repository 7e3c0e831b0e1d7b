//! What a verb works with: the global options, the output, and the arm once it is asked for.

mod job;
mod stop;

use std::ffi::OsString;
use std::path::PathBuf;
use std::pin::{Pin, pin};
use std::rc::Rc;
use std::time::Duration;

use clap::builder::StyledStr;
use magician::sim::Controller;
use magician::{Arm, ErrorKind, LineOptions, Options, SimSpeed, Target, Tracer, VirtualArm};
use tokio::runtime::{Builder, Runtime};

use crate::config::Config;
use crate::failure::{Failure, Kind, incomplete};
use crate::interrupt::{Signal, Signals};
use crate::options::Global;
use crate::output::{Output, Text};
use crate::progress::attended;
use crate::saved::{Access, SavedSettings, Settled};
use crate::serving::create;

pub(crate) use job::Ended;
use stop::stop_again;
pub(crate) use stop::{not_confirmed, place, stop};

/// What only the command line as a whole knows, for the verbs that show it or follow lines of it.
#[derive(Clone, Copy)]
pub(crate) struct CommandLine {
    /// All verbs and options.
    pub(crate) description: fn() -> clap::Command,
    /// Does a line of a shell that was given these options.
    pub(crate) follow: fn(&[OsString], &Global, &mut Context) -> Result<(), Failure>,
}

/// The surroundings of a verb. One lasts for a whole shell.
pub(crate) struct Context {
    pub(crate) global: Global,
    pub(crate) out: Output,
    pub(crate) command_line: CommandLine,
    runtime: Option<Rc<Runtime>>,
    arm: Option<Connected>,
    /// The file of settings, once it has been read.
    config: Option<Rc<Config>>,
    /// The trace file under way, or why there is none, and where it is.
    trace: Option<(PathBuf, Result<Tracer, String>)>,
    /// A virtual arm of the verb's own making, to be connected to where the arm is a virtual one in this process.
    stage: Option<VirtualArm>,
    /// Whether time is the arm's: it passes as fast as there is nothing to do, and nothing runs dry for want of it.
    in_arm_time: bool,
    /// Settings that the verb under way owes the arm.
    pub(crate) saved: SavedSettings,
    /// Whether more lines follow: Ctrl-C then stops the arm and keeps the connection.
    pub(crate) in_shell: bool,
    /// Whether the verb under way waits for a line that breaks to come back.
    pub(crate) lasts: bool,
    /// Whether the laser may burn during the verb under way: a person said so.
    burns: bool,
    /// Whether the laser was lit over this connection and stays so until it ends.
    lit: bool,
    /// Whether it stays so even then: that was asked for.
    pub(crate) keeps_laser: bool,
    /// Whether the system wants this program to end, more lines or not.
    pub(crate) terminated: bool,
    /// Whether a verb has set something going that the connection cannot know of: what earlier programs queued, a
    /// laser, a move that is only planned yet. What it knows of, [`Arm::moving`] tells.
    going: bool,
}

/// While it lasts, time passes as fast as there is nothing left to do.
struct ArmTime;

impl ArmTime {
    fn begin() -> Self {
        tokio::time::pause();
        Self
    }
}

impl Drop for ArmTime {
    fn drop(&mut self) {
        tokio::time::resume();
    }
}

/// How long a stop may take before this program ends without knowing.
pub(crate) const STAND_BY: Duration = Duration::from_secs(3);

/// How long connections that were dropped get for their last words.
pub(crate) const FAREWELL: Duration = Duration::from_millis(600);

/// How a verb treats the virtual arm in this process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sim {
    /// Speed of its clock where the port does not say.
    pub(crate) speed: SimSpeed,
    /// Whether it is taken without being asked for.
    pub(crate) unasked: bool,
}

/// An open connection, and the `--port` it was opened for.
struct Connected {
    arm: Arm,
    port: Option<String>,
}

impl Context {
    pub(crate) fn new(global: Global, out: Output, command_line: CommandLine) -> Self {
        Self {
            global,
            out,
            command_line,
            runtime: None,
            arm: None,
            config: None,
            trace: None,
            stage: None,
            in_arm_time: false,
            saved: SavedSettings::default(),
            in_shell: false,
            lasts: false,
            burns: false,
            lit: false,
            keeps_laser: false,
            terminated: false,
            going: false,
        }
    }

    /// A command line begins that was given these options.
    pub(crate) fn begins(&mut self, global: Global) {
        self.global = global;
        self.burns = self.global.yes;
    }

    /// Ends the connection, if there is one: what was set going over it goes on if all ended well, and is stopped if not.
    pub(crate) fn leave(&mut self, outcome: Result<(), Failure>) -> Result<(), Failure> {
        self.disconnect_after(outcome.is_ok());
        outcome.and_then(|()| match self.untraced() {
            Some(why) => Err(incomplete("trace", &why)),
            None => Ok(()),
        })
    }

    /// Why the trace is not whole, if it is not.
    fn untraced(&self) -> Option<String> {
        let failed = self.trace.as_ref().map(|(_, trace)| trace);
        match failed? {
            Ok(tracer) => tracer.failed(),
            Err(why) => Some(why.clone()),
        }
    }

    fn disconnect_after(&mut self, well: bool) {
        if let (Some(connected), Some(runtime)) = (self.arm.take(), &self.runtime) {
            let arm = connected.arm;
            runtime.block_on(async {
                if well && !self.keeps_laser {
                    // What is not answered is said once more at the end of a connection that is not let go of.
                    let dark = match self.lit {
                        true => arm.darken().await,
                        false => arm.darken_after().await,
                    };
                    if dark.is_ok() {
                        arm.detach();
                    }
                } else if well {
                    arm.detach();
                }
                arm.close().await;
            });
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

    /// Shows help that clap has styled.
    pub(crate) fn show_styled(&mut self, help: &StyledStr) -> Result<(), Failure> {
        self.show(&Text::from(help), |out| out.styled(help))
    }

    /// The runtime that everything with a line to an arm runs on: one thread.
    pub(crate) fn runtime(&mut self) -> Result<Rc<Runtime>, Failure> {
        if let Some(runtime) = &self.runtime {
            return Ok(runtime.clone());
        }
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = Rc::new(runtime.map_err(|error| {
            let message = format!("the event loop cannot be started: {error}");
            Failure::new(Kind::Driver(ErrorKind::Port), message)
        })?);
        Ok(self.runtime.insert(runtime).clone())
    }

    /// Works with the arm, connecting first if need be. Ctrl-C ends the work.
    pub(crate) fn with_arm<T>(
        &mut self,
        access: Access,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.work(None, access, work)
    }

    /// Works with the arm on something that moves it and waits until it stands: Ctrl-C stops it.
    /// `sim` is what stands in for a port that is `sim` without a speed, or none.
    pub(crate) fn moving<T>(
        &mut self,
        sim: Option<Sim>,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.sets_going(true);
        let done = self.work(sim, Access::Sets, work)?;
        self.going = false;
        Ok(done)
    }

    /// Puts up a virtual arm that is to be connected to where the arm is one in this process.
    pub(crate) fn put_up(&mut self, arm: VirtualArm) {
        self.stage = Some(arm);
    }

    /// As [`put_up`](Self::put_up), an arm at its own speed, whose time is everybody's while the verb works with it: what it
    /// does takes as long by its clock as on a real one, and next to nothing by ours.
    pub(crate) fn put_up_in_arm_time(&mut self, arm: VirtualArm) {
        self.put_up(arm);
        self.in_arm_time = true;
    }

    /// Whether a connection is open already: a shell's.
    pub(crate) fn is_connected(&self) -> bool {
        self.arm.is_some()
    }

    /// The arm that this is connected to, if it is the one that is meant now.
    pub(crate) fn connected(&self) -> Option<&Arm> {
        let open = self.arm.as_ref();
        let open = open.filter(|open| open.port == self.global.port);
        open.map(|open| &open.arm)
    }

    /// A command has lit the laser for longer than the verb: to the end of a shell, else for good.
    pub(crate) fn leaves_lit(&mut self) {
        match self.in_shell {
            true => self.lights(true),
            false => self.keeps_laser = true,
        }
    }

    /// Whether the laser may burn during this verb.
    pub(crate) fn laser_is_allowed(&self) -> bool {
        self.burns
    }

    /// Lets it burn.
    pub(crate) fn allow_laser(&mut self) {
        self.burns = true;
    }

    /// The laser was lit, or put out, by a verb that has ended.
    pub(crate) fn lights(&mut self, lit: bool) {
        self.lit = lit;
        self.sets_going(lit);
    }

    /// Works with the arm on something that lasts and moves nothing: Ctrl-C ends it. `sim` is what stands in for a port that
    /// is `sim` without a speed.
    pub(crate) fn watching<T>(
        &mut self,
        sim: Sim,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.work(Some(sim), Access::Reads, work)
    }

    /// From here on Ctrl-C stops the arm, if `going`: the verb sets something going that lasts, and the connection
    /// cannot tell.
    pub(crate) fn sets_going(&mut self, going: bool) {
        self.going |= going;
    }

    /// The arm has been stopped.
    pub(crate) fn stands(&mut self) {
        self.going = false;
    }

    /// `access` is what becomes of the saved of others, if anything does.
    fn work<T>(
        &mut self,
        sim: Option<Sim>,
        access: Access,
        work: impl AsyncFnOnce(&Arm, &mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.settle()?;
        let runtime = self.runtime()?;
        let in_arm_time = std::mem::take(&mut self.in_arm_time);
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let _time = in_arm_time.then(ArmTime::begin);
            let work = async {
                let arm = &self.connected_anew(sim).await?;
                let settled = SavedSettings::settle(arm, access).await;
                self.out.settled(&settled, self.global.json);
                let done = match self.burns {
                    true => work(&arm.allowing_laser(), &mut self.out).await,
                    false => work(arm, &mut self.out).await,
                }?;
                if let Settled::Later(_) = settled {
                    let settled = SavedSettings::settle(arm, Access::Sets).await;
                    self.out.settled(&settled, self.global.json);
                }
                Ok(done)
            };
            tokio::select! {
                outcome = work => match outcome {
                    Ok(done) => Ok(done),
                    Err(failure) => Err(self.make_good(failure, &mut signals).await),
                },
                signal = signals.next() => {
                    self.terminated |= signal == Signal::Terminate;
                    Err(self.halt(&mut signals).await)
                }
            }
        })
    }

    /// Works with the arm on something that lasts until Ctrl-C, which is its proper end: `work` is told, and comes to it. Also
    /// the wish of the system to end is told so.
    pub(crate) fn until_told<T>(
        &mut self,
        sim: Sim,
        work: impl AsyncFnOnce(
            &Arm,
            &mut Output,
            Pin<&mut dyn Future<Output = ()>>,
        ) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let clone = async |arm: &Arm, _: &mut Output| Ok(arm.clone());
        let arm = self.work(Some(sim), Access::Reads, clone)?;
        let runtime = self.runtime()?;
        let out = &mut self.out;
        let (outcome, terminated) = runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let mut terminated = false;
            let over = async { terminated = signals.next().await == Signal::Terminate };
            let outcome = work(&arm, out, pin!(over)).await;
            Ok::<_, Failure>((outcome, terminated))
        })?;
        self.terminated |= terminated;
        outcome
    }

    /// A signal while nothing is done: what was set going before is stopped.
    pub(crate) fn interrupt(&mut self) -> Result<Failure, Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(async {
            let mut signals = Signals::listen()?;
            Ok(self.halt(&mut signals).await)
        })
    }

    /// After a failure settings are given back, unless a signal comes first.
    async fn make_good(&mut self, failure: Failure, signals: &mut Signals) -> Failure {
        let Some(connected) = &self.arm else {
            return failure;
        };
        tokio::select! {
            () = self.saved.restore_after_failure(&connected.arm) => failure,
            _ = signals.next() => {
                self.arm = None;
                Failure::interrupted()
            }
        }
    }

    /// Stops what was set going, and waits until the arm stands. A second signal stops the arm at once.
    async fn halt(&mut self, signals: &mut Signals) -> Failure {
        let failure = match &self.arm {
            Some(connected) if self.going || connected.arm.moving() => {
                let arm = &connected.arm;
                let ended = attended(self.global.json, "stopping", stop(arm, &self.saved));
                let ended = tokio::select! {
                    biased;
                    _ = signals.next() => None,
                    ended = ended => Some(ended),
                };
                match ended {
                    Some(ended) => ended,
                    None => stop_again(arm, signals).await,
                }
            }
            _ => Ok("interrupted".to_owned()),
        };
        self.going = false;
        self.saved.leave();
        let stands = failure.is_ok();
        let message = failure.unwrap_or_else(|message| message);
        self.interrupted(stands).await;
        Failure::new(Kind::Interrupted, message)
    }

    /// Does what opens its lines itself. Ctrl-C ends it, and what it has open stops what it set going.
    pub(crate) fn attending<T>(
        &mut self,
        work: impl AsyncFnOnce(&mut Output) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.let_go()?;
        let runtime = self.runtime()?;
        let out = &mut self.out;
        let outcome = runtime.block_on(async {
            let mut signals = Signals::listen()?;
            let signal = tokio::select! {
                outcome = work(out) => return Ok::<_, Failure>(Ok(outcome?)),
                signal = signals.next() => signal,
            };
            tokio::time::sleep(FAREWELL).await;
            Ok(Err(signal))
        })?;
        outcome.map_err(|signal| {
            self.terminated |= signal == Signal::Terminate;
            Failure::interrupted()
        })
    }

    /// Gives up the line to the arm, for a verb that opens it in its own way.
    pub(crate) fn let_go(&mut self) -> Result<(), Failure> {
        let runtime = self.runtime()?;
        runtime.block_on(self.disconnect());
        Ok(())
    }

    /// Ends the connection; the arm stops what was set going over it.
    async fn disconnect(&mut self) {
        if let Some(connected) = self.arm.take() {
            connected.arm.close().await;
        }
    }

    async fn connect(&mut self, sim: Option<Sim>) -> Result<Connected, Failure> {
        let port = self.global.port.clone();
        let target = self.target(sim)?;
        let config = self.config()?;
        let options = self.options()?.for_arm(config.arm_at(&target));
        let tool = self.global.virtual_tool;
        if tool.is_some() && !matches!(target, Target::Sim(_)) {
            let hint = "`magician set EndEffectorParams x_bias=X y_bias=Y z_bias=Z` sets it on \
                the arm";
            let message =
                format!("--tool sets the tool of a virtual arm, and {target} is a real one");
            return Err(Failure::usage(message).hint(hint));
        }
        let arm = match (target, self.stage.take(), tool) {
            (Target::Sim(_), Some(stage), tool) => {
                let stage = match tool {
                    Some(tool) => stage.tool(tool),
                    None => stage,
                };
                Arm::simulated(stage, options).await?
            }
            (Target::Sim(speed), None, Some(tool)) => {
                let arm = VirtualArm::new(Controller::default().with_tool(tool), speed);
                Arm::simulated(arm, options).await?
            }
            (target, _, _) => Arm::connect_with(&target, options).await?,
        };
        Ok(Connected { arm, port })
    }

    /// How a connection is to behave.
    pub(crate) fn options(&mut self) -> Result<Options, Failure> {
        self.settle()?;
        let mut options = Options::default();
        options.timeout = self.global.timeout.unwrap_or(options.timeout);
        options.window = self.global.window.map_or(options.window, usize::from);
        // A verb whose line breaks fails; only a shell and a pad last until the cable is back.
        options.reconnect = self.in_shell || self.lasts;
        options.laser_pins = self.laser_pins()?;
        options.faults = self.global.faults.unwrap_or_default();
        options.trace = self.tracer()?;
        Ok(options)
    }

    /// What is put between a bare line and its port.
    pub(crate) fn line_options(&mut self) -> Result<LineOptions, Failure> {
        let mut options = LineOptions::default();
        options.faults = self.global.faults.unwrap_or_default();
        options.trace = self.tracer()?;
        Ok(options)
    }

    /// The trace that is asked for. All lines of this program go into the same one.
    fn tracer(&mut self) -> Result<Option<Tracer>, Failure> {
        let Some(path) = &self.global.trace else {
            return Ok(None);
        };
        if let Some((_, tracer)) = self.trace.as_ref().filter(|(known, _)| known == path) {
            return Ok(tracer.clone().ok());
        }
        // A full disk costs the trace, not what is traced.
        let tracer = Tracer::new(create(path)?).map_err(|error| {
            tracing::warn!(%error, "the trace cannot be written and stops here");
            error.to_string()
        });
        self.trace = Some((path.clone(), tracer.clone()));
        Ok(tracer.ok())
    }

    /// The file of settings. It is read when something first depends on it.
    pub(crate) fn config(&mut self) -> Result<Rc<Config>, Failure> {
        if self.config.is_none() {
            self.config = Some(Rc::new(Config::load()?));
        }
        Ok(self.config.clone().unwrap_or_default())
    }

    /// Lets the settings of the file say what neither a flag nor the environment has said.
    fn settle(&mut self) -> Result<(), Failure> {
        let config = self.config()?;
        let global = &mut self.global;
        let port = global.port.take().filter(|port| !port.is_empty());
        global.port = port.or_else(|| config.says("port").map(str::to_owned));
        let window = config.number("window").map(|window| window as u8);
        global.window = global.window.or(window);
        Ok(())
    }

    /// Where the arm is, if anything says so.
    pub(crate) fn port(&mut self) -> Result<Option<String>, Failure> {
        self.settle()?;
        Ok(self.global.port.clone())
    }

    /// Where the arm is.
    pub(crate) fn target(&mut self, sim: Option<Sim>) -> Result<Target, Failure> {
        self.settle()?;
        let given = self.global.port.as_deref().filter(|port| !port.is_empty());
        let speed = sim.map_or(SimSpeed::Max, |sim| sim.speed);
        Ok(match (given, sim) {
            (Some(port), _) => Target::parse(port, speed)?,
            (None, Some(sim)) if sim.unasked => Target::Sim(speed),
            (None, _) => Target::discover()?,
        })
    }
}
