//! `replay`: replays a recorded session on a virtual arm and compares the answers, or explains the
//! session.

mod reporter;
mod session;

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use magician_job::files::WholeFile;
use magician_record::law::{LawReport, LogError, Samples};
use magician_record::mcap::{FramesError, is_recording, trace_of};
use magician_record::replay::{Replay as Session, ReplayError, ReplayWriter, Tolerances};
use magician_record::trace::TraceError;
use magician_sim::{Controller, Speed, World};

use super::{decode, law, sim};
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::options::number;
use reporter::ReplayReporter;
use session::{Pace, attend};

/// Writer for the new session.
type SessionWriter = ReplayWriter<Box<dyn Write + Send>>;

/// Largest trace that is read, bytes. An hour of polling has 150 MB, so a larger file is probably
/// no trace.
const MAX_TRACE_SIZE: u64 = 1 << 30;

/// Replay a recorded session on a virtual arm and compare the replies
#[derive(Args, Debug)]
#[command(after_help = "\
A TRACE is a file that `magician sim`, `magician proxy` or any other verb wrote with --trace \
(pcapng, link type USER0), or a recording with frames: the .mcap of `magician sim --record` or of a \
station.

  magician replay session.pcapng
  magician replay session.pcapng --scenario cell.toml --ignore GetPose.joint_angle --json
  magician replay session.pcapng --to decode --speed 1
  magician replay day.csv --law

The virtual arm starts in its state after power-up, at the first pose of the trace if that was read \
before anything was set. It follows the trace's clock, without waiting unless --speed is given. It \
computes in periods of 20 ms whose start no trace shows: the replay tries every millisecond and uses \
the best. A pose of the previous or next period counts as equal if it was requested within 5 ms of \
its end, otherwise as a difference; both are counted. Queue indices are compared relative to the \
first, the arm's clock by the time between two readings (--time-tolerance). Read-only floats, such \
as a pose, may differ by --tolerance; everything else must be equal bit for bit. --ignore skips a \
command (GetPose), a field of one (GetPose.x) or every field of a name (queued_cmd_index). A reply \
later than 3 s counts as missing.

A session that was not recorded from its start differs by the settings made before. A trace is never \
sent to a real arm: it would repeat another arm's moves from an unknown position.

--law prints the deviation of the poses from the law of motion (docs/reference/MODEL.md, section 7): \
period, accelerations and ratio, and the best-fitting profile of a virtual arm. A log with commands \
(a trace, an .mcap with frames) is replayed on each profile; from readings alone (.csv, .jsonl, \
.mcap of `magician record`) only motions from rest to rest along a straight line or in the joints \
are evaluated. Timestamps come from the computer's clock and jitter: a pose may be up to 5 ms early \
or late, a command half a period; only the deviation beyond that counts. At least 10 poses a second \
are needed; 23 show more than 20 or 25, because they are not at whole periods. Quantities that the \
log does not show are listed.

Exit status 10 if a reply differs (with --to decode: if a frame cannot be decoded).")]
pub(crate) struct Replay {
    /// Trace file; with --law also a .csv, .jsonl or .mcap file of readings
    #[arg(value_name = "TRACE")]
    session: PathBuf,
    /// Print only the deviation of the poses from the law of motion
    #[arg(long, conflicts_with_all = ["to", "speed", "clock", "ignore", "tolerance", "time_tolerance", "scenario", "save"])]
    law: bool,
    /// Target of the replay
    #[arg(long, value_name = "WHERE", default_value = "sim")]
    to: Destination,
    /// Replay only this link, by name or number [default: the link to the arm in a trace of
    /// `magician proxy`; in other traces all links, sent to the one arm]
    #[arg(long, value_name = "NAME")]
    link: Option<String>,
    /// Playback speed: trace seconds per second, or `max`
    #[arg(long, value_name = "X|max", default_value = "max")]
    speed: Speed,
    /// Speed of the recorded arm (its --speed): arm seconds per trace second, or `max`
    #[arg(long, value_name = "X|max", default_value = "1")]
    clock: Speed,
    /// Ignore a COMMAND, COMMAND.FIELD or FIELD (repeatable)
    #[arg(long, value_name = "NAME")]
    ignore: Vec<String>,
    /// Tolerance of measured values, in the unit of each
    #[arg(long, value_name = "X", default_value_t = Tolerances::default().measured, value_parser = tolerance)]
    tolerance: f32,
    /// Tolerance of the arm's clock between two readings, in ms
    #[arg(long, value_name = "MS", default_value_t = Tolerances::default().time_ms)]
    time_tolerance: u32,
    /// World around the arm, a TOML file
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Firmware profile: a name (3.6.14, 3.7.0, 4.0.3, continuous) or a file in TOML
    #[arg(long, value_name = "NAME|FILE")]
    profile: Option<PathBuf>,
    /// Write the new session to a pcapng file
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Destination {
    /// Virtual arm
    Sim,
    /// Decoder
    Decode,
}

fn tolerance(text: &str) -> Result<f32, String> {
    let value = number::<f32>(text)?;
    let usable = value.is_finite() && value >= 0.0;
    usable
        .then_some(value)
        .ok_or_else(|| "expected 0 or more".to_owned())
}

impl Replay {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let bytes = read(&self.session)?;
        if self.law {
            let report = self.law(&bytes)?;
            return context.show(&report, |out| law::show(&report, out));
        }
        let bytes = if is_recording(&bytes) {
            let wrong = |error| Failure::invalid(format!("{}: {error}", self.session.display()));
            trace_of(&bytes).map_err(wrong)?
        } else {
            bytes
        };
        let session = self.session(&bytes)?;
        match self.to {
            Destination::Sim => self.simulate(&session, context),
            Destination::Decode => self.explain(&session, context),
        }
    }

    /// Computes the residue of the trace, or of a file of readings.
    fn law(&self, bytes: &[u8]) -> Result<LawReport, Failure> {
        let more = match &self.profile {
            Some(path) => {
                let profile = sim::profile_of(Some(path.as_path()))?;
                Some((path.display().to_string(), profile))
            }
            None => None,
        };
        let wrong = |error: &dyn std::fmt::Display| {
            Failure::invalid(format!("{}: {error}", self.session.display()))
        };
        let frames = if is_recording(bytes) {
            match trace_of(bytes) {
                Ok(trace) => Some(trace),
                Err(FramesError::Empty) => None,
                Err(error) => return Err(wrong(&error)),
            }
        } else {
            None
        };
        match Session::new(frames.as_deref().unwrap_or(bytes)) {
            Err(ReplayError::Trace(TraceError::NotATrace)) => {
                let log = Samples::read(bytes).map_err(|error| wrong(&error))?;
                Ok(LawReport::of_samples(&log, more))
            }
            Err(ReplayError::Empty) => Err(wrong(&LogError::Empty)),
            Err(error) => Err(wrong(&error)),
            Ok(session) => {
                let link = self.link.clone().or_else(|| session.line_of_arm());
                let session = match link {
                    Some(link) => session.only_link(&link).map_err(|error| wrong(&error))?,
                    None => session,
                };
                Ok(LawReport::of_session(&session, more))
            }
        }
    }

    fn session<'a>(&self, bytes: &'a [u8]) -> Result<Session<'a>, Failure> {
        let wrong = |error| Failure::invalid(format!("{}: {error}", self.session.display()));
        let mut session = Session::new(bytes).map_err(wrong)?;
        let own = || {
            session
                .line_of_arm()
                .filter(|_| self.to == Destination::Sim)
        };
        if let Some(link) = self.link.clone().or_else(own) {
            session = session.only_link(&link).map_err(wrong)?;
        }
        for name in &self.ignore {
            let wrong = |error| Failure::usage(format!("--ignore: {error}"));
            session = session.ignoring(name).map_err(wrong)?;
        }
        let tolerances = Tolerances {
            measured: self.tolerance,
            time_ms: self.time_tolerance,
        };
        Ok(session.tolerances(tolerances).clock(self.clock))
    }

    fn simulate(&self, session: &Session<'_>, context: &mut Context) -> Result<(), Failure> {
        let profile = sim::profile_of(self.profile.as_deref())?;
        let scenario = sim::scenario_of(self.scenario.as_deref())?;
        let world = match self.scenario {
            Some(_) => World::from_scenario(&scenario),
            None => World::default(),
        };
        let mut arm = Controller::in_world(session.beginning(profile), world);
        let session = &session.clone().fitted(&arm);
        let (mut file, mut saved) = self.save(session)?.unzip();
        let quiet = context.global.json;
        let what = format!("replaying {} packets", session.packets().len());
        context.run_without_arm(async |out, signals| {
            let mut teller = ReplayReporter::new(out, quiet);
            let mut play = session.play(&mut arm);
            let mut pace = Pace::new(self.speed, session);
            let work = async {
                loop {
                    if let Some(packet) = session.packets().get(play.done()) {
                        // In real time differences are shown as they occur.
                        if pace.is_slow() {
                            teller.flush()?;
                        }
                        pace.wait(packet.time).await;
                    }
                    let Some(moment) = play.step() else {
                        return Ok(());
                    };
                    if let (Some(saved), Some(path)) = (&mut saved, &self.save) {
                        let written = saved.write(&moment);
                        written.map_err(|error| Failure::unwritable(path, &error))?;
                    }
                    for difference in &moment.differences {
                        teller.difference(difference)?;
                    }
                }
            };
            attend(signals, quiet, &what, work).await?;
            drop(saved);
            if let (Some(file), Some(path)) = (file.take(), &self.save) {
                let unwritable = |error| Failure::unwritable(path, &error);
                file.finish().map_err(unwritable)?;
            }
            teller.end(&play.finish())
        })
    }

    fn save(&self, session: &Session<'_>) -> Result<Option<(WholeFile, SessionWriter)>, Failure> {
        let Some(path) = &self.save else {
            return Ok(None);
        };
        let unwritable = |error| Failure::unwritable(path, &error);
        let mut file = WholeFile::create(path).map_err(unwritable)?;
        let out = Box::new(BufWriter::new(file.writer()));
        let saved = SessionWriter::new(out, session).map_err(unwritable)?;
        Ok(Some((file, saved)))
    }

    fn explain(&self, session: &Session<'_>, context: &mut Context) -> Result<(), Failure> {
        let about = ["--scenario", "--profile", "--save"];
        let given = [&self.scenario, &self.profile, &self.save];
        if let Some((option, _)) = about.iter().zip(given).find(|(_, given)| given.is_some()) {
            return Err(Failure::usage(format!("{option} needs --to sim")));
        }
        let quiet = context.global.json;
        context.run_without_arm(async |out, signals| {
            let mut packets = decode::Packets::new(out, quiet);
            let mut pace = Pace::new(self.speed, session);
            let work = async {
                for packet in session.packets() {
                    if pace.is_slow() {
                        packets.flush()?;
                    }
                    pace.wait(packet.time).await;
                    packets.packet(packet)?;
                }
                Ok(())
            };
            // No progress bar: the explained packets show the progress.
            attend(signals, true, "", work).await?;
            packets.finish()
        })
    }
}

/// Computes the residue of a file of readings against the law of motion.
pub(super) fn law_of_readings(path: &Path) -> Result<LawReport, Failure> {
    let wrong = |error| Failure::invalid(format!("{}: {error}", path.display()));
    let log = Samples::read(&read(path)?).map_err(wrong)?;
    Ok(LawReport::of_samples(&log, None))
}

/// Reads the whole trace, since its blocks refer to each other.
fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let name = path.display();
    let unreadable = |error: io::Error| Failure::invalid(format!("{name} cannot be read: {error}"));
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().is_ok_and(|metadata| metadata.is_dir()) {
        return Err(Failure::invalid(format!("{name} is a directory")));
    }
    let mut bytes = Vec::new();
    (file.take(MAX_TRACE_SIZE + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_TRACE_SIZE {
        let failure = Failure::invalid(format!("{name} is larger than 1 GB"));
        return Err(failure.hint("cut it: `editcap -c 1000000 FILE PART.pcapng`"));
    }
    Ok(bytes)
}

/// Failure of a replay with differences.
fn failed(message: String) -> Failure {
    Failure::new(Kind::CheckFailed, message)
}
