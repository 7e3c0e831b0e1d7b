use std::path::PathBuf;
use std::time::{Duration, Instant};

use magician_protocol::commands::DeviceId;
use magician_protocol::{Direction, FrameBuf, NoArgs, Readable};

use super::keep::Keeper;
use super::recording::Recording;
use super::{Notice, OnNotice, ServeError};
use crate::{FlashError, LinkId, Micros, Runner};

/// What all endpoints share: the arm on the wall clock, the log and the trace.
pub(super) struct Hub {
    runner: Runner,
    start: Instant,
    links: u32,
    on_notice: OnNotice,
    tape: tape::Tape,
    keeper: Option<Keeper>,
    recording: Recording,
}

/// A client: its link to the arm and its place in the trace.
pub(super) struct Peer {
    link: LinkId,
    name: String,
    tape: tape::Place,
}

impl Hub {
    pub(super) fn new(runner: Runner, on_notice: OnNotice) -> Self {
        Self {
            runner,
            start: Instant::now(),
            links: 0,
            on_notice,
            tape: tape::Tape::OFF,
            keeper: None,
            recording: Recording::default(),
        }
    }

    /// Keeps the flash in a file.
    pub(super) fn keep_flash(&mut self, path: PathBuf) {
        self.keeper = Some(Keeper::new(path, self.runner.controller()));
    }

    #[cfg(feature = "record")]
    pub(super) fn record(
        &mut self,
        out: Box<dyn std::io::Write + Send>,
        speed: crate::Speed,
    ) -> Result<(), ServeError> {
        self.recording = Recording::begin(out, &mut self.runner, speed)?;
        Ok(())
    }

    #[cfg(feature = "trace")]
    pub(super) fn trace(&mut self, out: Box<dyn std::io::Write + Send>) -> std::io::Result<()> {
        self.tape = tape::Tape::new(out)?;
        Ok(())
    }

    pub(super) fn runner(&self) -> &Runner {
        &self.runner
    }

    pub(super) fn runner_mut(&mut self) -> &mut Runner {
        &mut self.runner
    }

    /// A client came, or may come.
    pub(super) fn open(&mut self, name: String) -> Peer {
        let tape = self.tape.open(&name);
        self.taped(tape.1);
        Peer {
            link: self.next_link(&name),
            name,
            tape: tape.0,
        }
    }

    /// A client left, and the next will be known by the same name.
    #[cfg(unix)]
    pub(super) fn renew(&mut self, peer: &mut Peer) {
        self.forget(peer);
        peer.link = self.next_link(&peer.name);
    }

    /// A client that may have come did not, and will not.
    pub(super) fn forget(&mut self, peer: &Peer) {
        self.runner.close(peer.link);
        let written = self.tape.close(&peer.tape);
        self.taped(written);
    }

    /// A client left.
    pub(super) fn close(&mut self, peer: Peer) {
        self.forget(&peer);
        self.notice(Notice::Left(peer.name));
    }

    /// Bytes that the client may send before it should be made to wait.
    pub(super) fn room(&self, peer: &Peer) -> usize {
        self.runner.room(peer.link)
    }

    pub(super) fn receive(&mut self, peer: &Peer, bytes: &[u8]) {
        let now = self.now();
        let written = self.tape.record(&peer.tape, now, Direction::Request, bytes);
        self.taped(written);
        self.runner.receive(now, peer.link, bytes);
    }

    pub(super) fn reply(&mut self, peer: &Peer) -> Option<FrameBuf> {
        let now = self.now();
        let reply = self.runner.poll_transmit(now, peer.link)?;
        let written = self
            .tape
            .record(&peer.tape, now, Direction::Reply, reply.bytes());
        self.taped(written);
        Some(reply)
    }

    /// The three words by which the arm can be told from all others, as it answers them.
    pub(super) fn device_id(&mut self) -> [u32; 3] {
        let link = self.next_link("discovery");
        let controller = self.runner.controller_mut();
        if let Ok(request) = FrameBuf::get(&NoArgs, DeviceId::ROW) {
            controller.receive(link, request.bytes());
        }
        let reply = controller.poll_transmit(link);
        controller.close(link);
        let value = reply.and_then(|reply| reply.frame().read::<DeviceId>().ok());
        value.map_or([0; 3], |id| id.device_id)
    }

    pub(super) fn notice(&mut self, notice: Notice) {
        (self.on_notice)(notice);
    }

    /// Lets time pass.
    pub(super) fn tick(&mut self) {
        let now = self.now();
        self.runner.handle_timeout(now);
    }

    /// Passes on what the controller has to tell.
    pub(super) fn report(&mut self) {
        while let Some(event) = self.runner.controller_mut().poll_event() {
            self.notice(Notice::Arm(event));
        }
        if let Some(error) = self.recording.ended() {
            self.notice(Notice::RecordingEnded(error));
        }
        let now = self.now();
        if let Some(keeper) = &mut self.keeper {
            let kept = keeper.keep(now, self.runner.controller());
            self.kept(kept);
        }
    }

    /// A flash that cannot be written is no reason to stop serving.
    fn kept(&mut self, kept: Result<(), FlashError>) {
        if let Err(error) = kept {
            self.notice(Notice::FlashNotKept(error));
        }
    }

    /// Completes what is being written.
    pub(super) fn end(mut self) -> Result<(), ServeError> {
        self.tick();
        self.recording.end(&mut self.runner)
    }

    /// How long nothing is due.
    pub(super) fn wait(&self) -> Option<Duration> {
        let keeper = self.keeper.as_ref();
        let due = [
            self.runner.poll_timeout(),
            keeper.and_then(|keeper| keeper.due()),
        ];
        let at = due.into_iter().flatten().min()?;
        Some(Duration::from_micros(at.saturating_sub(self.now())))
    }

    fn now(&self) -> Micros {
        Micros::try_from(self.start.elapsed().as_micros()).unwrap_or(Micros::MAX)
    }

    /// The link of a client that is known by this name.
    fn next_link(&mut self, name: &str) -> LinkId {
        let link = LinkId(self.links);
        self.links = self.links.wrapping_add(1);
        self.recording.name(link, name);
        link
    }

    /// A trace that cannot be written ends; the arm does not.
    fn taped(&mut self, written: std::io::Result<()>) {
        if let Err(error) = written {
            self.tape = tape::Tape::OFF;
            self.notice(Notice::TraceEnded(error));
        }
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        if let Some(mut keeper) = self.keeper.take() {
            let kept = keeper.finish(self.runner.controller());
            self.kept(kept);
        }
    }
}

#[cfg(feature = "trace")]
mod tape {
    use std::io::{self, Write};
    use std::time::SystemTime;

    use magician_protocol::Direction;

    use crate::Micros;
    use crate::trace::{TraceLink, TraceWriter};

    /// The trace, if there is one.
    pub(super) struct Tape(Option<Running>);

    struct Running {
        writer: TraceWriter<Box<dyn Write + Send>>,
        /// Microseconds since 1970 when the wall clock of the runner showed 0.
        epoch: u64,
    }

    pub(super) struct Place(Option<TraceLink>);

    impl Tape {
        pub(super) const OFF: Self = Self(None);

        pub(super) fn new(out: Box<dyn Write + Send>) -> io::Result<Self> {
            let epoch = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
            Ok(Self(Some(Running {
                writer: TraceWriter::new(out)?,
                epoch: u64::try_from(epoch.as_micros()).unwrap_or_default(),
            })))
        }

        pub(super) fn open(&mut self, name: &str) -> (Place, io::Result<()>) {
            let link = self.0.as_mut().map(|tape| tape.writer.link(name));
            match link.transpose() {
                Ok(link) => (Place(link), Ok(())),
                Err(error) => (Place(None), Err(error)),
            }
        }

        pub(super) fn record(
            &mut self,
            place: &Place,
            now: Micros,
            direction: Direction,
            bytes: &[u8],
        ) -> io::Result<()> {
            let (Some(tape), Some(link)) = (&mut self.0, place.0) else {
                return Ok(());
            };
            let time = tape.epoch.saturating_add(now);
            tape.writer.record(link, time, direction, bytes)
        }

        pub(super) fn close(&mut self, place: &Place) -> io::Result<()> {
            match (&mut self.0, place.0) {
                (Some(tape), Some(link)) => tape.writer.close(link),
                _ => Ok(()),
            }
        }
    }
}

/// Without the feature there is nothing to write to.
#[cfg(not(feature = "trace"))]
mod tape {
    use std::io;

    use magician_protocol::Direction;

    use crate::Micros;

    pub(super) struct Tape;
    pub(super) struct Place;

    impl Tape {
        pub(super) const OFF: Self = Self;

        pub(super) fn open(&mut self, _: &str) -> (Place, io::Result<()>) {
            (Place, Ok(()))
        }

        pub(super) fn record(
            &mut self,
            _: &Place,
            _: Micros,
            _: Direction,
            _: &[u8],
        ) -> io::Result<()> {
            Ok(())
        }

        pub(super) fn close(&mut self, _: &Place) -> io::Result<()> {
            Ok(())
        }
    }
}
