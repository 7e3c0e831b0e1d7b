//! A station that is turned by hand.

use std::collections::hash_map::RandomState;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::hash::{BuildHasher, Hasher};
use std::io::Read;
use std::ops::Bound;
use std::sync::Arc;

use magician::admission::Origin;
use magician::{Arm, Options, Tracer};
use magician_job::beside;
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
use crate::config::{Config, Place};
use crate::files::PageFiles;
use crate::line::Line;
use crate::stores::{Calendar, MemoryJobs, MemoryPresets, MemoryPrograms};
use crate::trace::TraceRing;

/// Kinds of what comes out.
const TEXT: u8 = 0;
const FRAME: u8 = 1;
const LINE: u8 = 2;
const CLOSE: u8 = 3;
const TRACE: u8 = 4;
const FILE: u8 = 5;

/// How often the station is told that its sessions are alive, us. Over a socket the browser answers pings, whatever its page is busy with;
/// here the worker does, until the page says that a session ends.
const ALIVE: f64 = 2e6;
/// Tokio does not tell when its next timer is due, so a turn is asked for so soon, us: while something is going on as often as timers of a
/// page fire, so that a stop that is due is no later than that ..
const BUSY: f64 = 4_000.0;
/// .. and at rest less often.
const IDLE: f64 = 20_000.0;
/// Something is going on until so long after the last byte in or out, us.
const GOING_ON: f64 = 200_000.0;
/// Close codes of WebSockets: no text, and no room for another session.
const NO_TEXT: u16 = 1007;
const FULL: u16 = 1013;

/// A station with its arms and their clock: the whole of the module, safe and for any system. See the crate's page for what each
/// call means.
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
    /// What comes out beside what the sessions have.
    outbox: VecDeque<(u8, u16, Vec<u8>)>,
    /// The session that was asked last for what it has: the next is another one's turn.
    asked: u16,
    alive_at: f64,
    /// When something was handed in or came out last, us.
    active_at: f64,
    out: Vec<u8>,
}

/// A station, and its arms as they are told; or why an arm is not connected.
type Opened = Result<(RunningStation, Library, Vec<Value>), magician::Error>;

/// What the page keeps of a station.
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
    Over,
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
    /// Opens one by its configuration. Its arms are connected by its turns.
    ///
    /// # Errors
    /// What is wrong with the configuration, in a sentence.
    pub fn open(config: &[u8]) -> Result<Self, String> {
        let config = Config::read(config)?;
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
            asked: 0,
            alive_at: 0.0,
            active_at: f64::NEG_INFINITY,
            out: Vec::new(),
        })
    }

    /// Text of a session; none ends it. Session 0 is the station's own: it takes the word `trace`.
    pub fn rpc(&mut self, session: u16, text: &[u8]) {
        if session == 0 && text == b"trace" {
            self.outbox.push_back((TRACE, 0, self.trace.file()));
        } else if session > 0 && !matches!(self.stage, Stage::Over) {
            self.inbox.push_back((session, text.to_vec()));
        }
    }

    /// Bytes of a real arm.
    pub fn line_in(&mut self, bytes: &[u8]) {
        self.active_at = self.clock.now();
        self.line.hear(bytes);
    }

    /// The line to the real arm broke.
    pub fn line_lost(&mut self) {
        self.line.lose();
    }

    /// The line is there again.
    pub fn line_found(&mut self) {
        self.line.find();
    }

    /// What came of a file that was to be read; nothing where that failed.
    pub fn file_in(&mut self, id: u32, answer: &[u8]) {
        self.active_at = self.clock.now();
        self.files.hear(id, answer);
    }

    /// Keeps a program in the library, or a preset: `preset+NAME.toml`.
    ///
    /// # Errors
    /// Why not, in a sentence.
    pub fn program_in(&mut self, name: &[u8], bytes: &[u8]) -> Result<(), String> {
        let Stage::Running(_, Library { programs, presets }) = &self.stage else {
            return Err("the station is not ready".to_owned());
        };
        if let Some(name) = MemoryPresets::named(name) {
            let text = String::from_utf8_lossy(bytes);
            return { presets.save(name, &text) }.map_err(|error| error.to_string());
        }
        let name = std::str::from_utf8(name).ok().and_then(ProgramName::new);
        let name = name.ok_or("that is no name of a program")?;
        let _context = self.runtime.enter();
        // The page is its owner's.
        let upload = programs.upload(&name, Role::Teacher, Some(bytes.len() as u64));
        let kept = upload.and_then(|mut upload| {
            upload.write(bytes)?;
            upload.finish()
        });
        kept.map(drop).map_err(|error| error.to_string())
    }

    /// Shows a program of the library, or a preset.
    pub fn program_out(&mut self, name: &[u8]) -> Option<&[u8]> {
        let Stage::Running(_, Library { programs, presets }) = &self.stage else {
            return None;
        };
        self.out.clear();
        if let Some(name) = MemoryPresets::named(name) {
            self.out = presets.load(name).ok()??.into_bytes();
            return Some(&self.out);
        }
        let name = std::str::from_utf8(name).ok().and_then(ProgramName::new)?;
        let (_, mut program) = programs.open(&name).ok()?;
        program.read_to_end(&mut self.out).ok()?;
        Some(&self.out)
    }

    /// Does what is due at `now`, us; when the next turn is due, on the same clock. `None`: the station is over.
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
            // What has come over the line is read before time says that it is late.
            settle().await;
            clock.pass(now).await;
            stage.go_on(clock, line, trace, files);
        });
        if let Some(told) = self.stage.arrived() {
            self.outbox.push_back((TEXT, 0, told.into_bytes()));
        }
        self.deliver();
        self.runtime.block_on(settle());
        beside::next_turn();
        let now = self.clock.now();
        let opening = matches!(self.stage, Stage::Closed(_) | Stage::Opening(_));
        let busy = opening || now - self.active_at < GOING_ON;
        let next = now + if busy { BUSY } else { IDLE };
        (!matches!(self.stage, Stage::Over)).then_some(next)
    }

    /// Hands the sessions' texts over.
    fn deliver(&mut self) {
        let Stage::Running(station, _) = &self.stage else {
            return;
        };
        // What asks for the time outside of the runtime would be told the system's.
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
                let code = NO_TEXT.to_le_bytes().to_vec();
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
                        let code = FULL.to_le_bytes().to_vec();
                        self.outbox.push_back((CLOSE, session, code));
                        continue;
                    }
                }
            }
            if let Some(client) = self.sessions.get(&session) {
                client.send(&text);
            }
        }
        if now - self.alive_at >= ALIVE {
            self.alive_at = now;
            self.sessions.values().for_each(Client::pong);
        }
    }

    /// What comes out next: kind, session, payload.
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
        // Bytes for the arm do not wait for what is shown.
        if let Some(bytes) = self.line.say() {
            return Some((LINE, 0, bytes));
        }
        if let Some(own) = self.outbox.pop_front() {
            return Some(own);
        }
        if let Some(file) = self.files.say() {
            return Some((FILE, 0, file));
        }
        let _context = self.runtime.enter();
        let later = (Bound::Excluded(self.asked), Bound::Unbounded);
        let sessions = { self.sessions.range(later) }.chain(self.sessions.range(..=self.asked));
        let mut ready = sessions
            .filter_map(|(session, client)| client.try_receive().map(|what| (*session, what)));
        let (session, what) = ready.next()?;
        self.asked = session;
        match what {
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
    /// What it lets go asks for the time.
    fn drop(&mut self) {
        let _context = self.runtime.enter();
        self.sessions.clear();
        self.stage = Stage::Over;
    }
}

impl Stage {
    /// Begins to connect the arms with the first turn, whose instant is known; in the runtime.
    fn go_on(&mut self, clock: &TurnClock, line: &Line, trace: &TraceRing, files: &PageFiles) {
        if !matches!(self, Self::Closed(_)) {
            return;
        }
        let (done, opening) = oneshot::channel();
        let Self::Closed(config) = std::mem::replace(self, Self::Opening(opening)) else {
            return;
        };
        let calendar = Calendar {
            unix: config.unix_zero + clock.now() / 1e6,
            at: Instant::now(),
        };
        let (line, trace, files) = (line.clone(), trace.clone(), files.clone());
        tokio::spawn(async move {
            // Without the page's end there is nothing to tell.
            let _ = done.send(connect(*config, calendar, line, trace, files).await);
        });
    }

    /// What is to be told if the station has become ready, or never will.
    fn arrived(&mut self) -> Option<String> {
        let Self::Opening(opening) = self else {
            return None;
        };
        let told;
        (*self, told) = match opening.try_recv() {
            Err(oneshot::error::TryRecvError::Empty) => return None,
            Ok(Ok((station, library, arms))) => {
                let ready = json!({"ready": true, "arms": arms});
                (Self::Running(station, library), ready)
            }
            Ok(Err(error)) => {
                let message = error.to_string();
                (Self::Over, failure(error.kind().name(), &message))
            }
            Err(oneshot::error::TryRecvError::Closed) => {
                (Self::Over, failure("unexpected", "connecting ended"))
            }
        };
        Some(told.to_string())
    }
}

/// Why a station does not open, or is over.
pub(crate) fn failure(kind: &str, message: &str) -> Value {
    json!({"error": {"kind": kind, "message": message}})
}

async fn connect(
    config: Config,
    calendar: Calendar,
    line: Line,
    trace: TraceRing,
    files: PageFiles,
) -> Opened {
    let mut usual = Options::default();
    // It takes whatever is written.
    usual.trace = Tracer::new(trace).ok();
    let mut entries = Vec::new();
    let mut arms = Vec::new();
    for (name, place) in config.arms {
        let (entry, arm) = match place {
            Place::Here(arm) => {
                let arm = Arm::simulated(arm, usual.clone()).await?;
                (ArmEntry::simulated(name), arm)
            }
            Place::Line => {
                let line = line.clone();
                let opener = move || std::future::ready(line.open());
                // Nothing outside of the browser would stop a jog of the arm's own.
                let options = usual.clone().bounded_jogs(true);
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
    let told = |entry: &ArmEntry| json!({"name": entry.name, "port": entry.port});
    let told = entries.iter().map(told).collect();
    let library = Library {
        programs: MemoryPrograms::new(calendar),
        presets: MemoryPresets::default(),
    };
    let programs = Arc::new(library.programs.clone());
    let presets = Presets::kept_in(Arc::new(library.presets.clone()));
    let reader = FormatReader::by(SetupDefaults::default(), Arc::new(files))
        .with_library(Arc::clone(&programs) as _)
        .with_presets(presets.clone());
    let config = StationConfig {
        unix_zero: calendar.unix + calendar.at.elapsed().as_secs_f64(),
        jobs: Arc::new(MemoryJobs::default()),
        programs,
        presets,
        ..StationConfig::reading_by(entries, config.epoch, Arc::new(reader))
    };
    let station = RunningStation::start(config, arms, Box::new(|_| {}));
    Ok((station, library, told))
}

/// What a session comes back with.
fn secret() -> String {
    let word = || RandomState::new().build_hasher().finish();
    format!("{:016x}{:016x}", word(), word())
}
