//! Opens the connection to the arm that the options, the environment or the settings name.
//!
//! The arm is reached over a port, in this process (`sim`) or through a station. A connection lasts
//! as long as the context: a shell's lines share it, until a line names another arm or needs a
//! connection that survives a broken line. At a station the connection carries a lease, which work
//! that moves the arm takes first.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use magician::sim::Controller;
use magician::{Arm, ErrorCode, LineOptions, Options, SimSpeed, Target, Tracer, VirtualArm};
use magician_protocol::visible;
use magician_station::client::{
    ClientError, LineEnd, LineLease, StationAddress, StationClient, StationHomings, StationLine,
};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::policy::{BurnEnd, Rules, Untracked};
use super::{Context, DISCONNECT_TIMEOUT};
use crate::failure::{Failure, Kind};
use crate::paint::print_stderr;
use crate::progress::announce_wait;
use crate::serving::open_growing;

/// Treatment of a virtual arm in this process by a verb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sim {
    /// Speed of its clock if the port does not name one.
    pub(crate) speed: SimSpeed,
    pub(crate) condition: VirtualArmUse,
}

/// Condition under which a virtual arm in this process is used without being named by the port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VirtualArmUse {
    /// Never: `sim` must be named.
    Named,
    /// If no arm is found.
    NoArmFound,
    /// Always, unless a port is given.
    NoPortGiven,
}

/// Open connection and what is known of it.
pub(super) struct Connected {
    pub(super) arm: Arm,
    /// Value of `--station` or `--port` it was opened for.
    place: Option<String>,
    /// Task that ends when the station's line has been closed; `None` without a station.
    line_end: Option<JoinHandle<()>>,
    /// Reason why the station's line broke, once it has.
    line: LineEnd,
    /// Lease of the station's line; `None` without a station.
    lease: Option<LineLease>,
    /// True if the driver reconnects when the line breaks.
    reconnects: bool,
    /// Motion or laser that this program started but the driver cannot track.
    pub(super) untracked: Untracked,
}

impl Connected {
    /// Takes the arm's lease at the station, which work needs before it begins: a refusal changes
    /// nothing on the arm. Waits for the lease of a program that is gone to expire.
    pub(super) async fn take_lease(&self, json: bool) -> Result<(), Failure> {
        let Some(lease) = &self.lease else {
            return Ok(());
        };
        let refused = match lease.take(Duration::ZERO).await {
            Ok(()) => return Ok(()),
            Err(refused) => refused,
        };
        let Some((holder, free)) = refused.free_soon() else {
            return Err(refused.into());
        };
        let seconds = free.as_secs_f64().ceil();
        let what = format!(
            "waiting up to {seconds:.0} s for the lease of {}, which has disconnected, to expire",
            visible(holder)
        );
        announce_wait(json, &what, lease.take(free + LEASE_MARGIN)).await?;
        Ok(())
    }

    /// Replaces a port failure by the station's refusal if that is why the line broke.
    pub(super) fn explain_failure(&self, failure: Failure) -> Failure {
        match self.line.why() {
            Some(error @ ClientError::Refused { .. }) if failure.kind == PORT_FAILURE => {
                error.into()
            }
            _ => failure,
        }
    }

    /// True if a signal has something to stop: a motion, a laser, a motor.
    pub(super) fn needs_stop(&self) -> bool {
        let moves = self.arm.moving() || !self.arm.motors().running().is_empty();
        self.untracked.needs_stop() || moves
    }

    /// True if the end of the station has something to stop: work begun over this connection. Other
    /// clients may be ending their own runs on the arm.
    pub(super) fn needs_end(&self) -> bool {
        let moves = self.arm.moving() || !self.arm.motors().running().is_empty();
        self.untracked.laser == Some(BurnEnd::WhileConnected) || moves
    }

    /// Closes the connection, and waits until the station has seen that.
    pub(super) async fn close(self) {
        self.arm.close().await;
        if let Some(ends) = self.line_end {
            // A station that does not close the line in time does not block the caller.
            let _ = timeout(DISCONNECT_TIMEOUT, ends).await;
        }
    }
}

/// Time for the station to end an expired lease and grant it, beyond the time that the lease has
/// left. A choice.
const LEASE_MARGIN: Duration = Duration::from_secs(1);

const PORT_FAILURE: Kind = Kind::Driver(magician::ErrorKind::Port);

/// Virtual arm that a verb has set up for its own connection.
pub(super) struct PreparedVirtualArm {
    arm: VirtualArm,
    /// True if process time is virtual while the verb works: waits take no wall time, so that
    /// nothing runs dry because the host is slow.
    in_arm_time: bool,
}

/// Guard that pauses tokio's clock: it advances to the next timer as soon as there is no work left.
pub(super) struct PausedClock;

impl PausedClock {
    fn begin() -> Self {
        tokio::time::pause();
        Self
    }
}

impl Drop for PausedClock {
    fn drop(&mut self) {
        tokio::time::resume();
    }
}

impl Context {
    /// Uses this virtual arm for connections of this verb to `sim`.
    pub(crate) fn use_virtual(&mut self, arm: VirtualArm) {
        let in_arm_time = false;
        self.stage = Some(PreparedVirtualArm { arm, in_arm_time });
    }

    /// Like [`use_virtual`](Self::use_virtual), but lets all timers of this process follow virtual
    /// time while the verb works. Motions take as long by the arm's clock as on a real arm, and
    /// almost no wall time.
    pub(crate) fn use_virtual_in_arm_time(&mut self, arm: VirtualArm) {
        let in_arm_time = true;
        self.stage = Some(PreparedVirtualArm { arm, in_arm_time });
    }

    /// Pauses tokio's clock if the verb's virtual arm asks for that. Must be called within a
    /// runtime.
    pub(super) fn arm_time(&self) -> Option<PausedClock> {
        let stage = self.stage.as_ref().filter(|stage| stage.in_arm_time);
        stage.map(|_| PausedClock::begin())
    }

    /// True if a connection is open already, as between lines of a shell.
    pub(crate) fn is_connected(&self) -> bool {
        self.connected.is_some()
    }

    /// Returns the arm of the open connection, if the options still name it.
    pub(crate) fn connected(&self) -> Option<&Arm> {
        let open = self.connected.as_ref();
        let open = open.filter(|open| open.place.as_deref() == self.global.place());
        open.map(|open| &open.arm)
    }

    /// Returns the arm that the options name, connecting if necessary, for work under these rules.
    /// `sim` is how the verb treats a virtual arm; `None` if it has no special rule.
    pub(super) async fn connect(
        &mut self,
        sim: Option<Sim>,
        rules: &Rules,
    ) -> Result<Arm, Failure> {
        // A connection opened for a look does not reconnect, but a job that burns needs
        // reconnection to switch the laser off.
        let fits = |open: &Connected| {
            open.place.as_deref() == self.global.place() && (open.reconnects || !rules.reconnects)
        };
        if !self.connected.as_ref().is_some_and(fits) {
            self.disconnect().await;
        }
        let mut connected = match self.connected.take() {
            Some(connected) => connected,
            None => self.open(sim, rules).await?,
        };
        connected.untracked.begin(rules);
        let arm = self.connected.insert(connected).arm.clone();
        let timeout = self.global.timeout;
        arm.set_timeout(timeout.unwrap_or(Options::default().timeout));
        Ok(arm)
    }

    async fn open(&mut self, sim: Option<Sim>, rules: &Rules) -> Result<Connected, Failure> {
        if let Some(station) = self.global.station.clone() {
            return self.open_at_station(&station).await;
        }
        let place = self.global.port.clone();
        let target = self.target(sim)?;
        let config = self.config()?;
        let mut options = self.options()?;
        options.reconnect |= rules.reconnects;
        let reconnects = options.reconnect;
        let options = options.for_arm(config.arm_at(&target));
        let tool = self.global.virtual_tool;
        if tool.is_some() && !matches!(target, Target::Sim(_)) {
            let hint =
                "`magician set EndEffectorParams x_bias=X y_bias=Y z_bias=Z` sets it on the arm";
            let message =
                format!("--tool sets the tool of a virtual arm, and {target} is a real one");
            return Err(Failure::usage(message).hint(hint));
        }
        let stage = self.stage.take().map(|stage| stage.arm);
        let arm = match (target, stage, tool) {
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
        Ok(Connected {
            arm,
            place,
            line_end: None,
            line: LineEnd::default(),
            lease: None,
            reconnects,
            untracked: Untracked::default(),
        })
    }

    /// Opens the arm like [`open`](Self::open), through a station.
    async fn open_at_station(&mut self, url: &str) -> Result<Connected, Failure> {
        // These options act on the line and on a virtual arm, which belong to the station.
        let unusual = [
            ("--trace", self.global.trace.is_some()),
            ("--faults", self.global.faults.is_some()),
            ("--tool", self.global.virtual_tool.is_some()),
        ];
        if let Some((name, _)) = unusual.iter().find(|(_, given)| *given) {
            return Err(Failure::usage(format!(
                "{name} cannot be used with --station"
            )));
        }
        let address: StationAddress = url.parse().map_err(Failure::invalid)?;
        let token = self.global.token_for(url);
        let trust = self.global.trust();
        let connecting = StationClient::connect_trusting(url, "magician", token.as_deref(), &trust);
        let client = connecting.await?;
        let arms = client.hello()["arms"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        let known = |arm: &str| arms.iter().any(|name| name == arm);
        if address.arm.is_none() && arms.len() != 1
            || address.arm.as_deref().is_some_and(|arm| !known(arm))
        {
            let names: Vec<_> = arms.iter().filter_map(|name| name.as_str()).collect();
            let message = format!("the station has the arms {}", names.join(", "));
            return Err(Failure::invalid(message).hint("name one: --station http://HOST:PORT/ARM"));
        }
        let homings = Arc::new(StationHomings::default());
        homings.read_from(&client, address.arm.as_deref()).await?;
        let (line, ends) = StationLine::open(&client, address.arm.as_deref(), self.global.yes);
        let (end, lease) = (line.end(), line.lease());
        let mut options = Options::default();
        // The station itself waits for the arm's answer, so the default timeout could end before
        // the station's. 5 s is a choice.
        options.timeout = self.global.timeout.unwrap_or(Duration::from_secs(5));
        options.laser_pins = self.laser_pins()?;
        options.homings = Some(homings);
        options.end_notice = client.end_notice();
        options.virtual_arm = client.is_virtual(address.arm.as_deref()).await?;
        let arm = Arm::over(line, options).await?;
        Ok(Connected {
            arm,
            place: Some(url.to_owned()),
            line_end: Some(ends),
            line: end,
            lease: Some(lease),
            // The station reconnects a broken line to the arm itself.
            reconnects: true,
            untracked: Untracked::default(),
        })
    }

    /// Closes the connection; motions that it started are stopped.
    pub(super) async fn disconnect(&mut self) {
        if let Some(connected) = self.connected.take() {
            connected.close().await;
        }
    }

    /// Returns the connection options that flags and settings ask for.
    pub(crate) fn options(&mut self) -> Result<Options, Failure> {
        self.apply_config()?;
        let mut options = Options::default();
        options.timeout = self.global.timeout.unwrap_or(options.timeout);
        options.window = self.global.window.map_or(options.window, usize::from);
        // In a shell a cable may be unplugged and plugged in again between two lines.
        options.reconnect = self.in_shell;
        options.laser_pins = self.laser_pins()?;
        options.homings = magician_job::homings();
        options.faults = self.global.faults.unwrap_or_default();
        options.trace = self.tracer()?;
        Ok(options)
    }

    /// Returns the options of a bare line: faults and trace.
    pub(crate) fn line_options(&mut self) -> Result<LineOptions, Failure> {
        let mut options = LineOptions::default();
        options.faults = self.global.faults.unwrap_or_default();
        options.trace = self.tracer()?;
        Ok(options)
    }

    /// Returns the trace that was asked for. All lines of this program share one file.
    fn tracer(&mut self) -> Result<Option<Tracer>, Failure> {
        let Some(path) = &self.global.trace else {
            return Ok(None);
        };
        if let Some((_, tracer)) = self.trace.as_ref().filter(|(known, _)| known == path) {
            return Ok(tracer.clone().ok());
        }
        // A trace that cannot be written (a full disk) does not stop the work that is traced.
        let tracer = Tracer::new(open_growing(path)?).map_err(|error| {
            tracing::warn!(%error, "the trace cannot be written and ends here");
            error.to_string()
        });
        self.trace = Some((path.clone(), tracer.clone()));
        Ok(tracer.ok())
    }

    /// Ends the trace. Returns why it is incomplete, or `None` if it is complete.
    pub(super) fn end_trace(&self) -> Option<String> {
        let failed = self.trace.as_ref().map(|(_, trace)| trace);
        match failed? {
            Ok(tracer) => {
                tracer.end();
                tracer.failed()
            }
            Err(why) => Some(why.clone()),
        }
    }

    /// Returns the port, if a flag, the environment or the settings name one.
    pub(crate) fn port(&mut self) -> Result<Option<String>, Failure> {
        self.apply_config()?;
        Ok(self.global.port.clone())
    }

    /// Returns the target to connect to, searching for an arm if no port is given.
    pub(crate) fn target(&mut self, sim: Option<Sim>) -> Result<Target, Failure> {
        self.apply_config()?;
        if self.global.station.is_some() {
            let message = "this needs the port of the arm: it cannot be used with --station";
            return Err(Failure::usage(message));
        }
        let given = self.global.port.as_deref().filter(|port| !port.is_empty());
        let speed = sim.map_or(SimSpeed::Max, |sim| sim.speed);
        Ok(match (given, sim) {
            (Some(port), _) => Target::parse(port, speed)?,
            (None, Some(sim)) if sim.condition == VirtualArmUse::NoPortGiven => Target::Sim(speed),
            (None, sim) => match Target::discover() {
                Err(error)
                    if error.code() == ErrorCode::NoArm
                        && sim.is_some_and(|sim| sim.condition == VirtualArmUse::NoArmFound) =>
                {
                    print_stderr(format_args!("{error}; using a virtual arm"));
                    Target::Sim(speed)
                }
                found => found?,
            },
        })
    }
}

/// Path of the trace, with its tracer or the reason for its absence.
pub(super) type Trace = (PathBuf, Result<Tracer, String>);

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let kind = match (&error, error.kind()) {
            (ClientError::Address(_), _) => magician::ErrorKind::InvalidInput,
            (_, Some("dangerous")) => return Self::usage(error.to_string()),
            _ => magician::ErrorKind::Port,
        };
        let failure = Self::new(Kind::Driver(kind), error.to_string());
        match error {
            ClientError::Untrusted(_) => {
                failure.hint("--station-ca FILE gives the certificates to trust")
            }
            ClientError::Refused { data, .. } => match data["holder"]["name"].as_str() {
                Some(holder) => failure.hint(format!(
                    "try again when {} has released the arm",
                    visible(holder)
                )),
                None => failure,
            },
            _ => failure,
        }
    }
}
