//! An arm on a desk, whose cable can be pulled and plugged in again, and that can be reset or swapped for another.

use std::future::{Ready, ready};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use magician::commands::DeviceSn;
use magician::protocol::{FrameBuf, Text};
use magician::sim::{Controller, ControllerState, LinkId, Profile};
use magician::{Arm, Ctrl, Options};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep};

#[derive(Clone)]
pub(crate) struct Desk(Arc<Mutex<Inner>>);

struct Inner {
    controller: Controller,
    booted: Instant,
    plugged: bool,
    /// Requests of these ids are heard and not answered.
    swallowed: Vec<u8>,
    heard: Vec<FrameBuf>,
    cable: Option<JoinHandle<()>>,
    watcher: Option<Watcher>,
}

/// Looks at the arm every few milliseconds of its clock.
type Watcher = Box<dyn FnMut(&ControllerState) + Send>;

/// How often it does, us.
const WATCHED: u64 = 4_000;

impl Inner {
    /// The arm comes to the present, watched on its way.
    fn catch_up(&mut self) {
        let now = self.booted.elapsed().as_micros() as u64;
        while let Some(watcher) = &mut self.watcher {
            let at = self.controller.now();
            if at >= now {
                break;
            }
            // Nothing is seen of an arm at rest.
            let still = !self.controller.busy();
            self.controller
                .advance(if still { now } else { now.min(at + WATCHED) });
            watcher(&self.controller.state());
        }
        self.controller.advance(now);
    }
}

impl Desk {
    pub(crate) fn new() -> Self {
        let desk = Self(Arc::new(Mutex::new(Inner {
            controller: Controller::new(Profile::default()),
            booted: Instant::now(),
            plugged: true,
            swallowed: Vec::new(),
            heard: Vec::new(),
            cable: None,
            watcher: None,
        })));
        desk.replace("arm A");
        desk
    }

    pub(crate) async fn connect(&self, options: Options) -> Arm {
        Arm::over_with(self.opener(), options).await.unwrap()
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
        let mut head = [0; 3];
        while far.read_exact(&mut head).await.is_ok() {
            let mut rest = vec![0; usize::from(head[2]) + 1];
            far.read_exact(&mut rest).await.unwrap();
            let request = FrameBuf::new(rest[0], Ctrl(rest[1]), &rest[2..rest.len() - 1]).unwrap();
            // An answer takes two milliseconds.
            sleep(Duration::from_millis(2)).await;
            let mut replies = Vec::new();
            {
                let mut inner = self.lock();
                inner.heard.push(request);
                inner.catch_up();
                inner.controller.receive(LinkId(0), request.bytes());
                while let Some(reply) = inner.controller.poll_transmit(LinkId(0)) {
                    if !inner.swallowed.contains(&request.frame().id()) {
                        replies.extend_from_slice(reply.bytes());
                    }
                }
            }
            let _ = far.write_all(&replies).await;
        }
    }

    pub(crate) fn unplug(&self) {
        let mut inner = self.lock();
        inner.plugged = false;
        inner.cable.take().expect("it was plugged in").abort();
    }

    pub(crate) fn plug(&self) {
        self.lock().plugged = true;
    }

    /// Switches it off and on.
    pub(crate) fn reset(&self) {
        self.replace("arm A");
    }

    /// Puts another arm in its place, fresh from the box.
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

    /// Has the arm looked at every few milliseconds that it is busy.
    pub(crate) fn watched_by(&self, watcher: impl FnMut(&ControllerState) + Send + 'static) {
        self.lock().watcher = Some(Box::new(watcher));
    }

    /// Requests of these ids are heard and not answered.
    pub(crate) fn swallow(&self, ids: &[u8]) {
        self.lock().swallowed = ids.to_vec();
    }

    /// What was asked since the last look: ids, and whether each was more than a read.
    pub(crate) fn heard(&self) -> Vec<(u8, bool)> {
        let heard = std::mem::take(&mut self.lock().heard);
        let kind = |frame: &FrameBuf| {
            let frame = frame.frame();
            (frame.id(), frame.ctrl().write() || frame.ctrl().queued())
        };
        heard.iter().map(kind).collect()
    }

    /// How often something was asked since the last look.
    pub(crate) fn count(&self, id: u8) -> usize {
        let heard = self.heard();
        heard.iter().filter(|(heard, _)| *heard == id).count()
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

/// Nothing but reads.
pub(crate) fn only_reads(heard: &[(u8, bool)]) -> bool {
    heard.iter().all(|(_, acts)| !acts)
}
