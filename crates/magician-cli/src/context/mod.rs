//! Surroundings of a verb: the global options, the output, and the arm, which a verb gets only
//! under a policy.

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

use connect::{Connected, PreparedVirtualArm, Trace};
pub(crate) use connect::{Sim, VirtualArmUse};
pub(crate) use job::JobFailure;
pub(crate) use policy::{BurnEnd, JobPolicy, SignalPolicy, StopPolicy};
pub(crate) use stop::{
    INTERRUPTED, STATION_ENDED, format_position, kind_of_stop, not_confirmed, stop,
};

/// Access to the whole command line, for verbs that show it or run lines of it.
#[derive(Clone, Copy)]
pub(crate) struct CommandLine {
    /// Returns all verbs and options.
    pub(crate) description: fn() -> clap::Command,
    /// Runs one line of a shell that was started with these options.
    pub(crate) follow: fn(&[OsString], &Global, &mut Context) -> Result<(), Failure>,
}

/// Surroundings of a verb. A shell has one for all of its lines.
pub(crate) struct Context {
    pub(crate) global: Global,
    pub(crate) out: Output,
    pub(crate) command_line: CommandLine,
    runtime: Option<Rc<Runtime>>,
    connected: Option<Connected>,
    /// Settings file, once it has been read.
    config: Option<Rc<Config>>,
    trace: Option<Trace>,
    /// Virtual arm that the verb has set up, used if the target is `sim`.
    stage: Option<PreparedVirtualArm>,
    /// Settings that the running verb changed and must restore on the arm.
    pub(crate) saved: SavedSettings,
    /// True in a shell: Ctrl-C then stops the arm and keeps the connection.
    in_shell: bool,
    /// True if the user has allowed the laser for the running verb.
    laser_allowed: bool,
    /// True once SIGTERM or SIGHUP came: a shell then ends too.
    terminated: bool,
}

/// Longest wait for the arm to confirm a stop before the program ends without knowing. A choice:
/// long for a line that answers, short for a user who waits.
pub(crate) const STOP_CONFIRM_TIMEOUT: Duration = Duration::from_secs(3);

/// Longest wait for dropped connections to send their last frames (stop, laser off). A choice.
pub(crate) const DISCONNECT_TIMEOUT: Duration = Duration::from_millis(600);

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

    /// Begins a command line with these options.
    pub(crate) fn begin(&mut self, global: Global) {
        self.global = global;
        self.laser_allowed = self.global.yes;
    }

    /// Enters shell mode: more lines follow.
    pub(crate) fn enter_shell(&mut self) {
        self.in_shell = true;
    }

    /// True in a shell.
    pub(crate) fn in_shell(&self) -> bool {
        self.in_shell
    }

    /// True if the lease at a station ends with this command, and with it whatever has no end of
    /// its own: a belt, the laser. A shell keeps its lease.
    pub(crate) fn lease_ends_at_once(&self) -> bool {
        self.global.station.is_some() && !self.in_shell
    }

    /// True once the system has asked this program to end.
    pub(crate) fn is_terminated(&self) -> bool {
        self.terminated
    }

    /// True if the laser may burn during this verb.
    pub(crate) fn laser_is_allowed(&self) -> bool {
        self.laser_allowed
    }

    /// Allows the laser for this verb.
    pub(crate) fn allow_laser(&mut self) {
        self.laser_allowed = true;
    }

    /// Prints a value as JSON with `--json`, otherwise the lines that `text` writes.
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

    /// Prints a note. Notes come before the result they are about.
    pub(crate) fn note(&mut self, note: &Diagnostic) {
        self.out.note(note, self.global.json);
    }

    /// Prints help that clap has styled.
    pub(crate) fn show_styled(&mut self, help: &StyledStr) -> Result<(), Failure> {
        self.show(&Text::from(help), |out| out.styled(help))
    }

    /// Returns the runtime for all connections: one thread.
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

    /// Returns the settings file, which is read at the first call.
    pub(crate) fn config(&mut self) -> Result<Rc<Config>, Failure> {
        if self.config.is_none() {
            self.config = Some(Rc::new(Config::load()?));
        }
        Ok(self.config.clone().unwrap_or_default())
    }

    /// Fills in from the settings file the options that neither a flag nor the environment has set.
    fn apply_config(&mut self) -> Result<(), Failure> {
        let config = self.config()?;
        let global = &mut self.global;
        let port = global.port.take().filter(|port| !port.is_empty());
        global.port = port.or_else(|| config.file_value("port").map(str::to_owned));
        let window = config.number("window").map(|window| window as u8);
        global.window = global.window.or(window);
        Ok(())
    }
}

/// Checks that enough file descriptors are left for an event loop and its signals. Without them
/// tokio would end the program later, in the middle of the work.
#[cfg(unix)]
fn check_descriptors() -> std::io::Result<()> {
    use std::os::unix::net::UnixStream;
    // tokio opens this number before its signals work. They are closed again at once.
    let pairs: Result<Vec<_>, _> = (0..3).map(|_| UnixStream::pair()).collect();
    pairs.map(drop)
}

#[cfg(not(unix))]
fn check_descriptors() -> std::io::Result<()> {
    Ok(())
}
