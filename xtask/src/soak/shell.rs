//! R5, and R2 once more, for the handle that programs use. tokio's clock is paused: it advances
//! only when all tasks wait.

use std::collections::HashMap;
use std::error::Error;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use magician::commands::{HomeParams, Pose, PtpCommonParams, QueuedCmdLeftSpace, WaitCmd};
use magician::faults::Dice;
use magician::pair::Digest;
use magician::sim::{ArmInstant, Controller, LinkId, Profile};
use magician::{Arm, ErrorKind, Event, Link, Options};
use magician_protocol::{Deframer, FrameBuf, QueuedCmdIndex};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::{Instant, sleep, sleep_until, timeout};

use super::{Scope, SoakResult};
use crate::bench::figure::Figure;

const LINK: LinkId = LinkId(0);
const MS: Duration = Duration::from_millis(1);

/// Current state of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum LineFault {
    #[default]
    Fine,
    /// The arm receives and does not answer.
    Mute,
    /// The device accepts no bytes from the host.
    Dead,
    /// Replies are held back until the line is fine again.
    Stalled,
    /// Every reply misses its last byte.
    Torn,
    /// Half of the requests and replies are lost.
    Lossy,
    /// The plug is out.
    Unplugged,
}

struct TestArm {
    arm: Controller,
    booted: Instant,
    line_fault: LineFault,
    /// Number of times the plug was pulled; a line opened earlier is dead.
    pulls: u64,
    dice: Dice,
    digest: Digest,
    begun: Instant,
    /// Accepted commands: parameters and count.
    accepted: HashMap<Vec<u8>, u32>,
}

#[derive(Clone)]
struct Shared(Arc<Mutex<TestArm>>);

impl Shared {
    fn new(seed: u64) -> Self {
        Self(Arc::new(Mutex::new(TestArm {
            arm: Controller::new(Profile::default()),
            booted: Instant::now(),
            line_fault: LineFault::Fine,
            pulls: 0,
            dice: Dice::new(seed),
            digest: Digest::default(),
            begun: Instant::now(),
            accepted: HashMap::new(),
        })))
    }

    fn with<R>(&self, act: impl FnOnce(&mut TestArm) -> R) -> R {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn set(&self, line_fault: LineFault) {
        self.with(|arm_under_test| {
            arm_under_test.pulls += u64::from(line_fault == LineFault::Unplugged);
            arm_under_test.line_fault = line_fault;
        });
    }

    fn line_fault(&self) -> LineFault {
        self.with(|arm_under_test| arm_under_test.line_fault)
    }

    /// Opens the port, with a task that carries the bytes.
    fn open(&self) -> io::Result<DuplexStream> {
        if self.line_fault() == LineFault::Unplugged {
            return Err(io::ErrorKind::NotFound.into());
        }
        let (host, arm) = tokio::io::duplex(256);
        tokio::spawn(carry_bytes(self.clone(), arm));
        Ok(host)
    }
}

impl TestArm {
    fn advance_to_now(&mut self) {
        let now = ArmInstant::ZERO + self.booted.elapsed();
        self.arm.advance(now);
        while self.arm.poll_event().is_some() {}
    }

    fn reset(&mut self) {
        self.arm = Controller::new(Profile::default());
        self.booted = Instant::now();
    }

    fn answer(&mut self, request: &FrameBuf) -> Vec<u8> {
        self.advance_to_now();
        let lossy = self.line_fault == LineFault::Lossy;
        if lossy && self.dice.chance(0.5) {
            return Vec::new();
        }
        let mut reply_bytes = Vec::new();
        for reply in self.arm.exchange(LINK, request.bytes()) {
            let view = request.frame();
            if view.ctrl().queued() && reply.frame().read::<QueuedCmdIndex>().is_ok() {
                *self.accepted.entry(view.params().to_vec()).or_default() += 1;
            }
            reply_bytes.extend_from_slice(reply.bytes());
        }
        match self.line_fault {
            LineFault::Mute => reply_bytes.clear(),
            LineFault::Torn => drop(reply_bytes.pop()),
            LineFault::Lossy if self.dice.chance(0.5) => reply_bytes.clear(),
            _ => {}
        }
        reply_bytes
    }
}

/// Carries bytes between a host's end and the arm until the plug is pulled.
async fn carry_bytes(arm_under_test: Shared, mut line: DuplexStream) {
    let pulls_at_opening = arm_under_test.with(|arm_under_test| arm_under_test.pulls);
    let mut deframer = Deframer::new();
    let mut pending_replies = Vec::new();
    let mut bytes = [0; 256];
    loop {
        if arm_under_test.with(|arm_under_test| arm_under_test.pulls) != pulls_at_opening {
            return;
        }
        if !pending_replies.is_empty() && arm_under_test.line_fault() != LineFault::Stalled {
            if line.write_all(&pending_replies).await.is_err() {
                return;
            }
            pending_replies.clear();
        }
        if arm_under_test.line_fault() == LineFault::Dead {
            // The clock is paused, so polling costs no wall time.
            sleep(5 * MS).await;
            continue;
        }
        let Ok(read) = timeout(2 * MS, line.read(&mut bytes)).await else {
            continue;
        };
        let Ok(count @ 1..) = read else { return };
        sleep(2 * MS).await;
        let mut input = &bytes[..count];
        arm_under_test.with(|arm_under_test| {
            let now = u64::try_from(arm_under_test.begun.elapsed().as_micros()).unwrap_or(u64::MAX);
            arm_under_test.digest.add(now, input);
        });
        while let Some(event) = deframer.next(&mut input) {
            if let magician_protocol::Event::Frame { frame, .. } = event {
                let reply_bytes = arm_under_test
                    .with(|arm_under_test| arm_under_test.answer(&FrameBuf::from(frame)));
                pending_replies.extend(reply_bytes);
            }
        }
    }
}

fn paused_runtime() -> io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .start_paused(true)
        .build()
}

/// Results of the calls.
#[derive(Default)]
struct Calls {
    done: u64,
    failed: u64,
    slowest: Duration,
    kinds: HashMap<&'static str, u64>,
    /// Number of checks that the handle is connected, each after 2 s without faults.
    checks: u64,
    /// Number of checks in which the handle was still disconnected.
    disconnected: u64,
}

impl Calls {
    fn note(&mut self, took: Duration, error: Option<magician::Error>) {
        self.slowest = self.slowest.max(took);
        let Some(error) = error else {
            self.done += 1;
            return;
        };
        self.failed += 1;
        let kind = match error.kind() {
            ErrorKind::Timeout => "timeout",
            ErrorKind::Port => "port",
            ErrorKind::Uncertain => "uncertain",
            ErrorKind::QueueFull => "queue full",
            _ => "other",
        };
        *self.kinds.entry(kind).or_default() += 1;
    }
}

async fn call(arm: &Arm, which: u64, number: u32) -> Result<(), magician::Error> {
    match which {
        0 => arm.get::<Pose>().await.map(drop),
        1 => arm.get::<HomeParams>().await.map(drop),
        2 => arm.queue().current_index().await.map(drop),
        3 => arm.get::<QueuedCmdLeftSpace>().await.map(drop),
        4 => arm.alarms().await.map(drop),
        5 => arm.clear_alarms().await,
        6 => arm.enqueue(&WaitCmd { timeout: number }).await.map(drop),
        7 => arm.set(&RATIOS).await,
        8 => arm.queue().start().await,
        _ => arm.enqueue(&RATIOS).await.map(drop),
    }
}

const RATIOS: PtpCommonParams = PtpCommonParams {
    velocity_ratio: 50.0,
    acceleration_ratio: 50.0,
};
/// Timeout of a call. Shorter than the driver's default, so that calls expire during most faults.
const CALL_TIMEOUT: Duration = Duration::from_millis(300);

async fn run_calls(scope: Scope) -> Result<(Calls, Digest), Box<dyn Error>> {
    let arm_under_test = Shared::new(scope.seed);
    let open = arm_under_test.clone();
    let options = Options::default().timeout(CALL_TIMEOUT).allow_laser(true);
    let arm = Arm::over_with(move || std::future::ready(open.open()), options).await?;
    let calls = Arc::new(Mutex::new(Calls::default()));
    let mut dice = Dice::new(scope.seed ^ 0xD1CE);
    // Several concurrent callers, while the line changes at random.
    let callers: Vec<_> = (0..3)
        .map(|caller| {
            let (arm, calls) = (arm.clone(), calls.clone());
            let mut dice = Dice::new(dice.number());
            let count = scope.cases / 3;
            tokio::spawn(async move {
                for number in 0..count {
                    let begun = Instant::now();
                    let outcome = call(&arm, dice.below(10), (3 * number + caller) as u32).await;
                    calls
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .note(begun.elapsed(), outcome.err());
                    sleep(MS * dice.below(40) as u32).await;
                }
            })
        })
        .collect();
    let line_faults = [
        LineFault::Fine,
        LineFault::Fine,
        LineFault::Mute,
        LineFault::Dead,
        LineFault::Stalled,
        LineFault::Torn,
        LineFault::Lossy,
        LineFault::Unplugged,
    ];
    let (mut checks, mut disconnected) = (0, 0);
    while !callers.iter().all(tokio::task::JoinHandle::is_finished) {
        if dice.chance(0.02) {
            arm_under_test.set(LineFault::Fine);
            // A line without faults for 2 s must be connected again, whatever happened before.
            sleep(2_000 * MS).await;
            checks += 1;
            disconnected += u64::from(arm.link() != Link::Up);
        }
        arm_under_test.set(line_faults[dice.below(line_faults.len() as u64) as usize]);
        sleep(MS * dice.below(1_500) as u32).await;
        if dice.chance(0.05) {
            arm_under_test.with(TestArm::reset);
        }
    }
    let digest = arm_under_test.with(|arm_under_test| arm_under_test.digest);
    let mut calls = std::mem::take(&mut *calls.lock().unwrap_or_else(PoisonError::into_inner));
    (calls.checks, calls.disconnected) = (checks, disconnected);
    Ok((calls, digest))
}

/// R5: calls on lines that stall, fall silent, break and disappear.
pub(super) fn deadlines(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let (calls, digest) = paused_runtime()?.block_on(run_calls(scope))?;
    let over = calls.slowest.saturating_sub(CALL_TIMEOUT);
    let mut failed = Figure::new("calls that failed", calls.failed as f64, "");
    for kind in ["timeout", "port", "uncertain", "queue full", "other"] {
        failed = failed.with(kind, calls.kinds.get(kind).copied().unwrap_or(0) as f64);
    }
    Ok(SoakResult {
        figures: vec![
            Figure::new("calls that were answered", calls.done as f64, ""),
            failed,
            Figure::new(
                "not back 2 s after the line was",
                calls.disconnected as f64,
                "",
            )
            .with("of looks", calls.checks as f64)
            .at_most(0.0),
            Figure::new(
                "slowest beyond its deadline",
                over.as_secs_f64() * 1e3,
                "ms",
            )
            .at_most(10.0),
        ],
        digest: Some(digest.0),
    })
}

#[derive(Default)]
struct Plugs {
    pulled: u64,
    resets: u64,
    reported_resets: u64,
    slowest: Duration,
    accepted: u64,
    uncertain: u64,
    refused: u64,
    lost: u64,
    duplicated: u64,
    misreported: u64,
}

async fn pull_plugs(scope: Scope) -> Result<(Plugs, Digest), Box<dyn Error>> {
    let arm_under_test = Shared::new(scope.seed);
    let open = arm_under_test.clone();
    let options = Options::default().allow_laser(true);
    let arm = Arm::over_with(move || std::future::ready(open.open()), options).await?;
    // Wait until the driver has identified the arm and read its clock. If the arm was reset within
    // its first second, its clock would not reveal the reset.
    sleep(3_000 * MS).await;
    let mut dice = Dice::new(scope.seed ^ 0xD1CE);
    let mut plugs = Plugs::default();
    let mut number = 0;
    while plugs.pulled < scope.cases {
        let mut events = arm.events();
        let (puller_arm, pull_at) = (
            arm_under_test.clone(),
            Instant::now() + MS * dice.below(60) as u32,
        );
        let resets = dice.chance(0.3);
        let unplugged_time = MS * (50 + dice.below(4_000)) as u32;
        let puller = tokio::spawn(async move {
            sleep_until(pull_at).await;
            puller_arm.set(LineFault::Unplugged);
            sleep(unplugged_time).await;
            if resets {
                puller_arm.with(TestArm::reset);
            }
            puller_arm.set(LineFault::Fine);
            Instant::now()
        });
        // Queue commands until one fails because the plug is out, or until the plug is in again: a
        // command may wait for that.
        while !puller.is_finished() {
            number += 1;
            let command = WaitCmd { timeout: number };
            let outcome = arm.enqueue(&command).await;
            let times_accepted = arm_under_test
                .with(|arm_under_test| arm_under_test.accepted.remove(&number.to_le_bytes()[..]));
            let times_accepted = times_accepted.unwrap_or(0);
            plugs.duplicated += u64::from(times_accepted > 1);
            match outcome.map_err(|error| error.kind()) {
                Ok(_) => {
                    plugs.accepted += 1;
                    plugs.lost += u64::from(times_accepted == 0);
                }
                Err(ErrorKind::Uncertain) => plugs.uncertain += 1,
                Err(ErrorKind::Port) => {
                    plugs.refused += 1;
                    plugs.misreported += u64::from(times_accepted > 0);
                    break;
                }
                Err(ErrorKind::QueueFull) => {
                    plugs.misreported += u64::from(times_accepted > 0);
                    // No command runs, so the queue is cleared to make room.
                    if arm.queue().clear().await.is_err() {
                        break;
                    }
                }
                Err(_) => plugs.misreported += u64::from(times_accepted > 0),
            }
        }
        plugs.pulled += 1;
        plugs.resets += u64::from(resets);
        let back = puller.await?;
        // Fails instead of hanging if the handle does not reconnect.
        timeout(Duration::from_secs(30), arm.reconnected()).await??;
        plugs.slowest = plugs.slowest.max(back.elapsed());
        while let Ok(Some(event)) = timeout(Duration::ZERO, events.next()).await {
            plugs.reported_resets += u64::from(event == Event::LinkFound { reset: true });
        }
        // If the queue index has not changed, only the arm's clock reveals the next reset, so let
        // that clock run for a moment.
        sleep(MS * (1_000 + dice.below(2_000)) as u32).await;
    }
    let digest = arm_under_test.with(|arm_under_test| arm_under_test.digest);
    Ok((plugs, digest))
}

/// R2: pulls and reinserts the plug of a handle that queues commands, with or without a reset of
/// the arm meanwhile.
pub(super) fn plugs(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let (plugs, digest) = paused_runtime()?.block_on(pull_plugs(scope))?;
    let count = |name: &str, value: u64| Figure::new(name, value as f64, "");
    let unreported = plugs.resets.abs_diff(plugs.reported_resets);
    Ok(SoakResult {
        figures: vec![
            count("plugs pulled", plugs.pulled),
            count("arm reset meanwhile", plugs.resets),
            count("of which was not told", unreported).at_most(0.0),
            count("commands accepted", plugs.accepted),
            count("told as uncertain", plugs.uncertain),
            count("refused or lost with the line", plugs.refused),
            count("accepted and not taken", plugs.lost).at_most(0.0),
            count("taken twice", plugs.duplicated).at_most(0.0),
            count("taken though told otherwise", plugs.misreported).at_most(0.0),
            Figure::new("slowest return", plugs.slowest.as_secs_f64(), "s").at_most(2.0),
        ],
        digest: Some(digest.0),
    })
}
