//! What a verb works with: the global options, the output, and the arm once it is asked for, under a policy.

mod connect;
mod job;
mod policy;
mod stop;
mod work;

use std::ffi::OsString;
use std::rc::Rc;
use std::time::Duration;

use clap::builder::StyledStr;
use magician::ErrorKind;
use magician_program::Diagnostic;
use tokio::runtime::{Builder, Runtime};

use crate::config::Config;
use crate::failure::{Failure, Kind};
use crate::options::Global;
use crate::output::{Output, Text};
use crate::saved::SavedSettings;

use connect::{Connected, Stage, Trace};
pub(crate) use connect::{Sim, Taken};
pub(crate) use job::Ended;
pub(crate) use policy::{Burns, JobPolicy, StopPolicy, ToldPolicy};
pub(crate) use stop::{INTERRUPTED, STATION_ENDED, kind_of_stop, not_confirmed, place, stop};

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
    connected: Option<Connected>,
    /// The file of settings, once it has been read.
    config: Option<Rc<Config>>,
    trace: Option<Trace>,
    /// A virtual arm of the verb's own making, to be connected to where the arm is a virtual one in this process.
    stage: Option<Stage>,
    /// Settings that the verb under way owes the arm.
    pub(crate) saved: SavedSettings,
    /// Whether more lines follow: Ctrl-C then stops the arm and keeps the connection.
    in_shell: bool,
    /// Whether the laser may burn during the verb under way: a person said so.
    laser_allowed: bool,
    /// Whether the system wants this program to end, more lines or not.
    terminated: bool,
}

/// How long a stop may take before this program ends without knowing.
pub(crate) const STAND_BY: Duration = Duration::from_secs(3);

/// How long connections that were dropped get for their last words.
pub(crate) const FAREWELL: Duration = Duration::from_millis(600);

impl Context {
    pub(crate) fn new(global: Global, out: Output, command_line: CommandLine) -> Self {
        Self {
            global,
            out,
            command_line,
            runtime: None,
            connected: None,
            config: None,
            trace: None,
            stage: None,
            saved: SavedSettings::default(),
            in_shell: false,
            laser_allowed: false,
            terminated: false,
        }
    }

    /// A command line begins that was given these options.
    pub(crate) fn begins(&mut self, global: Global) {
        self.global = global;
        self.laser_allowed = self.global.yes;
    }

    /// From here on more lines follow.
    pub(crate) fn enter_shell(&mut self) {
        self.in_shell = true;
    }

    /// Whether more lines follow.
    pub(crate) fn in_shell(&self) -> bool {
        self.in_shell
    }

    /// Whether the system wants this program to end, more lines or not.
    pub(crate) fn is_terminated(&self) -> bool {
        self.terminated
    }

    /// Whether the laser may burn during this verb.
    pub(crate) fn laser_is_allowed(&self) -> bool {
        self.laser_allowed
    }

    /// Lets it burn.
    pub(crate) fn allow_laser(&mut self) {
        self.laser_allowed = true;
    }

    /// Shows an object as JSON with `--json`, otherwise as the lines that `text` writes.
    pub(crate) fn show<T: serde::Serialize>(
        &mut self,
        value: &T,
        text: impl FnOnce(&mut Output) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        if self.global.json {
            self.out.json(value)
        } else {
            text(&mut self.out)
        }
    }

    /// Tells a note, before the result that it is about.
    pub(crate) fn note(&mut self, note: &Diagnostic) {
        self.out.note(note, self.global.json);
    }

    /// Shows help that clap has styled.
    pub(crate) fn show_styled(&mut self, help: &StyledStr) -> Result<(), Failure> {
        self.show(&Text::from(help), |out| out.styled(help))
    }

    /// The runtime that everything with a line to an arm runs on: one thread.
    fn runtime(&mut self) -> Result<Rc<Runtime>, Failure> {
        if let Some(runtime) = &self.runtime {
            return Ok(runtime.clone());
        }
        let runtime = check_descriptors();
        let runtime = runtime.and_then(|()| Builder::new_current_thread().enable_all().build());
        let runtime = Rc::new(runtime.map_err(|error| {
            let message = format!("the event loop cannot be started: {error}");
            Failure::new(Kind::Driver(ErrorKind::Port), message)
        })?);
        Ok(self.runtime.insert(runtime).clone())
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
}

/// Checks that there are descriptors for an event loop and its signals, which end the program otherwise.
#[cfg(unix)]
fn check_descriptors() -> std::io::Result<()> {
    use std::os::unix::net::UnixStream;
    // As many as tokio opens until its signals are heard, closed again at once.
    let pairs: Result<Vec<_>, _> = (0..3).map(|_| UnixStream::pair()).collect();
    pairs.map(drop)
}

#[cfg(not(unix))]
fn check_descriptors() -> std::io::Result<()> {
    Ok(())
}
