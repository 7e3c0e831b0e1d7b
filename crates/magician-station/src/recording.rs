//! Recordings of arms: orders to write them, the interface to files, and the background writer.
//!
//! The station decides what is recorded and sends [`RecordOrder`]s. The recorder writes on a
//! blocking thread, so that a slow disk delays neither stops nor readings. Readings and the bytes
//! of the serial line come from different sources and are merged by time.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::sync::Arc;

use magician_protocol::commands::Pose;
use magician_protocol::{AlarmSet, Direction};
use tokio::sync::{mpsc, oneshot};

use crate::control::{ArmId, RequestId};
use crate::frames::{FrameRing, RingPosition, TrafficPiece};
use crate::reading::ArmReading;

/// True if this build keeps recordings. A constant, so that the compiler drops the recorder from
/// the WebAssembly module of a page, which could not offer the files for download.
pub(crate) const IS_SUPPORTED: bool = cfg!(feature = "http");

/// Interval of flushing, s: the most that a crash can lose.
const FLUSH_INTERVAL: f64 = 1.0;

/// Reading as stored in files and in the history.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time of the reading, Unix seconds.
    pub t: f64,
    /// Position of the tip and joint angles.
    pub pose: Pose,
    /// Position on the rail, mm. `None` without a rail.
    pub rail: Option<f32>,
    /// Index of the last finished command of the queue.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// Active alarms.
    pub alarms: AlarmSet,
}

impl Sample {
    pub(crate) fn of(reading: &ArmReading, t: f64) -> Self {
        let mut alarms = AlarmSet::default();
        reading.alarms.iter().for_each(|code| alarms.insert(*code));
        Self {
            t,
            pose: reading.pose,
            rail: reading.rail,
            current_index: reading.current_index,
            left_space: reading.left_space,
            alarms,
        }
    }
}

/// Recording that is being written.
pub trait RecordingFile: Send {
    /// Appends a reading.
    ///
    /// # Errors
    /// Error of the file system.
    fn write(&mut self, sample: &Sample) -> io::Result<()>;

    /// Appends bytes that passed on a line at `t`, Unix seconds.
    ///
    /// # Errors
    /// Error of the file system.
    fn passed(&mut self, t: f64, line: &str, direction: Direction, bytes: &[u8]) -> io::Result<()>;

    /// Appends a note.
    ///
    /// # Errors
    /// Error of the file system.
    fn note(&mut self, t: f64, warning: bool, text: &str) -> io::Result<()>;

    /// Writes all buffered data to the file, so that it survives a crash of the program.
    ///
    /// # Errors
    /// Error of the file system.
    fn flush(&mut self) -> io::Result<()>;

    /// Completes the file. Returns its length, bytes.
    ///
    /// # Errors
    /// Error of the file system.
    fn finish(self: Box<Self>) -> io::Result<u64>;
}

/// Store of recordings.
pub trait RecordingStore: Send + Sync {
    /// True if the store can keep recordings.
    fn is_enabled(&self) -> bool {
        true
    }

    /// Creates a recording at `rate` readings per second. Time 0 in the file is `epoch`, Unix
    /// seconds.
    ///
    /// # Errors
    /// Error of the file system, also if the name exists already.
    fn begin(&self, name: &str, epoch: f64, rate: u32) -> io::Result<Box<dyn RecordingFile>>;

    /// Opens a recording, complete or not. Returns its bytes and their number.
    ///
    /// # Errors
    /// Error of the file system; [`NotFound`](io::ErrorKind::NotFound) if the name is not that of a
    /// recording.
    fn read(&self, name: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)>;
}

/// Store that keeps no recordings.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoRecordings;

impl RecordingStore for NoRecordings {
    fn is_enabled(&self) -> bool {
        false
    }

    fn begin(&self, _: &str, _: f64, _: u32) -> io::Result<Box<dyn RecordingFile>> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn read(&self, _: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// Order to the recorder.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordOrder {
    /// Start a recording.
    Begin {
        /// Request that is answered when the file exists.
        request: RequestId,
        /// Name of the file.
        name: String,
        /// Unix time at which the clock of the file shows 0, s.
        epoch: f64,
        /// Readings per second.
        rate: u32,
    },
    /// Append a reading.
    Sample(Box<Sample>),
    /// Append a note.
    Note(Note),
    /// End the recording.
    End {
        /// Request that is answered when the file is complete.
        request: RequestId,
    },
    /// Save the history as a file.
    Save {
        /// Request that is answered when the file is complete.
        request: RequestId,
        /// Name of the file.
        name: String,
        /// Most readings per second.
        rate: u32,
        /// Start, Unix seconds.
        from: f64,
        /// Readings, oldest first.
        samples: Vec<Sample>,
        /// Notes of the same time, oldest first.
        notes: Vec<Note>,
    },
}

/// Event of an arm in a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Time, Unix seconds.
    pub t: f64,
    /// True for a warning.
    pub warning: bool,
    /// Text.
    pub text: String,
}

/// Report of the recorder.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordReport {
    /// A file was created or completed.
    Done {
        /// The request.
        request: RequestId,
        /// Length of the file in bytes, or the error of the file system.
        outcome: Result<u64, String>,
    },
    /// The recording in progress failed: the error of the file system.
    Lost(String),
}

pub(crate) enum RecorderMessage {
    Order(ArmId, RecordOrder),
    /// Complete all recordings.
    Close(oneshot::Sender<()>),
}

/// Background writer of recordings. Carries out orders one after the other.
pub(crate) struct Recorder(mpsc::UnboundedSender<RecorderMessage>);

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recorder").finish_non_exhaustive()
    }
}

impl Recorder {
    /// Starts the recorder on the current runtime. When it is dropped all recordings are completed.
    pub(crate) fn start(
        store: Arc<dyn RecordingStore>,
        lines: Vec<Arc<FrameRing>>,
        report: impl Fn(ArmId, RecordReport) + Send + 'static,
    ) -> Self {
        let (orders, mut inbox) = mpsc::unbounded_channel();
        // Without recordings there is no task, and orders go nowhere.
        if !IS_SUPPORTED {
            return Self(orders);
        }
        tokio::spawn(async move {
            let mut files = RecordingFiles {
                store,
                lines,
                open: BTreeMap::new(),
            };
            let mut jobs = Vec::new();
            // Takes everything that queued up while the disk was busy, so a slow disk costs one
            // switch of threads per batch.
            while inbox.recv_many(&mut jobs, usize::MAX).await > 0 {
                let batch = std::mem::take(&mut jobs);
                // A reading that only goes to memory is not worth a blocking thread.
                let quick = { batch.iter() }
                    .all(|job| matches!(job, RecorderMessage::Order(_, RecordOrder::Sample(_))));
                let reports;
                if quick && files.can_wait(&batch) {
                    reports = files.carry_out(batch);
                } else {
                    let done = crate::engine::run_blocking(move || {
                        let reports = files.carry_out(batch);
                        (files, reports)
                    });
                    // The runtime shuts down.
                    let Ok(done) = done.await else { return };
                    (files, reports) = done;
                }
                reports
                    .into_iter()
                    .for_each(|(arm, told)| report(arm, told));
            }
            // Dropping completes the files, which may block.
            let _ = crate::engine::run_blocking(move || drop(files)).await;
        });
        Self(orders)
    }

    pub(crate) fn order(&self, arm: ArmId, order: RecordOrder) {
        // Fails only while the station shuts down.
        let _ = self.0.send(RecorderMessage::Order(arm, order));
    }

    /// Completes all recordings. The receiver resolves when it is done.
    pub(crate) fn close(&self) -> oneshot::Receiver<()> {
        let (done, closed) = oneshot::channel();
        let _ = self.0.send(RecorderMessage::Close(done));
        closed
    }
}

struct RecordingFiles {
    store: Arc<dyn RecordingStore>,
    /// Lines of the arms, by index. Empty if no line is tapped.
    lines: Vec<Arc<FrameRing>>,
    open: BTreeMap<ArmId, OpenRecording>,
}

struct OpenRecording {
    file: Box<dyn RecordingFile>,
    /// Readings still to be written.
    samples: Vec<Sample>,
    /// Time of the last flush, Unix seconds.
    flushed: f64,
    /// The line, and the position up to which it is written.
    line: Option<(Arc<FrameRing>, RingPosition)>,
}

/// Writes readings and line traffic, merged by time.
fn write_merged(
    file: &mut dyn RecordingFile,
    samples: impl IntoIterator<Item = Sample>,
    passed: Vec<TrafficPiece>,
    line: Option<&FrameRing>,
) -> io::Result<()> {
    let mut passed = passed.into_iter().peekable();
    let (name, unix) = match line {
        Some(line) => (line.line(), Some(|at| line.unix(at))),
        None => ("", None),
    };
    // Traffic up to the time of a reading is written before it.
    let mut before = |file: &mut dyn RecordingFile, t: f64| {
        let Some(unix) = &unix else { return Ok(()) };
        while let Some(piece) = passed.next_if(|piece| unix(piece.at) <= t) {
            file.passed(unix(piece.at), name, piece.direction, &piece.bytes)?;
        }
        Ok(())
    };
    for sample in samples {
        before(file, sample.t)?;
        file.write(&sample)?;
    }
    // The traffic after the last reading.
    before(file, f64::INFINITY)
}

impl OpenRecording {
    /// Writes everything that is buffered.
    fn write_merged(&mut self) -> io::Result<()> {
        let file = &mut *self.file;
        let mut passed = Vec::new();
        if let Some((line, mark)) = &mut self.line {
            let missed;
            (passed, *mark, missed) = line.since(mark);
            // The ring dropped pieces before they were read: say so, or the gap looks like silence.
            if missed > 0 {
                let words = format!("{missed} pieces of the line are missing here");
                file.note(self.flushed, true, &words)?;
            }
        }
        let line = self.line.as_ref().map(|(line, _)| &**line);
        write_merged(file, self.samples.drain(..), passed, line)
    }

    fn is_due(&self, t: f64) -> bool {
        t - self.flushed >= FLUSH_INTERVAL
    }

    fn add(&mut self, sample: Sample) -> io::Result<()> {
        let due = self.is_due(sample.t);
        self.samples.push(sample);
        if due {
            self.write_merged()?;
            self.flushed = sample.t;
            self.file.flush()?;
        }
        Ok(())
    }

    fn note(&mut self, note: &Note) -> io::Result<()> {
        self.write_merged()?;
        self.file.note(note.t, note.warning, &note.text)?;
        self.file.flush()
    }

    fn end(mut self) -> io::Result<u64> {
        self.write_merged()?;
        self.file.finish()
    }
}

impl Drop for RecordingFiles {
    fn drop(&mut self) {
        self.close();
    }
}

impl RecordingFiles {
    /// True if no message has to be written to a file at once.
    fn can_wait(&self, jobs: &[RecorderMessage]) -> bool {
        jobs.iter().all(|job| match job {
            RecorderMessage::Order(arm, RecordOrder::Sample(sample)) => {
                { self.open.get(arm) }.is_none_or(|open| !open.is_due(sample.t))
            }
            // Notes, beginnings and ends are written at once.
            _ => false,
        })
    }

    fn carry_out(&mut self, jobs: Vec<RecorderMessage>) -> Vec<(ArmId, RecordReport)> {
        let mut reports = Vec::new();
        for job in jobs {
            match job {
                RecorderMessage::Order(arm, order) => {
                    reports.extend(self.handle_order(arm, order).map(|told| (arm, told)));
                }
                RecorderMessage::Close(done) => {
                    self.close();
                    let _ = done.send(());
                }
            }
        }
        reports
    }

    fn close(&mut self) {
        for (_, open) in std::mem::take(&mut self.open) {
            if let Err(error) = open.end() {
                tracing::warn!(%error, "a recording cannot be completed");
            }
        }
    }

    fn handle_order(&mut self, arm: ArmId, order: RecordOrder) -> Option<RecordReport> {
        let done = |request, outcome: io::Result<u64>| {
            let outcome = outcome.map_err(|error| error.to_string());
            Some(RecordReport::Done { request, outcome })
        };
        let wrote = match order {
            RecordOrder::Begin {
                request,
                name,
                epoch,
                rate,
            } => {
                let begun = self.store.begin(&name, epoch, rate);
                let begun = begun.and_then(|mut file| {
                    // Created on the disk before the client learns the name.
                    file.flush()?;
                    Ok(file)
                });
                let outcome = begun.map(|file| {
                    let line = self.lines.get(arm.0 as usize);
                    let open = OpenRecording {
                        line: line.map(|line| (Arc::clone(line), line.position())),
                        file,
                        samples: Vec::new(),
                        flushed: epoch,
                    };
                    self.open.insert(arm, open);
                    0
                });
                return done(request, outcome);
            }
            RecordOrder::End { request } => {
                let open = self.open.remove(&arm);
                let lost = || Err(io::Error::other("the recording is over"));
                return done(request, open.map_or_else(lost, OpenRecording::end));
            }
            RecordOrder::Save {
                request,
                name,
                rate,
                from,
                samples,
                notes,
            } => {
                let line = self.lines.get(arm.0 as usize);
                let mut passed =
                    line.map_or_else(Vec::new, |line| line.since(&RingPosition::default()).0);
                if let Some(line) = line {
                    // The ring may reach further back than the readings.
                    passed.retain(|piece| line.unix(piece.at) >= from);
                }
                let first = { samples.iter().map(|sample| sample.t) }
                    .chain(notes.iter().map(|note| note.t))
                    .chain(
                        line.iter()
                            .flat_map(|line| passed.first().map(|piece| line.unix(piece.at))),
                    );
                // The epoch is the earliest time of all three sources, so that no time in the file
                // is negative.
                let epoch = first.fold(f64::INFINITY, f64::min);
                let epoch = if epoch.is_finite() { epoch } else { from };
                let saved = self.store.begin(&name, epoch, rate).and_then(|mut file| {
                    write_merged(&mut *file, samples, passed, line.map(|line| &**line))?;
                    for note in &notes {
                        file.note(note.t, note.warning, &note.text)?;
                    }
                    file.finish()
                });
                return done(request, saved);
            }
            RecordOrder::Sample(sample) => self.open.get_mut(&arm)?.add(*sample),
            RecordOrder::Note(note) => self.open.get_mut(&arm)?.note(&note),
        };
        let error = wrote.err()?;
        // A file that failed once is given up: a gap in the middle would look like a silent arm.
        self.open.remove(&arm);
        Some(RecordReport::Lost(error.to_string()))
    }
}
