//! Recordings of arms: what is to be written, and what writes it, off the arms' way.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::sync::Arc;

use magician_protocol::commands::Pose;
use magician_protocol::{AlarmSet, Direction};
use tokio::sync::{mpsc, oneshot};

use crate::control::{ArmId, RequestId};
use crate::frames::{FrameRing, Mark, PassedBytes};
use crate::reading::ArmReading;

/// Whether this build keeps recordings. A constant, so that nothing of them is in a page's module, from which nobody could fetch one.
pub(crate) const KEEPS: bool = cfg!(feature = "http");

/// What was written is in the file after so long, s.
const FLUSH: f64 = 1.0;

/// What is kept of a reading: for files, and for the last minutes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the pose was read, Unix seconds.
    pub t: f64,
    /// Where the tip is, and the joints.
    pub pose: Pose,
    /// Where on the rail, mm, if it has one.
    pub rail: Option<f32>,
    /// The command of the queue that was finished last.
    pub current_index: u64,
    /// Free places in the queue.
    pub left_space: u32,
    /// The alarms that stand.
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

/// A recording that is being written.
pub trait RecordingFile: Send {
    /// Adds what was read.
    ///
    /// # Errors
    /// What the system says.
    fn write(&mut self, sample: &Sample) -> io::Result<()>;

    /// Adds what passed on a line at these Unix seconds.
    ///
    /// # Errors
    /// What the system says.
    fn passed(&mut self, t: f64, line: &str, direction: Direction, bytes: &[u8]) -> io::Result<()>;

    /// Adds a sentence.
    ///
    /// # Errors
    /// What the system says.
    fn note(&mut self, t: f64, warning: bool, words: &str) -> io::Result<()>;

    /// Has all of it in the file, whatever becomes of the program.
    ///
    /// # Errors
    /// What the system says.
    fn flush(&mut self) -> io::Result<()>;

    /// Completes the file; how long it is, bytes.
    ///
    /// # Errors
    /// What the system says.
    fn finish(self: Box<Self>) -> io::Result<u64>;
}

/// Where recordings are kept.
pub trait RecordingStore: Send + Sync {
    /// Whether it keeps any.
    fn keeps(&self) -> bool {
        true
    }

    /// Begins one that does not exist, of so many readings a second, whose clock shows 0 at these Unix seconds.
    ///
    /// # Errors
    /// What the system says.
    fn begin(&self, name: &str, epoch: f64, rate: u32) -> io::Result<Box<dyn RecordingFile>>;

    /// The bytes of one, as far as it is written, and how many they are.
    ///
    /// # Errors
    /// What the system says; [`NotFound`](io::ErrorKind::NotFound) for a name that is none of a recording.
    fn read(&self, name: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)>;
}

/// Keeps no recordings.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoRecordings;

impl RecordingStore for NoRecordings {
    fn keeps(&self) -> bool {
        false
    }

    fn begin(&self, _: &str, _: f64, _: u32) -> io::Result<Box<dyn RecordingFile>> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn read(&self, _: &str) -> io::Result<(Box<dyn io::Read + Send>, u64)> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// Something that a recording needs done.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordOrder {
    /// One begins.
    Begin {
        /// The request that is answered when its file is there.
        request: RequestId,
        /// Its file.
        name: String,
        /// When its clock shows 0, Unix seconds.
        epoch: f64,
        /// Readings a second.
        rate: u32,
    },
    /// The arm was read.
    Sample(Box<Sample>),
    /// Something happened to the arm.
    Note(Note),
    /// It ends.
    End {
        /// The request that is answered when its file is whole.
        request: RequestId,
    },
    /// What was read before becomes a file.
    Save {
        /// The request that is answered when it is whole.
        request: RequestId,
        /// Its file.
        name: String,
        /// Readings a second, at most.
        rate: u32,
        /// From when on, Unix seconds.
        from: f64,
        /// The readings, the oldest first.
        samples: Vec<Sample>,
        /// What happened meanwhile, the oldest first.
        notes: Vec<Note>,
    },
}

/// Something that happened to an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// When, Unix seconds.
    pub t: f64,
    /// Whether it is a warning.
    pub warning: bool,
    /// What.
    pub words: String,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordReport {
    /// A file was begun, or is whole.
    Done {
        /// The request.
        request: RequestId,
        /// How long it is, bytes; or what the system says.
        outcome: Result<u64, String>,
    },
    /// The recording under way cannot be written any more.
    Lost(String),
}

pub(crate) enum Job {
    Order(ArmId, RecordOrder),
    /// All recordings are completed.
    Close(oneshot::Sender<()>),
}

/// Writes recordings, one thing after another, in the background.
pub(crate) struct Recorder(mpsc::UnboundedSender<Job>);

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recorder").finish_non_exhaustive()
    }
}

impl Recorder {
    /// Starts it on the present runtime. When it is dropped the recordings are completed.
    pub(crate) fn start(
        store: Arc<dyn RecordingStore>,
        lines: Vec<Arc<FrameRing>>,
        report: impl Fn(ArmId, RecordReport) + Send + 'static,
    ) -> Self {
        let (orders, mut inbox) = mpsc::unbounded_channel();
        if !KEEPS {
            return Self(orders);
        }
        tokio::spawn(async move {
            let mut files = Files {
                store,
                lines,
                open: BTreeMap::new(),
            };
            let mut jobs = Vec::new();
            // A disk that is slow is asked for all that has come meanwhile.
            while inbox.recv_many(&mut jobs, usize::MAX).await > 0 {
                let batch = std::mem::take(&mut jobs);
                let quick = { batch.iter() }
                    .all(|job| matches!(job, Job::Order(_, RecordOrder::Sample(_))));
                let reports;
                if quick && files.can_wait(&batch) {
                    reports = files.carry_out(batch);
                } else {
                    let done = crate::engine::beside(move || {
                        let reports = files.carry_out(batch);
                        (files, reports)
                    });
                    let Ok(done) = done.await else { return };
                    (files, reports) = done;
                }
                reports
                    .into_iter()
                    .for_each(|(arm, told)| report(arm, told));
            }
            let _ = crate::engine::beside(move || drop(files)).await;
        });
        Self(orders)
    }

    pub(crate) fn order(&self, arm: ArmId, order: RecordOrder) {
        // It ends with the station.
        let _ = self.0.send(Job::Order(arm, order));
    }

    /// Completes all recordings.
    pub(crate) fn close(&self) -> oneshot::Receiver<()> {
        let (done, closed) = oneshot::channel();
        let _ = self.0.send(Job::Close(done));
        closed
    }
}

struct Files {
    store: Arc<dyn RecordingStore>,
    /// Of the arms, where somebody listens.
    lines: Vec<Arc<FrameRing>>,
    open: BTreeMap<ArmId, Open>,
}

struct Open {
    file: Box<dyn RecordingFile>,
    /// What is not written yet.
    samples: Vec<Sample>,
    /// When it was flushed last, Unix seconds.
    flushed: f64,
    /// The line, and how far it is written.
    line: Option<(Arc<FrameRing>, Mark)>,
}

/// Writes readings, and what passed on the line, in the order of their times.
fn put(
    file: &mut dyn RecordingFile,
    samples: impl IntoIterator<Item = Sample>,
    passed: Vec<PassedBytes>,
    line: Option<&FrameRing>,
) -> io::Result<()> {
    let mut passed = passed.into_iter().peekable();
    let (name, unix) = match line {
        Some(line) => (line.line(), Some(|at| line.unix(at))),
        None => ("", None),
    };
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
    before(file, f64::INFINITY)
}

impl Open {
    /// Writes what waits.
    fn put(&mut self) -> io::Result<()> {
        let file = &mut *self.file;
        let mut passed = Vec::new();
        if let Some((line, mark)) = &mut self.line {
            let missed;
            (passed, *mark, missed) = line.since(mark);
            if missed > 0 {
                let words = format!("{missed} pieces of the line are missing here");
                file.note(self.flushed, true, &words)?;
            }
        }
        let line = self.line.as_ref().map(|(line, _)| &**line);
        put(file, self.samples.drain(..), passed, line)
    }

    fn is_due(&self, t: f64) -> bool {
        t - self.flushed >= FLUSH
    }

    fn add(&mut self, sample: Sample) -> io::Result<()> {
        let due = self.is_due(sample.t);
        self.samples.push(sample);
        if due {
            self.put()?;
            self.flushed = sample.t;
            self.file.flush()?;
        }
        Ok(())
    }

    fn note(&mut self, note: &Note) -> io::Result<()> {
        self.put()?;
        self.file.note(note.t, note.warning, &note.words)?;
        self.file.flush()
    }

    fn end(mut self) -> io::Result<u64> {
        self.put()?;
        self.file.finish()
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        self.close();
    }
}

impl Files {
    /// Whether nothing of it has to be written to a file at once.
    fn can_wait(&self, jobs: &[Job]) -> bool {
        jobs.iter().all(|job| match job {
            Job::Order(arm, RecordOrder::Sample(sample)) => {
                { self.open.get(arm) }.is_none_or(|open| !open.is_due(sample.t))
            }
            _ => false,
        })
    }

    fn carry_out(&mut self, jobs: Vec<Job>) -> Vec<(ArmId, RecordReport)> {
        let mut reports = Vec::new();
        for job in jobs {
            match job {
                Job::Order(arm, order) => {
                    reports.extend(self.obey(arm, order).map(|told| (arm, told)));
                }
                Job::Close(done) => {
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

    fn obey(&mut self, arm: ArmId, order: RecordOrder) -> Option<RecordReport> {
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
                    file.flush()?;
                    Ok(file)
                });
                let outcome = begun.map(|file| {
                    let line = self.lines.get(arm.0 as usize);
                    let open = Open {
                        line: line.map(|line| (Arc::clone(line), line.mark())),
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
                return done(request, open.map_or_else(lost, Open::end));
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
                let mut passed = line.map_or_else(Vec::new, |line| line.since(&Mark::default()).0);
                if let Some(line) = line {
                    passed.retain(|piece| line.unix(piece.at) >= from);
                }
                let first = { samples.iter().map(|sample| sample.t) }
                    .chain(notes.iter().map(|note| note.t))
                    .chain(
                        line.iter()
                            .flat_map(|line| passed.first().map(|piece| line.unix(piece.at))),
                    );
                // Whichever was first.
                let epoch = first.fold(f64::INFINITY, f64::min);
                let epoch = if epoch.is_finite() { epoch } else { from };
                let saved = self.store.begin(&name, epoch, rate).and_then(|mut file| {
                    put(&mut *file, samples, passed, line.map(|line| &**line))?;
                    for note in &notes {
                        file.note(note.t, note.warning, &note.words)?;
                    }
                    file.finish()
                });
                return done(request, saved);
            }
            RecordOrder::Sample(sample) => self.open.get_mut(&arm)?.add(*sample),
            RecordOrder::Note(note) => self.open.get_mut(&arm)?.note(&note),
        };
        let error = wrote.err()?;
        self.open.remove(&arm);
        Some(RecordReport::Lost(error.to_string()))
    }
}
