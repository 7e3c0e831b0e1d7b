//! Virtual arm on a desk: its cable can be pulled and plugged in, it can be reset or replaced by
//! another, and its line may lose frames.

use std::future::{Ready, ready};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use magician::commands::DeviceSn;
use magician::protocol::{FrameBuf, Text};
use magician::sim::{ArmInstant, Controller, ControllerState, Event, LinkId, Profile};
use magician::{Arm, Ctrl, Options, build};
use tokio::io::{AsyncWriteExt, DuplexStream, duplex};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep};

use crate::bench::request;

/// Sends a motion outside the queue, and returns while the arm is moving.
pub(crate) async fn begin_immediate_motion(arm: &Arm) {
    let motion = build::line_to(220.0, 60.0, 20.0, 0.0);
    arm.set_any(&motion).await.unwrap();
    sleep(Duration::from_millis(300)).await;
}

#[derive(Clone)]
pub(crate) struct Desk(Arc<Mutex<Inner>>);

struct Inner {
    controller: Controller,
    booted: Instant,
    plugged: bool,
    /// Ids of requests that are received but not answered.
    swallowed: Vec<u8>,
    /// Received requests, and whether the arm was moving at the time.
    heard: Vec<(FrameBuf, bool)>,
    cable: Option<JoinHandle<()>>,
    watcher: Option<Watcher>,
    prober: Option<Prober>,
    /// Latency of an answer.
    turnaround: Duration,
    /// Lost frames per thousand.
    lost: u64,
    dice: Dice,
    /// Parameters of the accepted queued commands, by index.
    taken: Vec<(u64, Vec<u8>)>,
    /// Indices of the queued commands that have started.
    started: Vec<u64>,
}

/// Random numbers determined by a seed alone.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }
}

/// Observer called every few milliseconds of the arm's clock.
type Watcher = Box<dyn FnMut(&ControllerState) + Send>;

/// Observer called after every request.
type Prober = Box<dyn FnMut(&FrameBuf, &Controller) + Send>;

/// Interval of the watcher's calls.
const WATCHED: Duration = Duration::from_millis(4);

impl Inner {
    /// Brings the arm to the present, observed on the way.
    fn catch_up(&mut self) {
        let now = ArmInstant::ZERO + self.booted.elapsed();
        while let Some(watcher) = &mut self.watcher {
            let at = self.controller.now();
            if at >= now {
                break;
            }
            // An arm at rest needs no observation.
            let still = !self.controller.busy();
            self.controller
                .advance(if still { now } else { now.min(at + WATCHED) });
            watcher(&self.controller.state());
        }
        self.controller.advance(now);
        while let Some(event) = self.controller.poll_event() {
            if let Event::Started { index, .. } = event {
                self.started.push(index);
            }
        }
    }

    fn loses(&mut self) -> bool {
        self.lost > 0 && self.dice.below(1000) < self.lost
    }

    /// Returns the answer to a request, as far as the line does not lose it.
    fn answer(&mut self, request: &FrameBuf) -> Vec<u8> {
        self.catch_up();
        self.heard.push((*request, self.controller.state().moving));
        if !self.loses() {
            self.controller.receive(LinkId(0), request.bytes());
        }
        if let Some(prober) = &mut self.prober {
            prober(request, &self.controller);
        }
        let mut replies = Vec::new();
        while let Some(reply) = self.controller.poll_transmit(LinkId(0)) {
            self.note(request, reply.bytes());
            if !self.swallowed.contains(&request.frame().id()) && !self.loses() {
                replies.extend_from_slice(reply.bytes());
            }
        }
        replies
    }

    fn note(&mut self, request: &FrameBuf, reply: &[u8]) {
        let (id, params) = (request.frame().id(), request.frame().params());
        if request.frame().ctrl().queued() && id < 240 && reply.len() >= 14 {
            let index = u64::from_le_bytes(reply[5..13].try_into().unwrap());
            if index > 0 {
                self.taken.push((index, params.to_vec()));
            }
        }
    }
}

impl Desk {
    /// Creates a desk whose answers take two milliseconds.
    pub(crate) fn new() -> Self {
        let desk = Self(Arc::new(Mutex::new(Inner {
            controller: Controller::new(Profile::default()),
            booted: Instant::now(),
            plugged: true,
            swallowed: Vec::new(),
            heard: Vec::new(),
            cable: None,
            watcher: None,
            prober: None,
            turnaround: Duration::from_millis(2),
            lost: 0,
            dice: Dice(1),
            taken: Vec::new(),
            started: Vec::new(),
        })));
        desk.replace("arm A");
        desk
    }

    /// Creates a desk whose line loses `lost` of a thousand frames, seeded by `seed`; answers take
    /// one millisecond.
    pub(crate) fn lossy(seed: u64, lost: u64) -> Self {
        let desk = Self::new();
        {
            let mut inner = desk.lock();
            inner.turnaround = Duration::from_millis(1);
            inner.lost = lost;
            inner.dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        }
        desk
    }

    /// Connects; nothing is lost during that.
    pub(crate) async fn connect(&self, options: Options) -> Arm {
        let lost = std::mem::take(&mut self.lock().lost);
        let arm = Arm::over_with(self.opener(), options).await.unwrap();
        self.lock().lost = lost;
        arm
    }

    pub(crate) fn opener(
        &self,
    ) -> impl FnMut() -> Ready<io::Result<DuplexStream>> + Send + 'static {
        let desk = self.clone();
        move || ready(desk.open())
    }

    fn open(&self) -> io::Result<DuplexStream> {
        let mut inner = self.lock();
        if !inner.plugged {
            return Err(io::ErrorKind::NotFound.into());
        }
        let (near, far) = duplex(1 << 16);
        inner.cable = Some(tokio::spawn(self.clone().serve(far)));
        Ok(near)
    }

    async fn serve(self, mut far: DuplexStream) {
        while let Ok(request) = request(&mut far).await {
            let turnaround = self.lock().turnaround;
            sleep(turnaround).await;
            let replies = self.lock().answer(&request);
            let _ = far.write_all(&replies).await;
        }
    }

    pub(crate) fn unplug(&self) {
        let mut inner = self.lock();
        inner.plugged = false;
        if let Some(cable) = inner.cable.take() {
            cable.abort();
        }
    }

    pub(crate) fn plug(&self) {
        self.lock().plugged = true;
    }

    /// Power-cycles the arm.
    pub(crate) fn reset(&self) {
        self.replace("arm A");
    }

    /// Replaces the arm by another one in its factory state.
    pub(crate) fn replace(&self, serial: &str) {
        let mut inner = self.lock();
        inner.controller = Controller::new(Profile::default());
        inner.booted = Instant::now();
        let serial = DeviceSn {
            device_sn: Text::new(serial).unwrap(),
        };
        let write = FrameBuf::encode(0, Ctrl::SET, &serial).unwrap();
        inner.controller.receive(LinkId(9), write.bytes());
    }

    /// Observes the arm every few milliseconds while it is busy.
    pub(crate) fn watched_by(&self, watcher: impl FnMut(&ControllerState) + Send + 'static) {
        self.lock().watcher = Some(Box::new(watcher));
    }

    /// Observes the arm after each request, before it answers.
    pub(crate) fn probed_by(&self, prober: impl FnMut(&FrameBuf, &Controller) + Send + 'static) {
        self.lock().prober = Some(Box::new(prober));
    }

    /// Sets the latency of answers.
    pub(crate) fn answers_after(&self, turnaround: Duration) {
        self.lock().turnaround = turnaround;
    }

    /// Sets the ids of requests that are received but not answered.
    pub(crate) fn swallow(&self, ids: &[u8]) {
        self.lock().swallowed = ids.to_vec();
    }

    /// Returns the ids of the requests since the last call, and whether each was more than a read.
    pub(crate) fn heard(&self) -> Vec<(u8, bool)> {
        let heard = std::mem::take(&mut self.lock().heard);
        let kind = |(frame, _): &(FrameBuf, bool)| {
            let frame = frame.frame();
            (frame.id(), frame.ctrl().write() || frame.ctrl().queued())
        };
        heard.iter().map(kind).collect()
    }

    /// Returns the parameters of all frames with this id since the last call, and whether the arm
    /// was moving at the time of each.
    pub(crate) fn frames(&self, id: u8) -> Vec<(Vec<u8>, bool)> {
        let heard = std::mem::take(&mut self.lock().heard);
        let of_id = heard.iter().filter(|(frame, _)| frame.frame().id() == id);
        of_id
            .map(|(frame, moved)| (frame.frame().params().to_vec(), *moved))
            .collect()
    }

    /// Returns the number of requests with this id since the last call.
    pub(crate) fn count(&self, id: u8) -> usize {
        let heard = self.heard();
        heard.iter().filter(|(heard, _)| *heard == id).count()
    }

    /// Returns the parameters of the queued commands that have started, in order.
    pub(crate) fn begun(&self) -> Vec<Vec<u8>> {
        let mut inner = self.lock();
        inner.catch_up();
        let find = |index: &u64| {
            let found = inner.taken.iter().find(|(taken, _)| taken == index);
            found.map(|(_, params)| params.clone())
        };
        inner.started.iter().filter_map(find).collect()
    }

    /// True if no command was queued yet.
    pub(crate) fn is_unused(&self) -> bool {
        self.lock().taken.is_empty()
    }

    pub(crate) fn with<T>(&self, look: impl FnOnce(&mut Controller) -> T) -> T {
        let mut inner = self.lock();
        inner.catch_up();
        look(&mut inner.controller)
    }

    pub(crate) fn moves(&self) -> bool {
        self.with(|arm| arm.state().moving)
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap()
    }
}

/// True if all requests were reads.
pub(crate) fn only_reads(heard: &[(u8, bool)]) -> bool {
    heard.iter().all(|(_, acts)| !acts)
}

/// Returns a connection that has learnt the identity of its arm.
pub(crate) async fn acquainted(desk: &Desk) -> Arm {
    let arm = desk.connect(Options::default()).await;
    sleep(Duration::from_millis(200)).await;
    desk.heard();
    arm
}
