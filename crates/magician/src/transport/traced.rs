//! Traces of a line: the bytes of both directions, in a pcapng file and for live observers.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use magician_protocol::Direction;
use magician_record::trace::{TraceLink, TraceWriter};

use super::{Leap, LeapTo, Line, Transport};

/// Trace file being written: all bytes on a line, as a pcapng file of link type USER0 for
/// Wireshark. Clones write to the same file.
#[derive(Clone, Default)]
pub struct Tracer {
    file: Option<Arc<Mutex<File>>>,
    tap: Option<Arc<dyn Tap>>,
}

/// Observer of the bytes on a line. It is called while they pass, and must not block.
pub trait Tap: Send + Sync {
    /// Called with bytes that passed on the line of this name, in the pieces in which they came.
    fn passed(&self, line: &str, direction: Direction, bytes: &[u8]);
}

struct File {
    /// `None` after a failed write.
    writer: Option<TraceWriter<Box<dyn Write + Send>>>,
    /// Reason of the failure.
    failed: Option<String>,
    links: Vec<(String, TraceLink)>,
    begun: Instant,
    /// Microseconds since 1970 at `begun`.
    epoch: u64,
}

impl Tracer {
    /// Starts a file. Every packet is written completely, so the file of a killed process can be
    /// read up to its last frame.
    ///
    /// # Errors
    /// Errors of the writer. A writer that fails later ends the trace with a warning; the line
    /// continues.
    pub fn new(out: impl Write + Send + 'static) -> io::Result<Self> {
        let out: Box<dyn Write + Send> = Box::new(out);
        // The wall clock is read once; later times follow the monotonic clock, which never jumps.
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let epoch = since.map_or(0, |since| u64::try_from(since.as_micros()).unwrap_or(0));
        let file = File {
            writer: Some(TraceWriter::new(out)?),
            failed: None,
            links: Vec::new(),
            begun: Instant::now(),
            epoch,
        };
        Ok(Self {
            file: Some(Arc::new(Mutex::new(file))),
            tap: None,
        })
    }

    /// Adds an observer, beside the file if there is one.
    #[must_use]
    pub fn tap(mut self, tap: Arc<dyn Tap>) -> Self {
        self.tap = Some(tap);
        self
    }

    /// Returns the reason why the file is incomplete, if it is.
    #[must_use]
    pub fn failed(&self) -> Option<String> {
        let file = self.file.as_ref()?;
        let file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.failed.clone()
    }

    /// Ends the file: later bytes are not written. Otherwise the file ends with the last of its
    /// clones.
    pub fn end(&self) {
        self.with(|file| {
            // Clones share the file, so none of them writes from now on.
            file.writer = None;
            Ok(())
        });
    }

    fn with(&self, act: impl FnOnce(&mut File) -> io::Result<()>) {
        let Some(file) = &self.file else {
            return;
        };
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(error) = act(&mut file) {
            // A full disk must not stop the arm.
            tracing::warn!(%error, "the trace cannot be written and stops here");
            file.writer = None;
            file.failed = Some(error.to_string());
        }
    }
}

impl std::fmt::Debug for Tracer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tracer").finish_non_exhaustive()
    }
}

impl File {
    /// Returns the link of this name; a reopened line continues its link.
    fn link(&mut self, name: &str) -> io::Result<Option<TraceLink>> {
        // A reopened line continues its interface, so one arm is one interface in Wireshark.
        let known = self.links.iter().find(|(known, _)| known == name);
        if let Some((_, link)) = known {
            return Ok(Some(*link));
        }
        let Some(writer) = &mut self.writer else {
            return Ok(None);
        };
        let link = writer.link(name)?;
        self.links.push((name.to_owned(), link));
        Ok(Some(link))
    }

    fn record(&mut self, name: &str, direction: Direction, bytes: &[u8]) -> io::Result<()> {
        let passed = u64::try_from(self.begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        let time = self.epoch.saturating_add(passed);
        match (self.link(name)?, &mut self.writer) {
            (Some(link), Some(writer)) => writer.record(link, time, direction, bytes),
            // A failed file, or a link that could not be added: the line continues without a trace.
            _ => Ok(()),
        }
    }

    fn close(&mut self, name: &str) -> io::Result<()> {
        match (self.link(name)?, &mut self.writer) {
            (Some(link), Some(writer)) => writer.close(link),
            _ => Ok(()),
        }
    }
}

impl Line {
    /// Records the line under its name.
    pub(crate) fn with_trace(self, tracer: Tracer) -> Self {
        let transport = Box::new(Traced::new(self.transport, tracer, &self.name));
        Self { transport, ..self }
    }
}

/// Line that is recorded.
pub(super) struct Traced {
    inner: Box<dyn Transport>,
    tracer: Tracer,
    name: String,
}

impl Traced {
    pub(super) fn new(inner: Box<dyn Transport>, tracer: Tracer, name: &str) -> Self {
        Self {
            inner,
            tracer,
            name: name.to_owned(),
        }
    }

    fn record(&self, direction: Direction, bytes: &[u8], count: &Poll<io::Result<usize>>) {
        // Only bytes that really passed: a partial write is recorded as far as it went.
        if let Poll::Ready(Ok(count)) = count {
            let bytes = bytes.get(..*count).unwrap_or_default();
            self.tracer
                .with(|file| file.record(&self.name, direction, bytes));
            if let Some(tap) = &self.tracer.tap {
                tap.passed(&self.name, direction, bytes);
            }
        }
    }
}

impl Transport for Traced {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let count = self.inner.poll_read(cx, bytes);
        self.record(Direction::Reply, bytes, &count);
        count
    }

    fn ask(&mut self) {
        self.inner.ask();
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let count = self.inner.poll_write(cx, bytes);
        self.record(Direction::Request, bytes, &count);
        count
    }

    fn lead(&mut self, leads: bool) -> bool {
        self.inner.lead(leads)
    }

    fn leap(&mut self, most: Duration, to: LeapTo) -> Option<Leap> {
        self.inner.leap(most, to)
    }
}

impl Drop for Traced {
    fn drop(&mut self) {
        self.tracer.with(|file| file.close(&self.name));
    }
}
