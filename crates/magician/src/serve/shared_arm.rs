//! Virtual arm on the wall clock, as a service behind endpoints, with log, trace and files.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use magician_protocol::{Direction, FrameBuf};

use super::files::FlashFileError;
use super::flash_file::FlashFile;
use super::recording::Recording;
use super::service::device_id;
use super::{Notice, OnNotice, ServeError, Service};
use magician_sim::{HostInstant, LinkId, Runner};

/// Virtual arm shared by all endpoints: wall clock, log and trace.
pub(super) struct SharedArm {
    runner: Runner,
    start: Instant,
    links: u32,
    on_notice: OnNotice,
    tape: tape::Tape,
    keeper: Option<FlashFile>,
    recording: Recording,
}

impl SharedArm {
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
        self.keeper = Some(FlashFile::new(path, self.runner.controller()));
    }

    #[cfg(feature = "record")]
    pub(super) fn record(
        &mut self,
        out: Box<dyn std::io::Write + Send>,
        speed: magician_sim::Speed,
    ) -> Result<(), ServeError> {
        // Before the first client, so that the recording has every motion.
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

    /// Lets time pass.
    pub(super) fn tick(&mut self) {
        let now = self.now();
        self.runner.handle_timeout(now);
    }

    /// Passes on the events of the controller.
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

    /// Reports a flash that could not be written, which is no reason to stop serving.
    fn kept(&mut self, kept: Result<(), FlashFileError>) {
        if let Err(error) = kept {
            self.notice(Notice::FlashNotKept(error));
        }
    }

    /// Completes the files being written.
    pub(super) fn end(mut self) -> Result<(), ServeError> {
        self.tick();
        self.recording.end(&mut self.runner)
    }

    /// Returns the time until something is due.
    pub(super) fn wait(&self) -> Option<Duration> {
        let keeper = self.keeper.as_ref();
        let due = [
            self.runner.poll_timeout(),
            keeper.and_then(|keeper| keeper.due()),
        ];
        let at = due.into_iter().flatten().min()?;
        Some(at - self.now())
    }

    fn now(&self) -> HostInstant {
        HostInstant::ZERO + self.start.elapsed()
    }

    /// Returns a new link for a client of this name.
    fn next_link(&mut self, name: &str) -> LinkId {
        let link = LinkId(self.links);
        // A link is never reused while its number is in a trace; after 2^32 clients that no longer
        // matters.
        self.links = self.links.wrapping_add(1);
        self.recording.name(link, name);
        link
    }

    /// Handles a write to the trace. A trace that fails is ended; the arm continues.
    fn taped(&mut self, written: std::io::Result<()>) {
        if let Err(error) = written {
            self.tape = tape::Tape::OFF;
            self.notice(Notice::TraceEnded(error));
        }
    }
}

impl Service for SharedArm {
    fn open(&mut self, name: &str) -> LinkId {
        let link = self.next_link(name);
        let written = self.tape.open(link, name);
        self.taped(written);
        link
    }

    fn close(&mut self, link: LinkId) {
        self.runner.close(link);
        let written = self.tape.close(link);
        self.taped(written);
    }

    fn renew(&mut self, link: LinkId, name: &str) -> LinkId {
        // Renewed, not reopened: the trace keeps one interface for all successive clients of a
        // terminal.
        self.runner.close(link);
        let next = self.next_link(name);
        let written = self.tape.renew(link, next);
        self.taped(written);
        next
    }

    fn room(&self, link: LinkId) -> usize {
        self.runner.room(link)
    }

    fn receive(&mut self, link: LinkId, bytes: &[u8]) {
        let now = self.now();
        let written = self.tape.record(link, now, Direction::Request, bytes);
        self.taped(written);
        self.runner.receive(now, link, bytes);
    }

    fn reply(&mut self, link: LinkId) -> Option<FrameBuf> {
        let now = self.now();
        let reply = self.runner.poll_transmit(now, link)?;
        let bytes = reply.bytes();
        let written = self.tape.record(link, now, Direction::Reply, bytes);
        self.taped(written);
        Some(reply)
    }

    fn notice(&mut self, notice: Notice) {
        (self.on_notice)(notice);
    }

    fn plugged(&self) -> bool {
        self.runner.plugged()
    }

    fn device_id(&mut self) -> [u32; 3] {
        let link = self.next_link("discovery");
        device_id(self.runner.controller_mut(), link)
    }
}

impl Drop for SharedArm {
    fn drop(&mut self) {
        // On drop and not only at the end: a cancelled server must keep the flash as well.
        if let Some(mut keeper) = self.keeper.take() {
            let kept = keeper.finish(self.runner.controller());
            self.kept(kept);
        }
    }
}

#[cfg(feature = "trace")]
mod tape {
    use std::collections::BTreeMap;
    use std::io::{self, Write};
    use std::time::SystemTime;

    use magician_protocol::Direction;

    use magician_record::trace::{TraceLink, TraceWriter};
    use magician_sim::{HostInstant, LinkId};

    /// Trace, if requested.
    pub(super) struct Tape(Option<Running>);

    struct Running {
        writer: TraceWriter<Box<dyn Write + Send>>,
        places: BTreeMap<LinkId, TraceLink>,
        /// Microseconds since 1970 at time 0 of the runner's host clock.
        epoch: u64,
    }

    impl Tape {
        pub(super) const OFF: Self = Self(None);

        pub(super) fn new(out: Box<dyn Write + Send>) -> io::Result<Self> {
            // A clock before 1970 gives epoch 0: the trace then has wrong dates, but is still
            // written.
            let epoch = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
            Ok(Self(Some(Running {
                writer: TraceWriter::new(out)?,
                places: BTreeMap::new(),
                epoch: u64::try_from(epoch.as_micros()).unwrap_or_default(),
            })))
        }

        pub(super) fn open(&mut self, link: LinkId, name: &str) -> io::Result<()> {
            if let Some(tape) = &mut self.0 {
                let place = tape.writer.link(name)?;
                tape.places.insert(link, place);
            }
            Ok(())
        }

        pub(super) fn record(
            &mut self,
            link: LinkId,
            now: HostInstant,
            direction: Direction,
            bytes: &[u8],
        ) -> io::Result<()> {
            let Some(tape) = &mut self.0 else {
                return Ok(());
            };
            let Some(place) = tape.places.get(&link) else {
                return Ok(());
            };
            // Host time of the runner, so that the trace agrees with the pacing of the line.
            let time = tape.epoch.saturating_add(now.as_micros());
            tape.writer.record(*place, time, direction, bytes)
        }

        pub(super) fn close(&mut self, link: LinkId) -> io::Result<()> {
            let Some(tape) = &mut self.0 else {
                return Ok(());
            };
            let place = tape.places.remove(&link);
            place.map_or(Ok(()), |place| tape.writer.close(place))
        }

        /// Passes the interface of one client on to its successor.
        pub(super) fn renew(&mut self, link: LinkId, next: LinkId) -> io::Result<()> {
            let Some(tape) = &mut self.0 else {
                return Ok(());
            };
            let Some(place) = tape.places.remove(&link) else {
                return Ok(());
            };
            tape.places.insert(next, place);
            tape.writer.close(place)
        }
    }
}

/// Empty substitute without the feature.
#[cfg(not(feature = "trace"))]
mod tape {
    use std::io;

    use magician_protocol::Direction;

    use magician_sim::{HostInstant, LinkId};

    pub(super) struct Tape;

    impl Tape {
        pub(super) const OFF: Self = Self;

        pub(super) fn open(&mut self, _: LinkId, _: &str) -> io::Result<()> {
            Ok(())
        }

        pub(super) fn record(
            &mut self,
            _: LinkId,
            _: HostInstant,
            _: Direction,
            _: &[u8],
        ) -> io::Result<()> {
            Ok(())
        }

        pub(super) fn close(&mut self, _: LinkId) -> io::Result<()> {
            Ok(())
        }

        pub(super) fn renew(&mut self, _: LinkId, _: LinkId) -> io::Result<()> {
            Ok(())
        }
    }
}
