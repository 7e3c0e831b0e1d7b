//! `sim`: serves a virtual arm to other programs.

mod fidelity;
mod log;
pub(crate) mod picture;
mod tui;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use clap::builder::{NonEmptyStringValueParser, PathBufValueParser, TypedValueParser};
use magician::serve::files::{FlashFileError, load_flash, read_text, save_flash};
use magician::serve::{self, Discovery, Handle, ServeError, Server, serve_all};
use magician_job::files::WholeFile;
use magician_motion::ToolBias;
use magician_picture::DrawingOptions;
use magician_sim::{Controller, Flash, Identity, LineTiming, Profile, Scenario, Speed, World};

use crate::context::Context;
use crate::failure::Failure;
use crate::interrupt::Signal;
use crate::output::Text;
use crate::serving::{NO_ENDPOINT_HINT, open_growing, print_ready, pty};

use log::Log;
use tui::{Dashboard, Feed, Subject};

#[cfg(test)]
pub(super) use tui::examples;

/// Open recordings with the paths that the user gave.
type Recordings = Vec<(PathBuf, WholeFile)>;

/// Serve a virtual arm to other programs
#[derive(Args, Debug)]
#[command(after_help = "\
Prints the single line `ready` when every endpoint accepts connections; all other output goes to \
stderr. Ends with Ctrl-C or SIGTERM.

  magician sim --pty ./arm --udp 127.0.0.1
  magician sim --tcp 127.0.0.1:9000 --speed max
  magician sim --udp 0.0.0.0
  magician sim --arms 3 --pty ./arm --tcp 127.0.0.1:9000
  magician sim --pty ./arm --tui

Programs discover an arm by a broadcast to UDP port 48899 and then use port 8899 of the replying \
address. An arm on UDP port 8899 therefore also answers these broadcasts, on the same HOST. If port \
48899 is in use, perhaps by another arm, the arm is served without discovery and a note on stderr \
says so. Broadcasts arrive only if HOST is 0.0.0.0 (all addresses).

--arms N serves N arms with different names, serial numbers and device ids, at PATH.1 to PATH.N and \
on N consecutive ports; port 0 is any free port for each. A trace, recording or flash becomes N \
files, FILE.1 to FILE.N, a picture x.1.svg to x.N.svg. Discovery finds the arm on port 8899.

The serial number is derived from the first path or address that the arm is served at, so that data \
which programs store for the arm (settings to restore, runs to resume) belongs to this arm. A serial \
number in --profile or --flash takes precedence.

--speed scales only the arm's clock. At `max`, motion, WAIT and homing take no time: a queued \
command has finished before the next request is read. While the arm is idle, its clock runs at the \
usual speed, and so do belts and the events of a scenario.

Scenarios: docs/guide/SCENARIOS.md.

A recording uses the arm's clock: one sample per 20 ms at any speed, about 110 MB an hour, 140 MB if \
the arm never rests. It opens in Foxglove and other programs for MCAP. If writing fails, the arm is \
still served and the exit status is 4.

--tui shows the arm from above and from the side, with its queue, pins, alarms, objects and log, on \
the terminal of stderr. Keys press the arm's buttons, guide it by hand, pull the cable, drive inputs \
and raise alarms; `?` lists them, `q` quits.")]
pub(crate) struct Sim {
    /// Serve a new pseudo-terminal with PATH as a symlink to it
    #[arg(long, value_name = "PATH", value_parser = pty())]
    pty: Option<PathBuf>,
    /// Serve UDP; the default port is 8899
    #[arg(long, value_name = "HOST[:PORT]")]
    udp: Option<String>,
    /// Address at which programs discover the arm; `auto` is HOST:48899 if --udp uses port 8899
    #[arg(
        long, value_name = "HOST[:PORT]|auto|off", default_value = "auto", requires = "udp",
        value_parser = NonEmptyStringValueParser::new().map(discovery)
    )]
    discovery: Discovery,
    /// Serve TCP
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// Serve N arms, 1 to 1000: .1 to .N is appended to their paths, and their ports count up
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    arms: Option<u32>,
    /// Speed of the arm's clock as a multiple of real time, or `max`
    #[arg(long, value_name = "X|max", default_value = "1")]
    speed: Speed,
    /// Pace the bytes like a serial line of this baud rate [default: no pacing]
    #[arg(long, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(1..))]
    baud: Option<u32>,
    /// Turnaround in ms, 0 to 60000: delay from the last byte of a request to the first byte of its
    /// reply
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = milliseconds)]
    turnaround: f64,
    /// Write the traffic to a pcapng file
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Record the arm to an MCAP file: pose at 50 Hz, queue, IO, alarms, frames
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Store the arm's flash memory in FILE: name, serial number, Wi-Fi, calibration, program
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// World around the arm: table, objects, conveyor, sensors, inputs, faults. Either a TOML file
    /// or a built-in one: cubes, drawing, pick_and_sort, faults, engraving
    #[arg(long, value_name = "FILE|NAME")]
    scenario: Option<PathBuf>,
    /// Write the lines of pen and laser at the end, to a .svg (true to size) or .png file; needs a
    /// --scenario with a table
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(picture::Picture::at))]
    picture: Option<picture::Picture>,
    /// With --picture: also show the arm's base
    #[arg(long, requires = "picture")]
    whole: bool,
    /// Tool set at power-up: none (no tool was ever set), suction, gripper, pen, laser, or its bias
    /// X,Y,Z in mm [default: the tool of the scenario or the profile, else suction]
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    tool: Option<ToolBias>,
    /// Firmware profile: 3.6.14 (default), 3.7.0, 4.0.3, continuous (without the 20 ms periods of
    /// real arms), or a TOML file; `--profile -` prints the default as a template
    #[arg(long, value_name = "NAME|FILE")]
    profile: Option<PathBuf>,
    /// Refuse requests for which the behaviour of the real arm is only assumed; see
    /// docs/reference/FIDELITY.md
    #[arg(long)]
    strict: bool,
    /// List the facts and assumptions behind the replies at the end
    #[arg(long)]
    fidelity: bool,
    /// Show the arm on the terminal of stderr, with keys to press its buttons, guide it and disturb
    /// it
    #[arg(long)]
    tui: bool,
}

fn milliseconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok();
    value
        .filter(|value| (0.0..=60_000.0).contains(value))
        .ok_or_else(|| "expected milliseconds from 0 to 60000".to_owned())
}

fn discovery(text: String) -> Discovery {
    match text.as_str() {
        "auto" => Discovery::Auto,
        "off" => Discovery::Off,
        _ => Discovery::At(text),
    }
}

impl Sim {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.profile.as_deref() == Some(Path::new("-")) {
            let pattern = Profile::pattern();
            let pattern = pattern.trim_end();
            let text = Text::from(pattern.to_owned());
            return context.show(&text, |out| out.line(pattern));
        }
        if self.udp.is_none() && self.tcp.is_none() && self.pty.is_none() {
            return Err(Failure::usage("no endpoint to serve").hint(NO_ENDPOINT_HINT));
        }
        if context.global.faults.is_some() {
            let hint = "put `magician proxy --faults SPEC` between the arm and its programs";
            return Err(Failure::usage("`sim` serves an arm without --faults").hint(hint));
        }
        if self.picture.is_some() && self.scenario.is_none() {
            let message = "--picture needs a scenario: without one there is no table to draw on";
            let hint = format!("--scenario drawing; built in are {}", built_in_names());
            return Err(Failure::usage(message).hint(hint));
        }
        if self.tui {
            tui::check()?;
        }
        let (mut profile, scenario) = (
            profile_of(self.profile.as_deref())?,
            scenario_of(self.scenario.as_deref())?,
        );
        profile.fidelity.strict |= self.strict;
        if let Some(picture) = &self.picture {
            picture.check(self.arms)?;
        }
        let verbose = (self.tui || !context.global.json).then_some(context.global.verbose);
        let feeds = self.feeds();
        let mut recordings = Vec::new();
        let servers = self.servers(&profile, &scenario, verbose, &feeds, &mut recordings)?;
        let handles: Vec<_> = servers.iter().map(Server::handle).collect();
        let subjects = self.subjects(&profile, &scenario, feeds, &handles);
        let mut dashboard = Dashboard::begin(subjects)?;
        let mut rested_on = String::new();
        let json = context.global.json;
        let outcome = context.run_without_arm(async |_, signals| {
            let mut seen = None;
            let mut drawn = Ok(());
            let end = async {
                seen = Some(tokio::select! {
                    signal = signals.next() => signal,
                    signal = dashboard.ended() => signal,
                });
                if self.fidelity {
                    rested_on = fidelity::report(&handles, self.arms.is_some(), json).await;
                }
                if let Some(picture) = &self.picture {
                    let options = DrawingOptions::default().whole(self.whole);
                    drawn = picture.write(&handles, self.arms.is_some(), &options).await;
                }
            };
            let served = serve_all(servers, end).await;
            // If recording failed, the earlier file is kept.
            if !matches!(served, Err(ServeError::Record(_))) {
                for (path, file) in recordings {
                    file.finish()
                        .map_err(|error| Failure::unwritable(&path, &error))?;
                }
            }
            served.map_err(Failure::from)?;
            drawn?;
            Ok(seen)
        });
        // Restored first, so that the following output appears on the regular screen.
        let finished = dashboard.finish();
        // An unwritable stderr is ignored.
        let _ = io::stderr().lock().write_all(rested_on.as_bytes());
        let signal = outcome?;
        finished?;
        match signal {
            Some(Signal::Interrupt) => Err(Failure::interrupted()),
            _ => Ok(()),
        }
    }

    /// Creates the feeds to the picture, one per arm; none without a picture.
    fn feeds(&self) -> Vec<Feed> {
        let count = if self.tui { self.arms.unwrap_or(1) } else { 0 };
        (0..count).map(|_| Feed::new()).collect()
    }

    /// Returns the subjects of the picture; none without feeds.
    fn subjects(
        &self,
        profile: &Profile,
        scenario: &Scenario,
        feeds: Vec<Feed>,
        handles: &[Handle],
    ) -> Vec<Subject> {
        let arms = (1..).zip(feeds).zip(handles);
        let subject = |((number, feed), handle): ((u32, Feed), &Handle)| {
            let identity = match self.arms {
                Some(_) => profile.identity.numbered(number),
                None => profile.identity.clone(),
            };
            Subject {
                handle: handle.clone(),
                feed,
                title: log::title(&identity, self.speed),
                limits: profile.arm_model().limits,
                table: scenario.table().copied(),
                conveyor: scenario.conveyor().copied(),
            }
        };
        arms.map(subject).collect()
    }

    /// Creates a server per arm, each in its own world. `verbose` is their verbosity, `None` for no
    /// log; `feeds` replace stderr.
    fn servers(
        &self,
        profile: &Profile,
        scenario: &Scenario,
        verbose: Option<u8>,
        feeds: &[Feed],
        recordings: &mut Recordings,
    ) -> Result<Vec<Server>, Failure> {
        let mut feeds = feeds.iter();
        let mut log = |number| {
            let log = Log::new(verbose?, scenario);
            Some(match (feeds.next(), number) {
                (Some(feed), _) => log.pictured(feed.clone()),
                (None, Some(number)) => log.numbered(number),
                (None, None) => log,
            })
        };
        let Some(count) = self.arms else {
            let log = log(None);
            let server = self.server(profile.clone(), scenario, recordings, Path::to_owned)?;
            return Ok(vec![self.reporting(server, &profile.identity, log, true)]);
        };
        let numbered = |number| {
            let mut profile = profile.clone();
            profile.identity = profile.identity.numbered(number);
            let identity = profile.identity.clone();
            let own = |path: &Path| serve::numbered(path, number);
            let server = self.server(profile, scenario, recordings, own)?;
            let server = server.number(number);
            Ok(self.reporting(server, &identity, log(Some(number)), number == count))
        };
        (1..=count).map(numbered).collect()
    }

    /// Creates the server of an arm, whose files are at its `own` paths.
    fn server(
        &self,
        profile: Profile,
        scenario: &Scenario,
        recordings: &mut Recordings,
        own: impl Fn(&Path) -> PathBuf,
    ) -> Result<Server, Failure> {
        let line = LineTiming {
            baud: self.baud,
            turnaround: Duration::from_micros((self.turnaround * 1000.0) as u64),
        };
        let world = match self.scenario {
            Some(_) => World::from_scenario(scenario),
            None => World::default(),
        };
        let flash = self.flash.as_deref().map(&own);
        let controller = match &flash {
            Some(path) => Controller::with_flash(profile.clone(), world, flash_of(&profile, path)?),
            None => Controller::in_world(profile, world),
        };
        let controller = match self.tool {
            Some(tool) => controller.with_tool(tool),
            None => controller,
        };
        let mut server = Server::new(controller)
            .speed(self.speed)
            .line(line)
            .discovery(self.discovery.clone());
        #[cfg(unix)]
        if let Some(path) = &self.pty {
            server = server.pty(path);
        }
        if let Some(address) = &self.udp {
            server = server.udp(address);
        }
        if let Some(address) = &self.tcp {
            server = server.tcp(address);
        }
        if let Some(path) = flash {
            server = server.flash(path);
        }
        if let Some(path) = &self.trace {
            server = server.trace(BufWriter::new(open_growing(&own(path))?));
        }
        if let Some(path) = &self.record {
            let path = own(path);
            let mut file = open_growing(&path)?;
            server = server.record(file.writer());
            recordings.push((path, file));
        }
        Ok(server)
    }

    /// Makes a server log its notices. The `last` one reports that all are ready.
    fn reporting(
        &self,
        server: Server,
        identity: &Identity,
        log: Option<Log>,
        last: bool,
    ) -> Server {
        let title = log::title(identity, self.speed);
        let endpoint_log = log.clone();
        let server = server.on_ready(move |endpoints| {
            if let Some(log) = endpoint_log {
                log.endpoints(&title, endpoints);
            }
            if last {
                print_ready();
            }
        });
        match log {
            Some(mut log) => server.on_notice(move |notice| log.notice(notice)),
            None => server,
        }
    }
}

/// Returns the firmware profile of this name, or of a file; the default without either.
pub(crate) fn profile_of(path: Option<&Path>) -> Result<Profile, Failure> {
    let Some(path) = path else {
        return Ok(Profile::default());
    };
    // A file with the name of a profile can be given as `./NAME`.
    if let Some(profile) = path.to_str().and_then(Profile::named) {
        return Ok(profile);
    }
    let text = read(path)?;
    Profile::from_toml(&text).map_err(|error| {
        Failure::invalid(format!("{}: {error}", path.display()))
            .hint("`magician sim --profile -` prints a complete profile as a template")
    })
}

/// Returns the scenario of a file or a built-in one; empty without either.
pub(crate) fn scenario_of(path: Option<&Path>) -> Result<Scenario, Failure> {
    let Some(path) = path else {
        return Ok(Scenario::default());
    };
    let built_in = path.to_str().filter(|_| !path.exists()).and_then(|name| {
        let mut all = Scenario::BUILT_IN.iter();
        all.find(|(own, _)| *own == name)
    });
    let text = match built_in {
        Some((_, text)) => (*text).to_owned(),
        None => read(path).map_err(|failure| {
            if path.exists() {
                failure
            } else {
                failure.hint(format!("built in are {}", built_in_names()))
            }
        })?,
    };
    Scenario::from_toml(&text)
        .map_err(|error| Failure::invalid(format!("{}: {error}", path.display())))
}

/// Lists the built-in scenarios.
fn built_in_names() -> String {
    Scenario::BUILT_IN.map(|(name, _)| name).join(", ")
}

/// Reads a file of the user.
fn read(path: &Path) -> Result<String, Failure> {
    read_text(path).map_err(|error| Failure::invalid(format!("{}: {error}", path.display())))
}

/// Opens the flash file of an arm, or creates it.
fn flash_of(profile: &Profile, path: &Path) -> Result<Flash, Failure> {
    let wrong = |error: FlashFileError| {
        let failure = Failure::invalid(error.to_string());
        match error {
            FlashFileError::Damaged { .. } => {
                failure.hint("repair it, or move it away: the arm then starts with a new one")
            }
            _ => failure,
        }
    };
    if let Some(flash) = load_flash(path).map_err(wrong)? {
        return Ok(flash);
    }
    let flash = Flash::new(profile);
    save_flash(&flash, path).map_err(wrong)?;
    Ok(flash)
}
