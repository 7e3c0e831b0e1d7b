//! The classroom: the site with its hub, the time since the lesson began, and notes on the lesson.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::VirtualArm;
use magician::sim::Scenario;
use magician_site::StationId;
use magician_station::http::JobFolder;
use serde_json::{Value, json};
use tokio::time::Instant;

use crate::bench::{TestHub, TestSite};
use crate::class;
use crate::drawing::Strokes;

const WORLD: &str = "tool = { kind = \"pen\" }\ntable = { height = -60 }\n";

/// A started job.
#[derive(Clone)]
pub(crate) struct Started {
    pub(crate) station: u64,
    pub(crate) arm: String,
    pub(crate) job: String,
    /// `None` for a job of the teacher.
    pub(crate) pupil: Option<&'static str>,
    pub(crate) strokes: Strokes,
    pub(crate) interrupted: bool,
}

/// Time span in which a page had the turn at an arm.
pub(crate) struct Span {
    pub(crate) arm: String,
    pub(crate) person: &'static str,
    pub(crate) from: Duration,
    pub(crate) until: Duration,
}

#[derive(Default)]
pub(crate) struct Notes {
    log: Vec<(Duration, String, String)>,
    pub(crate) jobs: Vec<Started>,
    pub(crate) spans: Vec<Span>,
    pub(crate) turns: BTreeMap<&'static str, usize>,
    pub(crate) reloads: usize,
}

pub(crate) struct Room {
    pub(crate) site: Arc<TestSite>,
    pub(crate) bench: TestHub,
    pub(crate) notes: Mutex<Notes>,
    pub(crate) frozen: AtomicBool,
    /// True after the first freeze, which ends a drawing in the middle of a long line.
    pub(crate) was_frozen: AtomicBool,
    begun: Instant,
    _state: tempfile::TempDir,
}

impl Room {
    pub(crate) async fn open() -> Arc<Self> {
        let site = Arc::new(TestSite::default());
        let state = tempfile::tempdir().unwrap();
        let world = Scenario::from_toml(WORLD).unwrap();
        for (at, arms) in (1..).zip(class::STATIONS) {
            let names: Vec<_> = arms.iter().map(|arm| (*arm).to_owned()).collect();
            site.start_in(StationId(at), &names, &world, |config| {
                config.unix_zero = class::LESSON_START;
                let folder = state.path().join(at.to_string());
                let serials = vec![String::new(); config.arms.len()];
                let jobs = JobFolder::open(&folder, &config.arms, &serials).unwrap();
                config.jobs = Arc::new(jobs.with_runs(folder.join("runs")));
            })
            .await;
        }
        let bench = TestHub::over(Arc::clone(&site), false).await;
        let mut hub = bench.join("Ms Lee").await;
        hub.ok("class.set", json!({"text": class::file()})).await;
        hub.ok("schedule.set", json!({"text": class::schedule()}))
            .await;
        Arc::new(Self {
            site,
            bench,
            notes: Mutex::default(),
            frozen: AtomicBool::new(false),
            was_frozen: AtomicBool::new(false),
            begun: Instant::now(),
            _state: state,
        })
    }

    /// Time since the lesson began.
    pub(crate) fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    pub(crate) fn log_event(&self, person: &str, event: impl Into<String>) {
        let mut notes = self.notes.lock().unwrap();
        let event = event.into();
        notes.log.push((self.now(), person.to_owned(), event));
    }

    pub(crate) fn is_frozen(&self) -> bool {
        self.frozen.load(Ordering::SeqCst)
    }

    /// Virtual arm of this name.
    pub(crate) fn cell(&self, arm: &str) -> VirtualArm {
        let station = self.site.station(class::station_of(arm));
        let at = station.arms.iter().position(|known| known == arm).unwrap();
        station.cells[at].clone()
    }

    /// Reply of a station to a teacher outside of all sessions.
    pub(crate) async fn ask(&self, station: u64, method: &str, params: Value) -> Value {
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let running = self.site.station(station).running.clone();
        let request = request.to_string();
        let answer = running.call(crate::bench::peer(), &request).await;
        let mut answer: Value = serde_json::from_str(&answer.unwrap()).unwrap();
        assert!(answer["error"].is_null(), "{method}: {answer}");
        answer["result"].take()
    }

    /// Log in its stored form: minute, second, person and event.
    pub(crate) fn log(&self) -> String {
        let mut lines = self.notes.lock().unwrap().log.clone();
        lines.sort_by(|a, b| (a.0.as_millis(), &a.1).cmp(&(b.0.as_millis(), &b.1)));
        let mut out = String::new();
        for (time, person, event) in lines {
            let seconds = time.as_secs();
            let (minute, second) = (seconds / 60, seconds % 60);
            writeln!(out, "{minute:02}:{second:02}  {person:<9} {event}").unwrap();
        }
        out
    }
}
