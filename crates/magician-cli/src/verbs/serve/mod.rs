//! `serve`: shares one or more arms between many programs, people and pages.
//!
//! Order of the start: addresses are bound first, since other programs may hold them, then the arms
//! are opened, then requests are accepted. At the end the station ends its runs, so that each
//! holder can stop its own work; a second signal skips that.

mod front;
mod link;
mod site;
mod studio;
mod surfaces;
mod window;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::{Args, ValueHint};
use magician::commands::DeviceSn;
use magician::{Arm, ErrorKind, SimSpeed, Target, VirtualArm};
use magician_job::dirs;
use magician_job::presets::Presets;
use magician_station::class::{ClassFile, Schedule};
use magician_station::http::{
    JobFolder, JobStoreError, JournalFile, ListenError, Listener, Pages, RecordingFolder, TlsError,
    TokenError, TokenStore,
};
use magician_station::{
    ArmEntry, ForcedStop, FormatReader, FrameRing, ProgramStore, RunningStation, StationConfig,
};
use serde_json::json;
use tokio::sync::watch;
use tokio::time::timeout;

pub(crate) use self::front::FrontFlags;
use self::link::{Link, LinkFlags};
use self::site::SiteFlags;
use super::sim::scenario_of;
use crate::config::Config;
use crate::context::{Context, Sim, VirtualArmUse};
use crate::failure::{Failure, Kind};
use crate::interrupt::Signals;
use crate::mdns::Announcement;
use crate::paint::print_stderr;
use crate::serving::{print_ready, unix_time};
use crate::verbs::job;
use magician::stations::{Holder, folder};
pub(crate) use site::name_of_site;
#[cfg(feature = "site")]
pub(crate) use site::print_linger_warning;
#[cfg(not(feature = "site"))]
pub(crate) use site::unsupported;
pub(crate) use studio::Studio;
#[cfg(feature = "site")]
pub(crate) use studio::{open_in_browser, pages};
pub(crate) use window::is_started_by_hand;

/// Longest wait for listeners and a site to close at the end. A choice.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(2);

/// Share arms on the network: many watch, one moves, anyone stops
#[derive(Args, Debug)]
#[command(after_help = "\
Prints the single line `ready` (with --json an object with the addresses) when everything accepts \
connections. Ends with Ctrl-C or SIGTERM: motion stops, the laser is switched off, jobs lift their \
pen. Clients that run something on an arm are notified and have a few seconds to lift their pen and \
restore settings; a second Ctrl-C ends this wait.

  magician serve --port sim
  magician serve --port /dev/ttyUSB0 --listen 192.168.1.5:8910 --pair
  magician serve --arm left=/dev/ttyUSB0 --arm right=/dev/ttyUSB1
  magician serve                       all [arms.NAME] of the settings, else the only arm found

Programs use JSON-RPC at ws://HOST:8910/api/v1/ws, or POST one request to /api/v1/rpc; \
/api/v1/openrpc.json lists the methods. Without --listen only this machine can connect, without a \
token. Other machines need a token: `magician station token` creates one, `magician station pair` a \
code for one.")]
pub(crate) struct Serve {
    /// Serve this arm under a name, instead of --port (repeatable)
    #[arg(long, value_name = "NAME=PORT", value_parser = named)]
    arm: Vec<(String, String)>,
    #[command(flatten)]
    front: FrontFlags,
    /// Do not announce the station on the local network; a station that only this machine can reach
    /// is never announced
    #[arg(long)]
    no_announce: bool,
    /// Serve only the API, without the page at /
    #[arg(long)]
    no_studio: bool,
    /// Class to serve, a TOML file of pupils, codes and rules [default: the last class]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    class: Option<PathBuf>,
    /// Schedule of the arms, a TOML file [default: the last schedule]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    schedule: Option<PathBuf>,
    #[command(flatten)]
    link: LinkFlags,
    #[command(flatten)]
    site: SiteFlags,
    /// World of the virtual arms: a TOML file, or a built-in one (cubes, drawing, pick_and_sort,
    /// faults, engraving)
    #[arg(long, value_name = "FILE|NAME")]
    scenario: Option<PathBuf>,
    #[arg(skip)]
    shown: PageDisplay,
}

/// Way to show the page once the station accepts connections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum PageDisplay {
    #[default]
    No,
    /// The command prints the address.
    AsAddress,
    /// In the system's browser.
    InBrowser,
    /// In a separate window. Closing the window ends the station.
    InWindow,
}

/// Data that a station keeps, and the reader of programs.
struct StationData {
    tokens: TokenStore,
    reader: FormatReader,
    programs: Option<Arc<dyn ProgramStore>>,
    presets: Presets,
    student_laser: bool,
    class: Option<String>,
    schedule: Option<String>,
    ring: RecordingRing,
    lines: Vec<Arc<FrameRing>>,
}

/// Recording of the last ten minutes of each arm.
#[derive(Clone, Copy)]
struct RecordingRing {
    /// Readings a second while an arm moves; 0 to use only readings that clients ask for.
    rate: u32,
    save_on_alarm: bool,
}

impl RecordingRing {
    /// Default rate of readings while an arm moves, Hz: one per control period (model section 7).
    const RATE: f64 = 50.0;

    fn of(config: &Config) -> Self {
        // Without a state folder of the system there is no place for the files.
        let asked = config.number("serve.ring").unwrap_or(Self::RATE);
        Self {
            rate: dirs::state().map_or(0, |_| asked as u32),
            save_on_alarm: config.file_value("serve.save_on_alarm") != Some("false"),
        }
    }
}

/// Parses `NAME=PORT`.
fn named(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(_, port)| !port.is_empty());
    let (name, port) = pair.ok_or("expected NAME=PORT")?;
    Ok((name.to_owned(), port.to_owned()))
}

const NAME_RULE: &str =
    "a name has up to 32 of a-z, 0-9, _ and -, and begins with a letter or a digit";

/// Fails if this is no valid name for an arm.
fn check_name(name: &str) -> Result<(), Failure> {
    if magician_station::is_name(name) {
        Ok(())
    } else {
        let message = format!("`{name}` is not a valid name for an arm");
        Err(Failure::invalid(message).hint(NAME_RULE))
    }
}

impl Serve {
    pub(crate) fn run(mut self, context: &mut Context) -> Result<(), Failure> {
        self.site.check()?;
        let targets = self.targets(context)?;
        let config = context.config()?;
        self.fill_in(&config);
        self.link.check()?;
        let student_laser = config.file_value("serve.student_laser") == Some("true");
        let scenario = self
            .scenario
            .is_some()
            .then(|| scenario_of(self.scenario.as_deref()));
        let scenario = scenario.transpose()?.unwrap_or_default();
        let store = self.front.tokens()?;
        let tls = self.front.tls()?;
        let ring = RecordingRing::of(&config);
        let mut arms = Vec::new();
        let mut lines = Vec::new();
        for (name, target) in targets {
            let mut options = context.options()?;
            options.reconnect = true;
            let mut options = options.for_arm(config.arm_at(&target));
            if ring.rate > 0 {
                let line = FrameRing::new(port_of(&target));
                options.trace = Some(
                    options
                        .trace
                        .unwrap_or_default()
                        .tap(Arc::clone(&line) as _),
                );
                lines.push(line);
            }
            let entry = ArmEntry {
                name,
                port: port_of(&target),
                is_virtual: matches!(target, Target::Sim(_)),
                laser_pins: options.laser_pins,
                fence: options.fence,
            };
            arms.push((entry, target, options));
        }
        let read = |file: &PathBuf| {
            let wrong = |error| Failure::invalid(format!("{}: {error}", file.display()));
            std::fs::read_to_string(file).map_err(wrong)
        };
        let class = self.class.as_ref().map(read).transpose()?;
        let schedule = self.schedule.as_ref().map(read).transpose()?;
        let flawed = |file: &Option<PathBuf>, error| {
            let file = file.as_deref().unwrap_or(std::path::Path::new(""));
            Failure::invalid(format!("{}: {error}", file.display()))
        };
        if let Some(text) = &class {
            ClassFile::parse(text).map_err(|error| flawed(&self.class, error))?;
        }
        if let Some(text) = &schedule {
            let read = Schedule::parse(text).map_err(|error| flawed(&self.schedule, error))?;
            let known = |arm: &str| arms.iter().any(|(entry, ..)| entry.name == arm);
            if let Some(arm) = read.arms().find(|arm| !known(arm)) {
                let message =
                    format!("the schedule has slots of an arm {arm}, which is not served");
                return Err(Failure::invalid(message)
                    .hint("the names of arms are those of --arm NAME=PORT"));
            }
        }
        let presets = Presets::of_user();
        let reader = FormatReader::new(job::defaults(&config)?);
        let mut reader = reader.with_presets(presets.clone());
        let programs = self.front.programs()?;
        if let Some(programs) = &programs {
            reader = reader.with_library(Arc::clone(programs));
        }
        let json = context.global.json;
        context.close_connection()?;
        context.run_without_arm(async |_, signals| {
            // Addresses first: another program may hold them, and then no arm should have been
            // opened.
            let listener = self.front.bind(tls).await?;
            let link = self.link.bind().await?;
            let mut connected = Vec::new();
            for (_, target, options) in &arms {
                let opened = match target {
                    Target::Sim(speed) => {
                        let arm = VirtualArm::in_scenario_at(&scenario, *speed);
                        Arm::simulated(arm.with_breaking_lines(), options.clone()).await
                    }
                    _ => Arm::connect_with(target, options.clone()).await,
                };
                connected.push(opened?);
            }
            let entries: Vec<_> = arms.iter().map(|(entry, ..)| entry.clone()).collect();
            let kept = StationData {
                tokens: store,
                reader,
                programs,
                presets,
                student_laser,
                class,
                schedule,
                ring,
                lines,
            };
            self.serve(json, kept, (listener, link), entries, connected, signals)
                .await
        })
    }

    /// True if neither the arm nor the address is given.
    fn is_default(&self, context: &Context) -> bool {
        let port = context.global.port.as_deref().unwrap_or_default();
        self.arm.is_empty() && self.front.listen.is_none() && port.is_empty()
    }

    /// Fills in settings that no flag sets.
    fn fill_in(&mut self, config: &Config) {
        self.front.fill_in(config);
        if config.file_value("serve.link") == Some("true") {
            self.link.enabled_by_settings();
        }
    }

    /// Returns the arms by name: those of the flags, else those of the settings, else the default
    /// arm.
    fn targets(&self, context: &mut Context) -> Result<Vec<(String, Target)>, Failure> {
        let sim = Sim {
            speed: SimSpeed::Times(1.0),
            condition: match self.shown {
                PageDisplay::InWindow => VirtualArmUse::NoArmFound,
                _ => VirtualArmUse::Named,
            },
        };
        if self.arm.is_empty() {
            let config = context.config()?;
            let port = context.global.port.as_deref().unwrap_or_default();
            if port.is_empty() && context.global.station.is_none() && !config.arms().is_empty() {
                let known = config.arms().iter();
                let known = known.map(|arm| {
                    check_name(&arm.name)?;
                    Ok((arm.name.clone(), arm.port.clone()))
                });
                return known.collect();
            }
            let name = self.site.name_of_only_arm();
            let name = name.unwrap_or_else(|| "arm".to_owned());
            return Ok(vec![(name, context.target(Some(sim))?)]);
        }
        if context.global.port.is_some() {
            return Err(
                Failure::usage("--arm cannot be used with --port").hint("name all arms by --arm")
            );
        }
        let mut names = BTreeSet::new();
        let mut targets = Vec::new();
        for (name, port) in &self.arm {
            check_name(name)?;
            if !names.insert(name) {
                return Err(Failure::invalid(format!("two arms are named {name}")));
            }
            targets.push((name.clone(), Target::parse(port, sim.speed)?));
        }
        Ok(targets)
    }

    async fn serve(
        &self,
        json: bool,
        kept: StationData,
        (listener, link): (Listener, Option<Link>),
        entries: Vec<ArmEntry>,
        arms: Vec<Arm>,
        signals: &mut Signals,
    ) -> Result<(), Failure> {
        let StationData {
            tokens: store,
            reader,
            programs,
            presets,
            student_laser,
            class,
            schedule,
            ring,
            lines,
        } = kept;
        let epoch = format!("{:x}", unix_time().as_millis());
        let mut config = StationConfig::new(entries.clone(), epoch);
        config.read_only = self.front.read_only;
        config.student_laser = student_laser;
        (config.class, config.schedule) = (class, schedule);
        config.reader = Arc::new(reader);
        config.surfaces = Arc::new(surfaces::Surfaces::for_arms(&entries));
        config.presets = presets;
        config.ring = ring.rate;
        config.save_on_alarm = ring.save_on_alarm;
        config.lines = lines;
        if let Some(programs) = programs {
            config.programs = programs;
        }
        if let Some(folder) = folder() {
            let serials = serials(&arms).await;
            config.jobs = Arc::new(JobFolder::open(folder, &entries, &serials)?);
        }
        if let Some(state) = dirs::state() {
            config.recordings = Arc::new(RecordingFolder::at(state.join("recordings")));
        }
        let journal = folder().map(|folder| JournalFile::at(folder.join("journal.jsonl")));
        // A line that cannot be written is logged, and the station continues.
        let sink = Box::new(move |line| {
            if let Some(journal) = &journal {
                journal.write(&line);
            }
        });
        // Read last: the station counts time from its start and dates all times by this.
        config.unix_zero = unix_time().as_secs_f64();
        let station = RunningStation::start(config, arms.clone(), sink);
        let joined = self.site.join(&entries, &station, &store).await?;
        let (url, api) = (listener.url(), listener.api_url());
        let exposed = !listener.is_loopback();
        let names: Vec<_> = entries.iter().map(|entry| entry.name.clone()).collect();
        let announced = (exposed && !self.no_announce)
            .then(|| Announcement::new(listener.addresses(), listener.is_encrypted(), &names));
        let service = link.is_some().then(|| self.link.service(&station));
        let pages = if self.no_studio {
            Pages::default()
        } else {
            studio::pages()
        };
        // Valid on this machine only, so the site does not get it.
        let (store_here, own) = store.clone().with_own()?;
        let mut options = self.front.http(store_here, pages);
        options.link = service.clone().map(link::calls);
        let (over, ends) = watch::channel(false);
        let linked = link.as_ref().map(Link::url);
        let linking = match (link, &service) {
            (Some(link), Some(service)) => Some(tokio::spawn(link.serve(
                service.clone(),
                self.front.admission(),
                ends.clone(),
            ))),
            _ => None,
        };
        let serving = tokio::spawn(listener.serve(station.clone(), options, ends));
        let ports: Vec<_> = entries.iter().map(|entry| entry.port.clone()).collect();
        let holder = Holder::write(&url, &ports, &names, own);
        print_stderr(format_args!("serving {url}"));
        if let Some(pin) = station.pin() {
            print_stderr(format_args!(
                "the teacher's PIN of the class is {pin}: without it, pages on this computer can only watch and stop"
            ));
        }
        if let Some(joined) = &joined {
            let (name, station) = (joined.name(), joined.station());
            let arms = names.join(", ");
            print_stderr(format_args!(
                "on the site {name} as station {station}: {arms}"
            ));
        }
        if let Some(linked) = &linked {
            print_stderr(format_args!("programs for DobotLink at {linked}"));
        }
        if exposed {
            print_stderr(format_args!(
                "other computers can connect, each with a token"
            ));
        }
        if let Some(Err(error)) = &announced {
            print_stderr(format_args!("not announced on the local network: {error}"));
        }
        self.front.print_code(&store)?;
        if exposed && self.shown != PageDisplay::No && !json {
            studio::show_address(&studio::external_address(&url));
        }
        studio::show(self.shown, &url);
        if json {
            print_addresses(&url, &api, linked.as_deref(), joined.as_ref(), &entries)?;
        } else {
            print_ready();
        }
        let mut never_shown = None;
        tokio::select! {
            _ = signals.next() => {}
            closed = window::wait_until_closed(&station), if self.shown == PageDisplay::InWindow => never_shown = closed.err(),
        }
        let stopping = async {
            // Leaving the site runs in parallel, so that a slow network does not delay the stops.
            let leaving = joined.map(|joined| tokio::spawn(joined.leave()));
            let ended = station.end_runs().await;
            for ForcedStop { arm, holder, .. } in ended.forced_stops {
                print_stderr(format_args!(
                    "{arm} was stopped while {holder} held it and did not stop it in time: a pen may be down"
                ));
            }
            // The arms stand from here on, so errors and timeouts of the cleanup are ignored.
            if let Some(leaving) = leaving {
                let _ = timeout(CLOSE_TIMEOUT, leaving).await;
            }
            // The servers end after the runs, so that clients receive the last states.
            let _ = over.send(true);
            let _ = timeout(CLOSE_TIMEOUT, serving).await;
            if let Some(linking) = linking {
                let _ = timeout(CLOSE_TIMEOUT, linking).await;
            }
            ended.unconfirmed
        };
        let unconfirmed = tokio::select! {
            unconfirmed = stopping => unconfirmed,
            // Second stop: end without waiting for the holders.
            _ = signals.next() => {
                let _ = station.end_runs().await;
                return Err(Failure::interrupted());
            }
        };
        // A stalled disk must not delay the end of the program for long. 500 ms is a choice.
        let _ = timeout(Duration::from_millis(500), station.close_recordings()).await;
        station.flush().await;
        drop(station);
        for arm in arms {
            // A silent arm must not delay it either.
            let _ = timeout(Duration::from_millis(500), arm.close()).await;
        }
        drop((holder, announced));
        if let Some(failure) = not_stopped(&unconfirmed) {
            return Err(failure);
        }
        never_shown.map_or(Ok(()), Err)
    }
}

/// Returns the arms' serial numbers; empty for an arm that reports none.
async fn serials(arms: &[Arm]) -> Vec<String> {
    let mut serials = Vec::new();
    for arm in arms {
        let serial = arm.get::<DeviceSn>().await;
        let serial = serial.map(|serial| serial.device_sn.to_string());
        serials.push(serial.unwrap_or_default().trim().to_owned());
    }
    serials
}

/// Returns a target in the notation that users type.
pub(crate) fn port_of(target: &Target) -> String {
    match target {
        Target::Sim(SimSpeed::Times(speed)) if *speed == 1.0 => "sim".to_owned(),
        target => target.to_string(),
    }
}

/// Returns the failure of a station that could not stop these arms, each with a reason; `None` if
/// all were stopped.
fn not_stopped(unconfirmed: &[(String, String)]) -> Option<Failure> {
    if unconfirmed.is_empty() {
        return None;
    }
    let arms = { unconfirmed.iter() }.map(|(arm, why)| {
        format!("{arm} did not confirm that it stands with an empty queue: {why}")
    });
    let said = arms.collect::<Vec<_>>().join("; ");
    let failure = Failure::new(Kind::Driver(ErrorKind::Timeout), said);
    Some(failure.hint("look at the arm: its power switch stops it"))
}

fn print_addresses(
    url: &str,
    api: &str,
    link: Option<&str>,
    site: Option<&site::SiteMembership>,
    entries: &[ArmEntry],
) -> Result<(), Failure> {
    use std::io::Write;
    let arms = entries
        .iter()
        .map(|entry| json!({"name": entry.name, "port": entry.port}));
    let arms: Vec<_> = arms.collect();
    let ready = json!({
        "ready": true,
        "url": url,
        "api": api,
        "link": link,
        "site": site.map(|site| json!({"name": site.name(), "station": site.station()})),
        "arms": arms,
    });
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{ready}")?;
    Ok(stdout.flush()?)
}

impl From<ListenError> for Failure {
    fn from(error: ListenError) -> Self {
        let kind = match error {
            ListenError::Address(_) | ListenError::Beyond(_) => magician::ErrorKind::InvalidInput,
            _ => magician::ErrorKind::Port,
        };
        Self::new(Kind::Driver(kind), error.to_string())
    }
}

impl From<JobStoreError> for Failure {
    fn from(error: JobStoreError) -> Self {
        let message = error.to_string();
        match error {
            JobStoreError::Unreadable(..) => Self::invalid(message).hint(
                "nothing was changed: move the file away, and the station starts a new one; a file \
                    of a later version needs that version",
            ),
            JobStoreError::Io(..) => Self::invalid(message).hint("`serve` needs permission to read it"),
            _ => Self::new(Kind::Driver(ErrorKind::Port), message)
                .hint("end the other station first, or set XDG_STATE_HOME to a separate folder for this one"),
        }
    }
}

impl From<TlsError> for Failure {
    fn from(error: TlsError) -> Self {
        let hint = match error {
            TlsError::Read(..) => "`serve` needs permission to read both files",
            TlsError::Content(..) => {
                "--tls-cert takes `-----BEGIN CERTIFICATE-----`, --tls-key `-----BEGIN PRIVATE KEY-----`"
            }
            _ => {
                "use a matching pair of key and certificate; the certificate must be valid for servers"
            }
        };
        Self::invalid(error.to_string()).hint(hint)
    }
}

impl From<TokenError> for Failure {
    fn from(error: TokenError) -> Self {
        Self::invalid(error.to_string())
    }
}
