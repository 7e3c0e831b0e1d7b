//! A station driven in turns by a page.

use std::collections::hash_map::RandomState;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::hash::{BuildHasher, Hasher};
use std::io::Read;
use std::ops::Bound;
use std::sync::Arc;

use magician::admission::Origin;
use magician::{Arm, Options, Tracer};
use magician_job::background;
use magician_job::presets::{PresetStore, Presets};
use magician_program::SetupDefaults;
use magician_station::{
    ArmEntry, Client, FormatReader, Grant, Outgoing, Peer, ProgramName, ProgramStore, Role,
    RunningStation, StationConfig,
};
use serde_json::{Value, json};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;
use tokio::time::Instant;

use crate::clock::{TurnClock, settle};
use crate::config::{ArmLocation, Config};
use crate::files::PageFiles;
use crate::line::Line;
use crate::stores::{MemoryJobs, MemoryPresets, MemoryPrograms, UnixClock};
use crate::trace::TraceRing;

/// Kind of output: text of a session.
const TEXT: u8 = 0;
/// Kind of output: binary frame of a session.
const FRAME: u8 = 1;
/// Kind of output: bytes for the line to a real arm.
const LINE: u8 = 2;
/// Kind of output: end of a session, with its close code.
const CLOSE: u8 = 3;
/// Kind of output: trace file.
const TRACE: u8 = 4;
/// Kind of output: file to read.
const FILE: u8 = 5;

/// Interval of keep-alives for the sessions, us. Over a socket the browser answers pings even while
/// its page is busy. Here this module keeps each session alive until the page ends it.
const KEEP_ALIVE_INTERVAL: f64 = 2e6;
/// Delay until the next turn while the station is active, us.
///
/// tokio does not expose its next deadline, so turns are requested periodically, as often as a
/// page's timers fire: a due stop is late by at most this interval.
const ACTIVE_TURN_DELAY: f64 = 4_000.0;
/// Delay until the next turn at rest, us.
const IDLE_TURN_DELAY: f64 = 20_000.0;
/// Time after the last input or output during which the station counts as active, us.
const ACTIVE_TIME: f64 = 200_000.0;
/// Close code of WebSockets (RFC 6455) for a message other than text.
const CLOSE_NOT_TEXT: u16 = 1007;
/// Close code of WebSockets for a session beyond the limit: try again later.
const CLOSE_TOO_MANY_SESSIONS: u16 = 1013;

/// A station with its arms and their clock: the functions of the module in safe Rust, on any
/// platform. The documentation of the crate describes each call.
pub struct PageStation {
    runtime: Runtime,
    clock: TurnClock,
    stage: Stage,
    line: Line,
    trace: TraceRing,
    files: PageFiles,
    role: Role,
    inbox: VecDeque<(u16, Vec<u8>)>,
    sessions: BTreeMap<u16, Client>,
    /// Output besides that of the sessions.
    outbox: VecDeque<(u8, u16, Vec<u8>)>,
    /// Session polled last for output. The next poll starts with another one, so that all get a
    /// turn.
    last_polled: u16,
    last_pong_at: f64,
    /// Time of the last input or output, us.
    active_at: f64,
    out: Vec<u8>,
}

/// A station and the description of its arms, or why an arm is not connected.
type Opened = Result<(RunningStation, Library, Vec<Value>), magician::Error>;

/// Storage of a station in the page.
#[derive(Clone)]
struct Library {
    programs: MemoryPrograms,
    presets: MemoryPresets,
}

enum Stage {
    /// Before the first turn.
    Closed(Box<Config>),
    Opening(oneshot::Receiver<Opened>),
    Running(RunningStation, Library),
    Ended,
}

impl fmt::Debug for PageStation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PageStation")
            .field("clock", &self.clock)
            .field("sessions", &self.sessions.len())
            .finish_non_exhaustive()
    }
}

impl PageStation {
    /// Opens a station by its configuration. Its turns connect the arms.
    ///
    /// # Errors
    /// A sentence about the fault in the configuration.
    pub fn open(config: &[u8]) -> Result<Self, String> {
        let config = Config::read(config)?;
        // Paused, so that only `TurnClock` advances the time.
        let runtime = Builder::new_current_thread()
            .enable_time()
            .start_paused(true)
            .build()
            .map_err(|error| error.to_string())?;
        Ok(Self {
            runtime,
            clock: TurnClock::default(),
            line: Line::default(),
            trace: TraceRing::default(),
            files: PageFiles::default(),
            role: config.role,
            stage: Stage::Closed(Box::new(config)),
            inbox: VecDeque::new(),
            sessions: BTreeMap::new(),
            outbox: VecDeque::new(),
            last_polled: 0,
            last_pong_at: 0.0,
            active_at: f64::NEG_INFINITY,
            out: Vec::new(),
        })
    }

    /// Accepts text of a session; an empty text ends it. Session 0 is the station itself and
    /// accepts the word `trace`.
    pub fn rpc(&mut self, session: u16, text: &[u8]) {
        if session == 0 && text == b"trace" {
            self.outbox.push_back((TRACE, 0, self.trace.file()));
        } else if session > 0 && !matches!(self.stage, Stage::Ended) {
            self.inbox.push_back((session, text.to_vec()));
        }
    }

    /// Accepts bytes from a real arm.
    pub fn line_in(&mut self, bytes: &[u8]) {
        self.active_at = self.clock.now();
        self.line.receive(bytes);
    }

    /// Reports that the line to the real arm broke.
    pub fn line_lost(&mut self) {
        self.line.mark_lost();
    }

    /// Reports that the line is back.
    pub fn line_found(&mut self) {
        self.line.mark_found();
    }

    /// Accepts the result of reading a file, empty if that failed.
    pub fn file_in(&mut self, id: u32, answer: &[u8]) {
        self.active_at = self.clock.now();
        self.files.accept_answer(id, answer);
    }

    /// Stores a program in the library, or a preset as `preset+NAME.toml`.
    ///
    /// # Errors
    /// A sentence about why it was not stored.
    pub fn program_in(&mut self, name: &[u8], bytes: &[u8]) -> Result<(), String> {
        let Stage::Running(_, Library { programs, presets }) = &self.stage else {
            return Err("the station is not ready".to_owned());
        };
        if let Some(name) = MemoryPresets::preset_name(name) {
            let text = String::from_utf8_lossy(bytes);
            return { presets.save(name, &text) }.map_err(|error| error.to_string());
        }
        let name = std::str::from_utf8(name).ok().and_then(ProgramName::new);
        let name = name.ok_or("that is no name of a program")?;
        // The library asks for the time, which outside the runtime would be the system's.
        let _context = self.runtime.enter();
        // The page belongs to its user, who may do everything.
        let upload = programs.upload(&name, Role::Teacher, Some(bytes.len() as u64));
        let stored = upload.and_then(|mut upload| {
            upload.write(bytes)?;
            upload.finish()
        });
        stored.map(drop).map_err(|error| error.to_string())
    }

    /// Returns a program of the library, or a preset.
    pub fn program_out(&mut self, name: &[u8]) -> Option<&[u8]> {
        let Stage::Running(_, Library { programs, presets }) = &self.stage else {
            return None;
        };
        self.out.clear();
        if let Some(name) = MemoryPresets::preset_name(name) {
            self.out = presets.load(name).ok()??.into_bytes();
            return Some(&self.out);
        }
        let name = std::str::from_utf8(name).ok().and_then(ProgramName::new)?;
        let (_, mut program) = programs.open(&name).ok()?;
        program.read_to_end(&mut self.out).ok()?;
        Some(&self.out)
    }

    /// Runs everything due at `now`, us. Returns when the next turn is due on the same clock, or
    /// `None` once the station has ended.
    pub fn turn(&mut self, now: f64) -> Option<f64> {
        let Self {
            runtime,
            clock,
            stage,
            line,
            trace,
            files,
            ..
        } = self;
        runtime.block_on(async {
            // Process received bytes before the clock advances, so that a reply is not counted as
            // late.
            settle().await;
            clock.advance(now).await;
            stage.start_connecting(clock, line, trace, files);
        });
        if let Some(message) = self.stage.connect_result() {
            self.outbox.push_back((TEXT, 0, message.into_bytes()));
        }
        self.deliver();
        self.runtime.block_on(settle());
        background::next_turn();
        let now = self.clock.now();
        let opening = matches!(self.stage, Stage::Closed(_) | Stage::Opening(_));
        let busy = opening || now - self.active_at < ACTIVE_TIME;
        let next = now
            + if busy {
                ACTIVE_TURN_DELAY
            } else {
                IDLE_TURN_DELAY
            };
        (!matches!(self.stage, Stage::Ended)).then_some(next)
    }

    /// Passes the sessions' texts to the station.
    fn deliver(&mut self) {
        let Stage::Running(station, _) = &self.stage else {
            return;
        };
        // Code that asks for the time outside the runtime would get the system's clock instead of
        // the paused one.
        let _context = self.runtime.enter();
        let now = self.clock.now();
        for (session, text) in self.inbox.drain(..) {
            self.active_at = now;
            if text.is_empty() {
                self.sessions.remove(&session);
                continue;
            }
            let Ok(text) = String::from_utf8(text) else {
                self.sessions.remove(&session);
                let code = CLOSE_NOT_TEXT.to_le_bytes().to_vec();
                self.outbox.push_back((CLOSE, session, code));
                continue;
            };
            if !self.sessions.contains_key(&session) {
                let peer = Peer {
                    grant: Some(Grant {
                        role: self.role,
                        token: None,
                    }),
                    origin: Origin::Loopback,
                    address: "page".to_owned(),
                    secret: secret(),
                };
                match station.try_connect(peer) {
                    Some(client) => drop(self.sessions.insert(session, client)),
                    None => {
                        let code = CLOSE_TOO_MANY_SESSIONS.to_le_bytes().to_vec();
                        self.outbox.push_back((CLOSE, session, code));
                        continue;
                    }
                }
            }
            if let Some(client) = self.sessions.get(&session) {
                client.send(&text);
            }
        }
        if now - self.last_pong_at >= KEEP_ALIVE_INTERVAL {
            self.last_pong_at = now;
            self.sessions.values().for_each(Client::pong);
        }
    }

    /// Returns the next output: kind, session, payload.
    pub fn out(&mut self) -> Option<&[u8]> {
        let (kind, session, payload) = self.next_out()?;
        self.active_at = self.clock.now();
        self.out.clear();
        self.out.push(kind);
        self.out.extend(session.to_le_bytes());
        self.out.extend(payload);
        Some(&self.out)
    }

    fn next_out(&mut self) -> Option<(u8, u16, Vec<u8>)> {
        // Bytes for the arm come before anything for display.
        if let Some(bytes) = self.line.take_output() {
            return Some((LINE, 0, bytes));
        }
        if let Some(output) = self.outbox.pop_front() {
            return Some(output);
        }
        if let Some(file) = self.files.next_message() {
            return Some((FILE, 0, file));
        }
        let _context = self.runtime.enter();
        let after_last_polled = (Bound::Excluded(self.last_polled), Bound::Unbounded);
        let sessions = { self.sessions.range(after_last_polled) }
            .chain(self.sessions.range(..=self.last_polled));
        let mut ready = sessions.filter_map(|(session, client)| {
            client.try_receive().map(|outgoing| (*session, outgoing))
        });
        let (session, outgoing) = ready.next()?;
        self.last_polled = session;
        match outgoing {
            Outgoing::Text(text) => Some((TEXT, session, text.into_bytes())),
            Outgoing::Frame(frame) => Some((FRAME, session, frame)),
            Outgoing::Close(code) => {
                self.sessions.remove(&session);
                Some((CLOSE, session, code.0.to_le_bytes().to_vec()))
            }
        }
    }
}

impl Drop for PageStation {
    /// Drops sessions within the runtime, because their destructors ask for the time.
    fn drop(&mut self) {
        let _context = self.runtime.enter();
        self.sessions.clear();
        self.stage = Stage::Ended;
    }
}

impl Stage {
    /// Starts connecting the arms in the first turn, because no time is known before that. Must be
    /// called within the runtime.
    fn start_connecting(
        &mut self,
        clock: &TurnClock,
        line: &Line,
        trace: &TraceRing,
        files: &PageFiles,
    ) {
        if !matches!(self, Self::Closed(_)) {
            return;
        }
        let (done, opening) = oneshot::channel();
        let Self::Closed(config) = std::mem::replace(self, Self::Opening(opening)) else {
            return;
        };
        let unix_clock = UnixClock {
            unix: config.unix_zero + clock.now() / 1e6,
            at: Instant::now(),
        };
        let (line, trace, files) = (line.clone(), trace.clone(), files.clone());
        tokio::spawn(async move {
            // If the page has dropped the station, nothing receives the result.
            let _ = done.send(connect(*config, unix_clock, line, trace, files).await);
        });
    }

    /// Returns the message to send once connecting has succeeded or failed.
    fn connect_result(&mut self) -> Option<String> {
        let Self::Opening(opening) = self else {
            return None;
        };
        let message;
        (*self, message) = match opening.try_recv() {
            Err(oneshot::error::TryRecvError::Empty) => return None,
            Ok(Ok((station, library, arms))) => {
                let ready = json!({"ready": true, "arms": arms});
                (Self::Running(station, library), ready)
            }
            Ok(Err(error)) => {
                let message = error.to_string();
                (Self::Ended, failure(error.kind().name(), &message))
            }
            Err(oneshot::error::TryRecvError::Closed) => {
                (Self::Ended, failure("unexpected", "connecting ended"))
            }
        };
        Some(message.to_string())
    }
}

/// Message that a station cannot be opened, or has ended.
pub(crate) fn failure(kind: &str, message: &str) -> Value {
    json!({"error": {"kind": kind, "message": message}})
}

async fn connect(
    config: Config,
    unix_clock: UnixClock,
    line: Line,
    trace: TraceRing,
    files: PageFiles,
) -> Opened {
    let mut default_options = Options::default();
    // `TraceRing` accepts any write, so this cannot fail.
    default_options.trace = Tracer::new(trace).ok();
    let mut entries = Vec::new();
    let mut arms = Vec::new();
    for (name, location) in config.arms {
        let (entry, arm) = match location {
            ArmLocation::Virtual(arm) => {
                let arm = Arm::simulated(arm, default_options.clone()).await?;
                (ArmEntry::simulated(name), arm)
            }
            ArmLocation::Line => {
                let line = line.clone();
                let opener = move || std::future::ready(line.open());
                // Nothing outside the browser can stop a jog that the arm runs by itself, so use
                // bounded jogs.
                let options = default_options.clone().bounded_jogs(true);
                let arm = Arm::over_with(opener, options).await?;
                let entry = ArmEntry {
                    port: "line".to_owned(),
                    is_virtual: false,
                    ..ArmEntry::simulated(name)
                };
                (entry, arm)
            }
        };
        entries.push(entry);
        arms.push(arm);
    }
    let description = |entry: &ArmEntry| json!({"name": entry.name, "port": entry.port});
    let descriptions = entries.iter().map(description).collect();
    let library = Library {
        programs: MemoryPrograms::new(unix_clock),
        presets: MemoryPresets::default(),
    };
    let programs = Arc::new(library.programs.clone());
    let presets = Presets::with_store(Arc::new(library.presets.clone()));
    let reader = FormatReader::with_preparer(SetupDefaults::default(), Arc::new(files))
        .with_library(Arc::clone(&programs) as _)
        .with_presets(presets.clone());
    let config = StationConfig {
        unix_zero: unix_clock.unix + unix_clock.at.elapsed().as_secs_f64(),
        jobs: Arc::new(MemoryJobs::default()),
        programs,
        presets,
        ..StationConfig::reading_by(entries, config.epoch, Arc::new(reader))
    };
    let station = RunningStation::start(config, arms, Box::new(|_| {}));
    Ok((station, library, descriptions))
}

/// Returns the secret with which a session can be resumed.
fn secret() -> String {
    let word = || RandomState::new().build_hasher().finish();
    format!("{:016x}{:016x}", word(), word())
}
