//! The connection to the arm that is meant, and how it is to behave.

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

use super::policy::{Burns, Rules, UnderWay};
use super::{Context, FAREWELL};
use crate::failure::{Failure, Kind};
use crate::paint::tell;
use crate::progress::attended;
use crate::serving::grow;

/// How a verb treats the virtual arm in this process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sim {
    /// Speed of its clock where the port does not say.
    pub(crate) speed: SimSpeed,
    pub(crate) taken: Taken,
}

/// When the virtual arm in this process is taken without a port that names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Taken {
    /// Never: it has to be asked for.
    IfAsked,
    /// Where no arm is found.
    IfAlone,
    /// Always.
    Unasked,
}

/// An open connection, and what it was opened for.
pub(super) struct Connected {
    pub(super) arm: Arm,
    /// The `--station` or `--port`.
    place: Option<String>,
    /// Its line's end, where that is a station's.
    ends: Option<JoinHandle<()>>,
    /// Why that one broke, once it has.
    line: LineEnd,
    /// The lease of that line.
    lease: Option<LineLease>,
    /// Whether it waits for a line that breaks.
    reconnects: bool,
    /// What was set going over it that it cannot know of.
    pub(super) under_way: UnderWay,
}

impl Connected {
    /// Takes the lease at a station, which the work needs: a refusal leaves nothing behind. The lease
    /// of a program that is gone is waited for.
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
            "waiting for the lease of {}, which is gone, for up to {seconds:.0} s",
            visible(holder)
        );
        attended(json, &what, lease.take(free + LEASE_MARGIN)).await?;
        Ok(())
    }

    /// What a failure is about, where the line broke because the station refused something.
    pub(super) fn meant(&self, failure: Failure) -> Failure {
        match self.line.why() {
            Some(error @ ClientError::Refused { .. }) if failure.kind == PORT => error.into(),
            _ => failure,
        }
    }

    /// True if a signal has something to stop: a motion, a laser, a motor.
    pub(super) fn needs_stop(&self) -> bool {
        let moves = self.arm.moving() || !self.arm.motors().running().is_empty();
        self.under_way.needs_stop() || moves
    }

    /// True if the end of its station has something to stop: what was begun over this connection.
    /// Others may be ending their own runs on the arm.
    pub(super) fn needs_end(&self) -> bool {
        let moves = self.arm.moving() || !self.arm.motors().running().is_empty();
        self.under_way.laser == Some(Burns::WhileConnected) || moves
    }

    /// Ends it, and waits until a station has heard of it.
    pub(super) async fn close(self) {
        self.arm.close().await;
        if let Some(ends) = self.ends {
            let _ = timeout(FAREWELL, ends).await;
        }
    }
}

/// Time for the station to end a lease whose holder is gone, beyond that holder's own.
const LEASE_MARGIN: Duration = Duration::from_secs(1);

const PORT: Kind = Kind::Driver(magician::ErrorKind::Port);

/// A virtual arm of a verb's own making.
pub(super) struct Stage {
    arm: VirtualArm,
    /// Whether time is the arm's: it passes as fast as there is nothing to do, and nothing runs dry for want of it.
    in_arm_time: bool,
}

/// While it lasts, time passes as fast as there is nothing left to do.
pub(super) struct ArmTime;

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

impl Context {
    /// Puts up a virtual arm that is to be connected to where the arm is one in this process.
    pub(crate) fn put_up(&mut self, arm: VirtualArm) {
        let in_arm_time = false;
        self.stage = Some(Stage { arm, in_arm_time });
    }

    /// As [`put_up`](Self::put_up), an arm at its own speed, whose time is everybody's while the verb works with it: what it
    /// does takes as long by its clock as on a real one, and next to nothing by ours.
    pub(crate) fn put_up_in_arm_time(&mut self, arm: VirtualArm) {
        let in_arm_time = true;
        self.stage = Some(Stage { arm, in_arm_time });
    }

    /// Begins the time of the arm that was put up, if that is everybody's. Must be called within a runtime.
    pub(super) fn arm_time(&self) -> Option<ArmTime> {
        let stage = self.stage.as_ref().filter(|stage| stage.in_arm_time);
        stage.map(|_| ArmTime::begin())
    }

    /// Whether a connection is open already: a shell's.
    pub(crate) fn is_connected(&self) -> bool {
        self.connected.is_some()
    }

    /// The arm that this is connected to, if it is the one that is meant now.
    pub(crate) fn connected(&self) -> Option<&Arm> {
        let open = self.connected.as_ref();
        let open = open.filter(|open| open.place.as_deref() == self.global.place());
        open.map(|open| &open.arm)
    }

    /// The arm that is meant now, connected to if need be, for work under these rules. `sim` is what stands in for a port that is `sim`
    /// without a speed, or none.
    pub(super) async fn connect(
        &mut self,
        sim: Option<Sim>,
        rules: &Rules,
    ) -> Result<Arm, Failure> {
        // What a look opened waits for no line, and a job that burns must.
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
        connected.under_way.begins(rules);
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
            ends: None,
            line: LineEnd::default(),
            lease: None,
            reconnects,
            under_way: UnderWay::default(),
        })
    }

    /// As [`open`](Self::open), through a station.
    async fn open_at_station(&mut self, url: &str) -> Result<Connected, Failure> {
        let unusual = [
            ("--trace", self.global.trace.is_some()),
            ("--faults", self.global.faults.is_some()),
            ("--tool", self.global.virtual_tool.is_some()),
        ];
        if let Some((name, _)) = unusual.iter().find(|(_, given)| *given) {
            return Err(Failure::usage(format!("{name} does not go with --station")));
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
        homings.ask(&client, address.arm.as_deref()).await?;
        let (line, ends) = StationLine::open(&client, address.arm.as_deref(), self.global.yes);
        let (end, lease) = (line.end(), line.lease());
        let mut options = Options::default();
        // The station waits for the arm, and so do we.
        options.timeout = self.global.timeout.unwrap_or(Duration::from_secs(5));
        options.laser_pins = self.laser_pins()?;
        options.homings = Some(homings);
        options.end_notice = client.end_notice();
        options.virtual_arm = client.is_virtual(address.arm.as_deref()).await?;
        let arm = Arm::over(line, options).await?;
        Ok(Connected {
            arm,
            place: Some(url.to_owned()),
            ends: Some(ends),
            line: end,
            lease: Some(lease),
            reconnects: true,
            under_way: UnderWay::default(),
        })
    }

    /// Ends the connection; the arm stops what was set going over it.
    pub(super) async fn disconnect(&mut self) {
        if let Some(connected) = self.connected.take() {
            connected.close().await;
        }
    }

    /// How a connection is to behave.
    pub(crate) fn options(&mut self) -> Result<Options, Failure> {
        self.settle()?;
        let mut options = Options::default();
        options.timeout = self.global.timeout.unwrap_or(options.timeout);
        options.window = self.global.window.map_or(options.window, usize::from);
        // Between two lines of a shell a cable may come back.
        options.reconnect = self.in_shell;
        options.laser_pins = self.laser_pins()?;
        options.homings = magician_job::homings();
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
        let tracer = Tracer::new(grow(path)?).map_err(|error| {
            tracing::warn!(%error, "the trace cannot be written and stops here");
            error.to_string()
        });
        self.trace = Some((path.clone(), tracer.clone()));
        Ok(tracer.ok())
    }

    /// Ends the trace; why it is not whole, if it is not.
    pub(super) fn untraced(&self) -> Option<String> {
        let failed = self.trace.as_ref().map(|(_, trace)| trace);
        match failed? {
            Ok(tracer) => {
                tracer.end();
                tracer.failed()
            }
            Err(why) => Some(why.clone()),
        }
    }

    /// Where the arm is, if anything says so.
    pub(crate) fn port(&mut self) -> Result<Option<String>, Failure> {
        self.settle()?;
        Ok(self.global.port.clone())
    }

    /// Where the arm is.
    pub(crate) fn target(&mut self, sim: Option<Sim>) -> Result<Target, Failure> {
        self.settle()?;
        if self.global.station.is_some() {
            let message = "this needs the port of the arm itself: --station does not go with it";
            return Err(Failure::usage(message));
        }
        let given = self.global.port.as_deref().filter(|port| !port.is_empty());
        let speed = sim.map_or(SimSpeed::Max, |sim| sim.speed);
        Ok(match (given, sim) {
            (Some(port), _) => Target::parse(port, speed)?,
            (None, Some(sim)) if sim.taken == Taken::Unasked => Target::Sim(speed),
            (None, sim) => match Target::discover() {
                Err(error)
                    if error.code() == ErrorCode::NoArm
                        && sim.is_some_and(|sim| sim.taken == Taken::IfAlone) =>
                {
                    tell(format_args!("{error}; here is a virtual one"));
                    Target::Sim(speed)
                }
                found => found?,
            },
        })
    }
}

/// The trace file under way, or why there is none, and where it is.
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
                failure.hint("--station-ca FILE names the certificates to trust")
            }
            ClientError::Refused { data, .. } => match data["holder"]["name"].as_str() {
                Some(holder) => failure.hint(format!(
                    "try again when {} is done with the arm",
                    visible(holder)
                )),
                None => failure,
            },
            _ => failure,
        }
    }
}
