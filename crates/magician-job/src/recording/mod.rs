//! Recording of an arm that is moved by hand, by its keys, or by another program.
//!
//! A [`Recorder`] runs as a task. A reading is in the file within a second, even if the program
//! then dies.

mod error;
mod program;
mod readings;
mod reference_tool;
mod sink;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant, SystemTime};

use magician::commands::{DeviceTime, EndEffectorParams, Pose};
use magician::protocol::AlarmSet;
use magician::{Arm, Event, Events, Link, Sample, Samples, StateWatch, Status};
use magician_program::{Surface, Tool};
use magician_record::Reading;
use serde::Serialize;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval, timeout};

pub use error::RecordError;
use error::unwritable;
use reference_tool::{ReferenceTool, with_tool};
pub use sink::Format;
use sink::{RecordingStart, Sink};

/// Interval at which readings are flushed to the file.
const FLUSH_INTERVAL: Duration = Duration::from_secs(1);
/// Deadline for the last reading: an arm that no longer answers must not hold up the end.
const LAST_READING_TIMEOUT: Duration = Duration::from_millis(500);

/// Options of a recording.
#[derive(Clone, Debug)]
pub struct Options {
    /// Start time, written into files of readings.
    pub began: SystemTime,
    /// Rate of readings, Hz.
    pub rate: f64,
    /// Largest distance between a recorded program and the motion, mm.
    pub tolerance: f64,
    /// Clock for the times of readings.
    pub clock: Clock,
    /// Counter of the steps of a running program.
    pub steps: Option<Arc<AtomicU64>>,
    /// True if a CSV file gets a second line with units.
    pub units: bool,
    /// Paper plane, if a pen is mounted: a file for Foxglove then shows the drawing.
    pub paper: Option<Surface>,
}

/// Clock for the times of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// This computer's clock.
    Host,
    /// The arm's clock, at the cost of one more request for each reading: for a virtual arm that
    /// runs faster than real time. If its clock leaps, the arm is sampled along its motion
    /// ([`Arm::samples`]).
    Arm,
}

impl Options {
    /// Options for readings by the host's clock from `began` on at `rate` Hz, and programs within
    /// 0.5 mm of the motion.
    #[must_use]
    pub const fn new(began: SystemTime, rate: f64) -> Self {
        Self {
            began,
            rate,
            tolerance: 0.5,
            clock: Clock::Host,
            steps: None,
            units: false,
            paper: None,
        }
    }
}

/// Progress of a recording.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordingProgress {
    /// Time of the last reading, s.
    pub seconds: f64,
    /// Readings so far.
    pub readings: u64,
    /// Last x, y, z (mm) and r (deg).
    pub pose: [f32; 4],
    /// Speed of the tool, mm/s.
    pub speed: f64,
    /// Length of the tool's path so far, mm.
    pub length: f64,
}

/// Result of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Path of the file.
    pub file: PathBuf,
    /// Format of the file.
    pub format: Format,
    /// Time of the last reading, s.
    pub seconds: f64,
    /// Readings taken.
    pub readings: u64,
    /// Length of the tool's path, mm.
    pub length: f64,
    /// Number of steps, if the recording is a program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
}

/// An arm being recorded. Dropping the recorder ends the recording; [`finish`](Self::finish) takes
/// a last reading first and returns the result.
///
/// ```
/// use std::time::SystemTime;
///
/// use magician::{Arm, build};
/// use magician_job::recording::{Options, Recorder};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let place = tempfile::tempdir()?;
/// # let path = place.path().join("day.csv");
/// let arm = Arm::connect("sim").await?;
/// let recorder = Recorder::begin(&arm, &path, Options::new(SystemTime::now(), 20.0)).await?;
/// arm.run(&[build::move_to(220.0, 40.0, 20.0, 0.0)]).await?;
/// let summary = recorder.finish().await?;
/// assert!(summary.readings >= 1);
/// # Ok(())
/// # }
/// ```
pub struct Recorder {
    progress: watch::Receiver<RecordingProgress>,
    /// A message asks the task for a last reading; dropping the sender ends it at once.
    stop: oneshot::Sender<()>,
    task: JoinHandle<Result<Summary, RecordError>>,
}

impl Recorder {
    /// Starts a recording; must be called within a runtime, which does its reads and writes. The
    /// extension of `path` selects the format; an existing file is replaced.
    ///
    /// # Errors
    /// [`RecordError`] for a bad name, a file that cannot be written, or an arm that does not
    /// answer.
    pub async fn begin(arm: &Arm, path: &Path, options: Options) -> Result<Self, RecordError> {
        let format = Format::of(path)?;
        let (_, places) = arm.stats().await?;
        let bias: EndEffectorParams = arm.get().await?;
        let (clock, samples) = match options.clock {
            Clock::Arm => {
                let clock = arm.get::<DeviceTime>().await?.g_systick;
                (Some(clock), arm.samples(options.rate))
            }
            Clock::Host => (None, None),
        };
        let tool = Tool::from(&bias);
        let sink = format.open(
            path,
            &RecordingStart {
                began: options.began,
                rate: options.rate,
                tolerance: options.tolerance,
                tool,
                counts_steps: options.steps.is_some(),
                units: options.units,
                paper: options.paper,
            },
        )?;
        let (tell, progress) = watch::channel(RecordingProgress::default());
        let (stop, stopped) = oneshot::channel();
        let work = RecordingTask {
            state: arm.state(options.rate)?,
            events: arm.events(),
            arm: arm.clone(),
            clock,
            samples,
            steps: options.steps,
            started: Instant::now(),
            places,
            reference_tool: ReferenceTool::new(tool),
            sink,
            last: None,
            progress: tell,
            line_error: None,
        };
        let summary = Summary {
            file: path.to_owned(),
            format,
            seconds: 0.0,
            readings: 0,
            length: 0.0,
            steps: None,
        };
        let task = tokio::spawn(work.run(stopped, summary));
        Ok(Self {
            progress,
            stop,
            task,
        })
    }

    /// Current progress.
    #[must_use]
    pub fn progress(&self) -> RecordingProgress {
        *self.progress.borrow()
    }

    /// Function that returns the current progress, for another thread. It keeps working after the
    /// end.
    pub fn progress_reader(&self) -> impl Fn() -> RecordingProgress + Send + Sync + use<> {
        let progress = self.progress.clone();
        move || *progress.borrow()
    }

    /// Waits until the recording ends by itself, which happens only after an error.
    pub async fn failed(&mut self) -> RecordError {
        match (&mut self.task).await {
            Ok(Err(error)) => error,
            Ok(Ok(_)) => RecordError::TaskFailed("a recording ended by itself".to_owned()),
            Err(panic) => RecordError::TaskFailed(panic.to_string()),
        }
    }

    /// Takes a last reading and completes the file.
    ///
    /// # Errors
    /// [`RecordError`], including an earlier error that ended the recording.
    pub async fn finish(self) -> Result<Summary, RecordError> {
        // Fails if the task has ended already; its error is returned below.
        let _ = self.stop.send(());
        match self.task.await {
            Ok(outcome) => outcome,
            Err(panic) => Err(RecordError::TaskFailed(panic.to_string())),
        }
    }
}

/// Values read from the arm.
struct StateReading {
    pose: Pose,
    index: u64,
    left_space: u32,
    alarms: AlarmSet,
}

/// State of the recording task.
struct RecordingTask {
    state: StateWatch,
    events: Events,
    arm: Arm,
    /// Arm's clock at the start, if times follow it.
    clock: Option<u32>,
    /// Samples of a virtual arm whose clock leaps: then all readings come from here.
    samples: Option<Samples>,
    steps: Option<Arc<AtomicU64>>,
    started: Instant,
    places: u32,
    reference_tool: ReferenceTool,
    sink: Box<dyn Sink>,
    /// Last reading, and the tool that its pose refers to.
    last: Option<(Instant, Reading, Tool)>,
    progress: watch::Sender<RecordingProgress>,
    /// Cause of a lost line.
    line_error: Option<Arc<str>>,
}

impl RecordingTask {
    async fn run(
        mut self,
        stopped: oneshot::Receiver<()>,
        summary: Summary,
    ) -> Result<Summary, RecordError> {
        let outcome = self.record(stopped).await;
        // Complete the file even after an error: earlier readings are valid.
        let finished = self.sink.finish();
        outcome?;
        let RecordingProgress {
            seconds,
            readings,
            length,
            ..
        } = *self.progress.borrow();
        Ok(Summary {
            seconds: (seconds * 1000.0).round() / 1000.0,
            readings,
            length: (length * 100.0).round() / 100.0,
            steps: finished?,
            ..summary
        })
    }

    async fn record(&mut self, mut stopped: oneshot::Receiver<()>) -> Result<(), RecordError> {
        let mut flushes = interval(FLUSH_INTERVAL);
        // After a delay flush once, not once for each missed interval.
        flushes.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                // The end first: a busy arm must not delay it.
                biased;
                stopped_by = &mut stopped => {
                    if let Some(samples) = &self.samples {
                        samples.take();
                        return self.store_samples(None);
                    }
                    if stopped_by.is_ok() {
                        // Ignored if it fails: an arm that stopped answering has nothing to add.
                        let _ = timeout(LAST_READING_TIMEOUT, self.take_reading()).await;
                    }
                    return Ok(());
                }
                Some(event) = self.events.next() => self.note(&event)?,
                Some(sample) = next(&mut self.samples) => self.store_samples(Some(sample))?,
                _ = flushes.tick() => self.sink.flush()?,
                status = self.state.changed() => match status {
                    Ok(status) => self.note_status(&status).await?,
                    Err(_) => return Err(self.lost()),
                },
            }
        }
    }

    fn note(&mut self, event: &Event) -> Result<(), RecordError> {
        if let Event::LinkLost { why } = event {
            self.line_error = Some(why.clone());
        }
        let t = match &self.samples {
            Some(_) => self.progress.borrow().seconds,
            None => self.started.elapsed().as_secs_f64(),
        };
        self.sink.note(t, event)
    }

    async fn note_status(&mut self, status: &Status) -> Result<(), RecordError> {
        match &status.link {
            Link::Up => {}
            // The driver is searching for the line; readings continue once it is back.
            Link::Lost { sought: true, .. } => return Ok(()),
            Link::Lost { why, .. } => {
                self.line_error = Some(why.clone());
                return Err(self.lost());
            }
            // An unknown state of the link: nothing more can be recorded.
            _ => return Err(self.lost()),
        }
        if let Some(samples) = &self.samples {
            // Take samples at the rate of the wall clock even if the arm's clock stands.
            samples.take();
            return Ok(());
        }
        // When a line is found again, the last reading is delivered a second time.
        if self.last.is_some_and(|(at, ..)| at == status.at) {
            return Ok(());
        }
        let state = StateReading {
            pose: status.pose,
            index: status.current.0,
            left_space: status.left_space,
            alarms: status.alarms,
        };
        self.store(status.at, state).await
    }

    /// Takes one more reading of the arm.
    async fn take_reading(&mut self) -> Result<(), RecordError> {
        let at = Instant::now();
        let state = StateReading {
            pose: self.arm.get().await?,
            index: self.arm.queue().current_index().await?.0,
            left_space: self.arm.queue().left_space().await?,
            alarms: self.arm.alarms().await?,
        };
        self.store(at, state).await
    }

    async fn store(&mut self, at: Instant, state: StateReading) -> Result<(), RecordError> {
        let Some(tool) = self.reference_tool.of(&state.pose, &self.arm).await else {
            // Skip a reading whose tool is unknown.
            return Ok(());
        };
        let t = match self.clock {
            Some(started) => {
                let now = self.arm.get::<DeviceTime>().await?.g_systick;
                f64::from(now.wrapping_sub(started)) / 1000.0
            }
            None => at.saturating_duration_since(self.started).as_secs_f64(),
        };
        self.write(at, t, &state, tool)
    }

    /// Writes this sample and all others that are ready.
    fn store_samples(&mut self, first: Option<Sample>) -> Result<(), RecordError> {
        let mut coming = first;
        while let Some(sample) = coming.take().or_else(|| self.samples.as_mut()?.ready()) {
            let state = StateReading {
                pose: sample.pose,
                index: sample.index,
                left_space: sample.left_space,
                alarms: sample.alarms,
            };
            self.write(Instant::now(), sample.t, &state, Tool::from(&sample.bias))?;
        }
        Ok(())
    }

    fn write(
        &mut self,
        at: Instant,
        t: f64,
        state: &StateReading,
        tool: Tool,
    ) -> Result<(), RecordError> {
        let steps = self.steps.as_ref();
        let reading = Reading {
            t,
            step: steps.map(|steps| steps.load(Ordering::Relaxed)),
            pose: state.pose,
            rail: None,
            index: state.index,
            left_space: state.left_space,
            capacity: self.places,
            alarms: state.alarms,
        };
        self.sink.write(&reading, tool)?;
        self.update_progress(&reading, tool);
        self.last = Some((at, reading, tool));
        Ok(())
    }

    fn update_progress(&self, reading: &Reading, tool: Tool) {
        let (distance, seconds) = match &self.last {
            Some((_, last, was)) => {
                let from = with_tool(&last.pose, *was, tool);
                (distance(&from, &reading.pose), reading.t - last.t)
            }
            None => (0.0, 0.0),
        };
        self.progress.send_modify(|progress| {
            *progress = RecordingProgress {
                seconds: reading.t,
                readings: progress.readings + 1,
                pose: [
                    reading.pose.x,
                    reading.pose.y,
                    reading.pose.z,
                    reading.pose.r,
                ],
                speed: if seconds > 0.0 {
                    distance / seconds
                } else {
                    0.0
                },
                length: progress.length + distance,
            };
        });
    }

    /// Error for a lost line.
    fn lost(&self) -> RecordError {
        let RecordingProgress {
            seconds, readings, ..
        } = *self.progress.borrow();
        RecordError::Lost {
            seconds,
            readings,
            why: self.line_error.clone(),
        }
    }
}

/// Next sample; never resolves if none are taken.
async fn next(samples: &mut Option<Samples>) -> Option<Sample> {
    match samples {
        Some(samples) => samples.next().await,
        None => std::future::pending().await,
    }
}

/// Distance between two poses, mm.
fn distance(a: &Pose, b: &Pose) -> f64 {
    let difference = |a: f32, b: f32| f64::from(b) - f64::from(a);
    let [x, y, z] = [
        difference(a.x, b.x),
        difference(a.y, b.y),
        difference(a.z, b.z),
    ];
    (x * x + y * y + z * z).sqrt()
}
