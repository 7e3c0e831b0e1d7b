//! `fleet run`: runs one file on several arms, each as a job of its station.
//!
//! Every arm is checked before the first one starts, so that a file that does not fit stops nothing
//! halfway. Jobs then start one after the other and are polled. The stations run them on their own:
//! they continue if this program is killed, while Ctrl-C stops them all.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::sync::Arc;
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use magician::ErrorKind;
use magician_site::carrier::ZenohSite;
use magician_site::{ArmAt, Caller, Site, SiteError, SiteEvent};
use serde_json::{Map, Value, json};
use tokio::task::{JoinError, JoinSet};
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until, timeout};

use super::stop::no_token;
use super::{Known, Run, gather, twins};
use crate::context::Context;
use crate::failure::{Failure, Kind};
use crate::interrupt::Signals;
use crate::output::Output;
use crate::source::Source;

/// Largest file, bytes. A request may have 1 MiB, and base64 adds a third.
const MAX_FILE_SIZE: usize = 700 * 1024;
/// Interval of polling the jobs' states. A choice.
const POLL_INTERVAL: Duration = Duration::from_millis(500);
/// Longest wait for jobs to stop, and for the answer to a poll. A choice.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);
/// Longest wait at the end for stations that have disappeared. A choice.
const GONE_STATION_TIMEOUT: Duration = Duration::from_secs(30);

impl Run {
    pub(super) fn run(
        self,
        context: &mut Context,
        caller: Caller,
        join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
    ) -> Result<(), Failure> {
        if caller.token.is_none() {
            return Err(no_token());
        }
        let params = self.params(context.global.yes)?;
        let json = context.global.json;
        context.run_without_arm(async |out, signals| {
            let site = Arc::new(join().await?);
            let known = gather(&site).await?;
            let arms = self.choose(&known)?;
            let request = JobRequest {
                site,
                caller,
                params,
            };
            tokio::select! {
                checked = request.check(&arms) => checked?,
                _ = signals.next() => return Err(Failure::interrupted()),
            }
            let mut run = FleetJobs::new(request, arms, json);
            let interrupted = tokio::select! {
                ran = run.run_all(self.stagger, self.detach, out) => { ran?; false }
                _ = signals.next() => true,
            };
            if interrupted {
                return Err(run.stop(out, signals).await);
            }
            run.outcome(self.detach)
        })
    }

    /// Returns the parameters of the request, without the arm.
    fn params(&self, yes: bool) -> Result<Map<String, Value>, Failure> {
        let source = Source::open(&self.file)?;
        let format = source.format(self.format)?;
        let bytes = source.bytes();
        if bytes.len() > MAX_FILE_SIZE {
            let message = format!(
                "{} is larger than {} KiB",
                source.name,
                MAX_FILE_SIZE / 1024
            );
            return Err(Failure::invalid(message)
                .hint("save it in the library of each station, and start it there"));
        }
        let mut params = Map::new();
        match std::str::from_utf8(&bytes) {
            Ok(text) => params.insert("text".to_owned(), json!(text)),
            Err(_) => params.insert("data".to_owned(), json!(STANDARD.encode(&bytes))),
        };
        params.insert("format".to_owned(), json!(format.name()));
        let mut setup = self.options.options(self.preset.is_some())?.to_fields();
        if let Some(preset) = &self.preset {
            setup.insert("preset".to_owned(), json!(preset));
        }
        if !setup.is_empty() {
            params.insert("setup".to_owned(), Value::Object(setup));
        }
        for (name, is_on) in [("yes", yes), ("unhomed", self.unhomed)] {
            if is_on {
                params.insert(name.to_owned(), json!(true));
            }
        }
        Ok(params)
    }

    /// Returns the arms to use. Fails if one of them is not free.
    fn choose(&self, known: &Known) -> Result<Vec<ArmAt>, Failure> {
        let refuse = |message| Failure::new(Kind::Driver(ErrorKind::Port), message);
        let twins = twins(known);
        let free = |at: &ArmAt| {
            let state = known
                .get(at)
                .and_then(Option::as_ref)
                .map(|report| &report.state);
            let Some(state) = state.filter(|state| state["link"] == "up") else {
                return Err(format!("{} is not connected to its arm", at.arm));
            };
            match (&state["job"], &state["holder"]["name"]) {
                (Value::String(job), _) => Err(format!("{} is running the job {job}", at.arm)),
                (_, Value::String(holder)) => Err(format!("{} is held by {holder}", at.arm)),
                _ => Ok(state),
            }
        };
        if let Some(wanted) = self.any {
            // Alarms show that an arm is not homed, but nothing proves that it is, so `homed` may
            // be unknown.
            let able = |at: &&ArmAt| {
                !twins.contains(&at.arm)
                    && free(at).is_ok_and(|state| {
                        state["homed"] != false
                            && state["alarms"].as_array().is_some_and(Vec::is_empty)
                    })
            };
            let able: Vec<_> = known.keys().filter(able).cloned().collect();
            let count = able.len() as u64;
            if count < wanted {
                let message = format!(
                    "{wanted} arms requested, but only {count} are free, homed and without alarms"
                );
                return Err(
                    refuse(message).hint("`magician fleet list` shows the state of all arms")
                );
            }
            return Ok(able.into_iter().take(wanted as usize).collect());
        }
        let mut arms: Vec<ArmAt> = Vec::new();
        for name in &self.on {
            let Some(at) = known.keys().find(|at| at.arm == *name) else {
                let message = format!("{name} is not on the site");
                return Err(Failure::new(Kind::Driver(ErrorKind::Timeout), message));
            };
            if twins.contains(name) {
                return Err(refuse(format!("two stations have an arm {name}")));
            }
            free(at).map_err(refuse)?;
            if arms.contains(at) {
                return Err(Failure::usage(format!("{name} is named twice")));
            }
            arms.push(at.clone());
        }
        Ok(arms)
    }
}

/// Site and request.
struct JobRequest {
    site: Arc<ZenohSite>,
    caller: Caller,
    params: Map<String, Value>,
}

/// Reason why something was not done; the kind says whether that is certain.
struct RequestFailure {
    text: String,
    kind: Kind,
}

impl JobRequest {
    /// Sends a request to a station once, without retries.
    async fn send(
        &self,
        at: &ArmAt,
        method: &str,
        params: &Value,
    ) -> Result<Value, RequestFailure> {
        let request = json!({"jsonrpc": "2.0", "id": 1, "method": method, "params": params});
        let answer = self.site.call(at, &self.caller, request.to_string()).await;
        let answer = answer.map_err(|error| RequestFailure {
            text: error.to_string(),
            kind: Kind::Driver(match error {
                // A request without an answer may have been carried out.
                SiteError::NoAnswer => ErrorKind::Uncertain,
                SiteError::Refused(_) => ErrorKind::Unexpected,
                _ => ErrorKind::Timeout,
            }),
        })?;
        let mut answer: Value = answer
            .and_then(|text| serde_json::from_str(&text).ok())
            .unwrap_or_default();
        if let Some(error) = answer.get("error") {
            return Err(RequestFailure {
                text: error["message"].as_str().unwrap_or_default().to_owned(),
                kind: match error["code"].as_i64() {
                    // Refused by the station's check of the program.
                    Some(-32004) => Kind::CheckFailed,
                    _ => Kind::Driver(ErrorKind::Unexpected),
                },
            });
        }
        Ok(answer["result"].take())
    }

    fn with_arm(&self, at: &ArmAt) -> Map<String, Value> {
        let mut params = self.params.clone();
        params.insert("arm".to_owned(), json!(at.arm));
        params
    }

    /// Checks the job on every arm without moving any.
    async fn check(&self, arms: &[ArmAt]) -> Result<(), Failure> {
        let mut wrong = Vec::new();
        let mut kind = Kind::CheckFailed;
        // Sequentially: a check costs CPU time, and several stations may share one machine.
        for at in arms {
            let mut params = self.with_arm(at);
            params.remove("yes");
            params.remove("unhomed");
            match self.send(at, "job.check", &Value::Object(params)).await {
                Ok(report) => {
                    if let Some(why) = refusal(&report) {
                        wrong.push(format!("{}: {why}", at.arm));
                    }
                }
                Err(why) => {
                    kind = why.kind;
                    wrong.push(format!("{}: {}", at.arm, why.text));
                }
            }
        }
        if wrong.is_empty() {
            Ok(())
        } else {
            Err(Failure::new(kind, wrong.join("\n")).hint("nothing was started"))
        }
    }

    /// Starts the job on one arm and returns the job's id.
    async fn start(&self, at: &ArmAt) -> Result<String, RequestFailure> {
        let mut params = self.with_arm(at);
        params.insert("on_lost".to_owned(), json!("continue"));
        let started = self.send(at, "job.start", &Value::Object(params)).await?;
        let job = started["job"].as_str();
        job.map(str::to_owned).ok_or_else(|| RequestFailure {
            text: "the station did not report the job".to_owned(),
            kind: Kind::Driver(ErrorKind::Uncertain),
        })
    }
}

/// Returns why a check refused the job; `None` if it passed.
fn refusal(report: &Value) -> Option<String> {
    if report["ok"] != false {
        return None;
    }
    let first = report["complaints"][0]["message"].as_str();
    Some(first.unwrap_or("refused by the check").to_owned())
}

/// State of the job on one arm.
#[derive(Default)]
struct ArmJob {
    job: Option<String>,
    /// Answer of `job.get`.
    seen: Value,
    why: Option<RequestFailure>,
    is_gone: bool,
}

impl ArmJob {
    fn state(&self) -> &str {
        self.seen["state"].as_str().unwrap_or("waiting")
    }

    fn is_over(&self) -> bool {
        self.why.is_some() || ["done", "stopped", "failed", "interrupted"].contains(&self.state())
    }

    fn line(&self) -> String {
        if let Some(why) = &self.why {
            return why.text.clone();
        }
        let mut line = self.state().to_owned();
        if let (Some(step), Some(steps)) = (self.seen["step"].as_u64(), self.seen["steps"].as_u64())
        {
            line.push_str(&format!(", step {step} of {steps}"));
        }
        if let Some(left) = self.seen["seconds_left"].as_f64() {
            line.push_str(&format!(", {left:.0} s left"));
        }
        if let Some(error) = self.seen["error"]["message"].as_str() {
            line.push_str(&format!(": {error}"));
        }
        if self.is_gone && !self.is_over() {
            line.push_str("; its station cannot be reached, the job continues there");
        }
        line
    }
}

/// Jobs on all arms.
struct FleetJobs {
    request: Arc<JobRequest>,
    parts: BTreeMap<ArmAt, ArmJob>,
    order: Vec<ArmAt>,
    starting: JoinSet<(ArmAt, Result<String, RequestFailure>)>,
    /// Polls in flight.
    polling: JoinSet<(ArmAt, Option<Value>)>,
    json: bool,
    reported: BTreeMap<ArmAt, String>,
    drawn: usize,
}

impl FleetJobs {
    fn new(request: JobRequest, order: Vec<ArmAt>, json: bool) -> Self {
        Self {
            request: Arc::new(request),
            parts: order
                .iter()
                .map(|at| (at.clone(), ArmJob::default()))
                .collect(),
            order,
            starting: JoinSet::new(),
            polling: JoinSet::new(),
            json,
            reported: BTreeMap::new(),
            drawn: 0,
        }
    }

    /// Starts the jobs one after the other and follows them. Dropping the future leaves started
    /// jobs running.
    async fn run_all(
        &mut self,
        stagger: Duration,
        detach: bool,
        out: &mut Output,
    ) -> Result<(), Failure> {
        let mut events = self.request.site.watch();
        let mut waiting: std::collections::VecDeque<_> = self.order.clone().into();
        let mut next = Instant::now();
        let mut gone_since = None;
        let (mut looks, mut due) = (interval(POLL_INTERVAL), false);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            self.report_changes(out)?;
            let started = waiting.is_empty() && self.starting.is_empty();
            let told = self.polling.is_empty();
            // With `detach` one answer about each job is enough.
            if started && (detach && told || self.parts.values().all(ArmJob::is_over)) {
                return Ok(());
            }
            if told && std::mem::take(&mut due) {
                for at in &self.order.clone() {
                    self.poll_state(at);
                }
            }
            // Jobs of absent stations are waited for only for a limited time.
            let left = self.parts.values().filter(|part| !part.is_over());
            let all_gone = started && left.clone().all(|part| part.is_gone);
            gone_since = all_gone.then(|| gone_since.unwrap_or_else(Instant::now));
            tokio::select! {
                () = sleep_until(next), if !waiting.is_empty() => {
                    if let Some(at) = waiting.pop_front() {
                        let request = Arc::clone(&self.request);
                        self.starting.spawn(async move {
                            let started = request.start(&at).await;
                            (at, started)
                        });
                    }
                    // Counts from the actual start, so that a late start does not shorten the next
                    // pause.
                    next = Instant::now() + stagger;
                }
                Some(started) = self.starting.join_next() => {
                    if let Ok((at, started)) = started {
                        self.handle_start(&at, started);
                        self.poll_state(&at);
                    }
                }
                Some(looked) = self.polling.join_next() => self.handle_poll(looked),
                event = events.next() => match event {
                    SiteEvent::Left(at) => {
                        if let Some(part) = self.parts.get_mut(&at) {
                            part.is_gone = true;
                        }
                    }
                    // A station that is back may have finished the job meanwhile.
                    SiteEvent::Arrived(at) => {
                        if self.parts.get(&at).is_some_and(|part| part.is_gone) {
                            self.poll_state(&at);
                        }
                    }
                    SiteEvent::Report(..) | SiteEvent::Missed => {}
                },
                _ = looks.tick() => due = true,
                () = async {
                    match gone_since {
                        Some(since) => sleep_until(since + GONE_STATION_TIMEOUT).await,
                        None => std::future::pending().await,
                    }
                } => return Ok(()),
            }
        }
    }

    fn handle_start(&mut self, at: &ArmAt, started: Result<String, RequestFailure>) {
        if let Some(part) = self.parts.get_mut(at) {
            match started {
                Ok(job) => part.job = Some(job),
                Err(why) => part.why = Some(why),
            }
        }
    }

    /// Stores a job's new state if it is ours.
    fn note_state(&mut self, at: &ArmAt, job: Value) {
        if let Some(part) = self.parts.get_mut(at)
            && part.job.as_deref() == job["job"].as_str()
            && part.job.is_some()
        {
            part.is_gone = false;
            part.seen = job;
        }
    }

    /// Polls a job's state.
    fn poll_state(&mut self, at: &ArmAt) {
        let part = self.parts.get(at).filter(|part| !part.is_over());
        let Some(job) = part.and_then(|part| part.job.clone()) else {
            return;
        };
        let (request, at) = (Arc::clone(&self.request), at.clone());
        self.polling.spawn(async move {
            let of_job = json!({"job": job});
            let asked = request.send(&at, "job.get", &of_job);
            let job = timeout(STOP_TIMEOUT, asked).await.ok().and_then(Result::ok);
            (at, job)
        });
    }

    fn handle_poll(&mut self, looked: Result<(ArmAt, Option<Value>), JoinError>) {
        match looked {
            Ok((at, Some(job))) => self.note_state(&at, job),
            // A station may be present on the bus and still refuse requests from this machine, for
            // example after its certificate was revoked.
            Ok((at, None)) => {
                if let Some(part) = self.parts.get_mut(&at) {
                    part.is_gone = true;
                }
            }
            Err(_) => {}
        }
    }

    fn report_changes(&mut self, out: &mut Output) -> Result<(), Failure> {
        if !self.json && std::io::stdout().is_terminal() {
            if self.drawn > 0 {
                write!(out, "\x1b[{}A", self.drawn)?;
            }
            for at in &self.order {
                write!(out, "\x1b[K")?;
                out.line(format_args!("{}: {}", at.arm, self.parts[at].line()))?;
            }
            self.drawn = self.order.len();
            return out.flush();
        }
        for at in &self.order {
            let part = &self.parts[at];
            // Without a filter every step of every job would print a line.
            let state = match part.why {
                Some(_) => "not started",
                None => part.state(),
            };
            let mark = if self.json {
                part.seen.to_string() + &part.line()
            } else {
                format!("{state}{}", part.is_gone)
            };
            if self.reported.insert(at.clone(), mark.clone()).as_ref() == Some(&mark) {
                continue;
            }
            if self.json {
                out.event(&json!({
                    "arm": at.arm,
                    "station": at.station.to_string(),
                    "state": state,
                    "job": part.seen,
                    "gone": part.is_gone,
                    "error": part.why.as_ref().map(|why| &why.text),
                }))?
            } else {
                out.line(format_args!("{}: {}", at.arm, part.line()))?
            }
        }
        out.flush()
    }

    /// Stops all jobs of this run, including those whose start has not been answered.
    async fn stop(&mut self, out: &mut Output, signals: &mut Signals) -> Failure {
        let stopping = async {
            let started = async {
                while let Some(started) = self.starting.join_next().await {
                    if let Ok((at, started)) = started {
                        self.handle_start(&at, started);
                    }
                }
            };
            // A start without an answer may still take effect, and its job is not known here.
            let in_doubt = timeout(STOP_TIMEOUT, started).await.is_err();
            let mut stops = JoinSet::new();
            for (at, part) in self.parts.iter().filter(|(_, part)| !part.is_over()) {
                let Some(job) = part.job.clone() else {
                    continue;
                };
                let (request, at) = (Arc::clone(&self.request), at.clone());
                stops.spawn(async move {
                    let of_job = json!({"job": job});
                    let stopped = request.send(&at, "job.stop", &of_job);
                    let stopped = timeout(STOP_TIMEOUT, stopped).await;
                    (at, stopped.is_ok_and(|stopped| stopped.is_ok()))
                });
            }
            let mut unstopped = Vec::new();
            while let Some(Ok((at, stopped))) = stops.join_next().await {
                if stopped {
                    self.poll_state(&at);
                } else {
                    unstopped.push(at.arm);
                }
            }
            while let Some(looked) = self.polling.join_next().await {
                self.handle_poll(looked);
            }
            (in_doubt, unstopped)
        };
        let ended = tokio::select! {
            ended = stopping => ended,
            _ = signals.next() => return Failure::interrupted(),
        };
        if let Err(failure) = self.report_changes(out) {
            return failure;
        }
        match ended {
            (false, unstopped) if unstopped.is_empty() => Failure::new(
                Kind::Interrupted,
                "interrupted; the jobs started by this command are stopped",
            ),
            (_, unstopped) => {
                let names = unstopped.join(", ");
                let message = if names.is_empty() {
                    "interrupted; a job that was being started may be running".to_owned()
                } else {
                    format!("interrupted; may not have stopped: {names}")
                };
                Failure::new(Kind::Interrupted, message).hint(
                    "`magician fleet list` shows running jobs, `magician fleet stop` stops arms",
                )
            }
        }
    }

    fn outcome(&self, detach: bool) -> Result<(), Failure> {
        let mut failed = Vec::new();
        let mut kind = Kind::Driver(ErrorKind::Unexpected);
        for at in &self.order {
            let part = &self.parts[at];
            match &part.why {
                Some(why) => {
                    kind = why.kind;
                    failed.push(format!("{}: {}", at.arm, why.text));
                }
                None if detach || part.state() == "done" => {}
                None => {
                    if part.is_gone {
                        kind = Kind::Driver(ErrorKind::Timeout);
                    }
                    failed.push(format!("{}: {}", at.arm, part.line()));
                }
            }
        }
        if failed.is_empty() {
            Ok(())
        } else {
            Err(Failure::new(kind, failed.join("\n")))
        }
    }
}
