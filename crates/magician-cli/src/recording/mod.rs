//! Records an arm that is moved by hand, by its keys, or by another program.
//!
//! A [`Recorder`] has a task of its own. What it has seen is in the file within a second, whatever becomes of this program.

mod counted;
mod program;
mod readings;
mod sink;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use magician::commands::{DeviceTime, EndEffectorParams, Pose};
use magician::protocol::AlarmSet;
use magician::{Arm, ErrorKind, Event, Events, Link, StateWatch, Status};
use magician_program::Tool;
use magician_record::Reading;
use serde::Serialize;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval, timeout};

use crate::failure::{Failure, Kind};
use crate::mounted::tool_of;
use counted::{Counted, recounted};
pub(crate) use sink::Format;
use sink::{Beginning, Sink};

/// What was recorded is in the file so often.
const FLUSH: Duration = Duration::from_secs(1);
/// How long an arm has to tell how it stands in the end.
const LAST_LOOK: Duration = Duration::from_millis(500);

/// How an arm is recorded.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    /// Readings a second.
    pub(crate) rate: f64,
    /// How far a program may be from the motion, mm.
    pub(crate) tolerance: f64,
    /// Whose clock counts.
    pub(crate) clock: Clock,
    /// Where the steps of a running program are counted.
    pub(crate) steps: Option<Arc<AtomicU64>>,
}

/// Whose clock counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// This computer's.
    Host,
    /// The arm's, which costs one more read for each reading: for a virtual one that runs faster.
    Arm,
}

impl Options {
    pub(crate) fn at(rate: f64) -> Self {
        Self {
            rate,
            tolerance: 0.5,
            clock: Clock::Host,
            steps: None,
        }
    }
}

/// How far a recording is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    /// Time of the last reading, s.
    pub(crate) seconds: f64,
    pub(crate) readings: u64,
    /// x, y, z, r.
    pub(crate) pose: [f32; 4],
    /// Speed of the tool, mm/s.
    pub(crate) speed: f64,
    /// Way of the tool, mm.
    pub(crate) length: f64,
}

/// What a recording has come to.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) file: PathBuf,
    pub(crate) format: Format,
    pub(crate) seconds: f64,
    pub(crate) readings: u64,
    /// Way of the tool, mm.
    pub(crate) length: f64,
    /// Steps of the program, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) steps: Option<usize>,
}

/// An arm being recorded. Dropping it ends that; [`finish`](Self::finish) also completes the file.
pub(crate) struct Recorder {
    tally: watch::Receiver<Tally>,
    /// Told, the task takes a last look; dropped, it ends at once.
    stop: oneshot::Sender<()>,
    task: JoinHandle<Result<Summary, Failure>>,
}

impl Recorder {
    /// Begins; must be called within a runtime. The end of the file's name says what it is.
    pub(crate) async fn begin(arm: &Arm, path: &Path, options: Options) -> Result<Self, Failure> {
        let format = Format::of(path)?;
        let (_, places) = arm.stats().await?;
        let bias: EndEffectorParams = arm.get().await?;
        let clock = match options.clock {
            Clock::Arm => Some(arm.get::<DeviceTime>().await?.g_systick),
            Clock::Host => None,
        };
        let tool = tool_of(&bias);
        let sink = format.open(
            path,
            &Beginning {
                rate: options.rate,
                tolerance: options.tolerance,
                tool,
                counts_steps: options.steps.is_some(),
            },
        )?;
        let (tell, tally) = watch::channel(Tally::default());
        let (stop, stopped) = oneshot::channel();
        let work = Work {
            state: arm.state(options.rate)?,
            events: arm.events(),
            arm: arm.clone(),
            clock,
            steps: options.steps,
            begun: Instant::now(),
            places,
            counted: Counted::new(tool),
            sink,
            last: None,
            tally: tell,
            broke: None,
        };
        let summary = Summary {
            file: path.to_owned(),
            format,
            seconds: 0.0,
            readings: 0,
            length: 0.0,
            steps: None,
        };
        let task = tokio::spawn(work.go_on(stopped, summary));
        Ok(Self { tally, stop, task })
    }

    /// How far it is.
    pub(crate) fn tally(&self) -> Tally {
        *self.tally.borrow()
    }

    /// Waits until it ends by itself, which is because it cannot go on.
    pub(crate) async fn failed(&mut self) -> Failure {
        match (&mut self.task).await {
            Ok(Err(failure)) => failure,
            Ok(Ok(_)) => Failure::new(Kind::Bug, "a recording ended by itself"),
            Err(panic) => Failure::new(Kind::Bug, panic.to_string()),
        }
    }

    /// Completes the file.
    pub(crate) async fn finish(self) -> Result<Summary, Failure> {
        // A recording that ended before has an error to report.
        let _ = self.stop.send(());
        match self.task.await {
            Ok(outcome) => outcome,
            Err(panic) => Err(Failure::new(Kind::Bug, panic.to_string())),
        }
    }
}

/// What was read of the arm.
struct Seen {
    pose: Pose,
    index: u64,
    left_space: u32,
    alarms: AlarmSet,
}

/// The task.
struct Work {
    state: StateWatch,
    events: Events,
    arm: Arm,
    /// What the arm's clock showed at the beginning, if it counts.
    clock: Option<u32>,
    steps: Option<Arc<AtomicU64>>,
    begun: Instant,
    places: u32,
    counted: Counted,
    sink: Box<dyn Sink>,
    /// The reading before, and the tool that its pose is counted for.
    last: Option<(Instant, Reading, Tool)>,
    tally: watch::Sender<Tally>,
    /// Why there is no line.
    broke: Option<Arc<str>>,
}

impl Work {
    async fn go_on(
        mut self,
        stopped: oneshot::Receiver<()>,
        summary: Summary,
    ) -> Result<Summary, Failure> {
        let outcome = self.record(stopped).await;
        // What there is is completed, however it came to its end.
        let finished = self.sink.finish();
        outcome?;
        let Tally {
            seconds,
            readings,
            length,
            ..
        } = *self.tally.borrow();
        Ok(Summary {
            seconds: (seconds * 1000.0).round() / 1000.0,
            readings,
            length: (length * 100.0).round() / 100.0,
            steps: finished?,
            ..summary
        })
    }

    async fn record(&mut self, mut stopped: oneshot::Receiver<()>) -> Result<(), Failure> {
        let mut flushes = interval(FLUSH);
        flushes.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                biased;
                told = &mut stopped => {
                    if told.is_ok() {
                        // An arm that says nothing any more has said all.
                        let _ = timeout(LAST_LOOK, self.look()).await;
                    }
                    return Ok(());
                }
                Some(event) = self.events.next() => self.note(&event)?,
                _ = flushes.tick() => self.sink.flush()?,
                status = self.state.changed() => match status {
                    Ok(status) => self.see(&status).await?,
                    Err(_) => return Err(self.lost()),
                },
            }
        }
    }

    fn note(&mut self, event: &Event) -> Result<(), Failure> {
        if let Event::LinkLost { why } = event {
            self.broke = Some(why.clone());
        }
        self.sink.note(
            self.begun.elapsed().as_secs_f64(),
            event,
            &event.to_string(),
        )
    }

    async fn see(&mut self, status: &Status) -> Result<(), Failure> {
        match &status.link {
            Link::Up => {}
            Link::Lost { sought: true, .. } => return Ok(()),
            Link::Lost { why, .. } => {
                self.broke = Some(why.clone());
                return Err(self.lost());
            }
            _ => return Err(self.lost()),
        }
        // A line that was found tells the reading before once more.
        if self.last.is_some_and(|(at, ..)| at == status.at) {
            return Ok(());
        }
        let seen = Seen {
            pose: status.pose,
            index: status.current.0,
            left_space: status.left_space,
            alarms: status.alarms,
        };
        self.keep(status.at, seen).await
    }

    /// Reads the arm once more.
    async fn look(&mut self) -> Result<(), Failure> {
        let at = Instant::now();
        let seen = Seen {
            pose: self.arm.get().await?,
            index: self.arm.current_index().await?.0,
            left_space: self.arm.left_space().await?,
            alarms: self.arm.alarms().await?,
        };
        self.keep(at, seen).await
    }

    async fn keep(&mut self, at: Instant, seen: Seen) -> Result<(), Failure> {
        let Some(tool) = self.counted.of(&seen.pose, &self.arm).await else {
            // It is unknown which tool the pose is for.
            return Ok(());
        };
        let t = match self.clock {
            Some(begun) => {
                let now = self.arm.get::<DeviceTime>().await?.g_systick;
                f64::from(now.wrapping_sub(begun)) / 1000.0
            }
            None => at.saturating_duration_since(self.begun).as_secs_f64(),
        };
        let steps = self.steps.as_ref();
        let reading = Reading {
            t,
            step: steps.map(|steps| steps.load(Ordering::Relaxed)),
            pose: seen.pose,
            rail: None,
            index: seen.index,
            left_space: seen.left_space,
            capacity: self.places,
            alarms: seen.alarms,
        };
        self.sink.write(&reading, tool)?;
        self.count(&reading, tool);
        self.last = Some((at, reading, tool));
        Ok(())
    }

    fn count(&self, reading: &Reading, tool: Tool) {
        let (way, seconds) = match &self.last {
            Some((_, last, was)) => {
                let from = recounted(&last.pose, *was, tool);
                (way(&from, &reading.pose), reading.t - last.t)
            }
            None => (0.0, 0.0),
        };
        self.tally.send_modify(|tally| {
            *tally = Tally {
                seconds: reading.t,
                readings: tally.readings + 1,
                pose: [
                    reading.pose.x,
                    reading.pose.y,
                    reading.pose.z,
                    reading.pose.r,
                ],
                speed: if seconds > 0.0 { way / seconds } else { 0.0 },
                length: tally.length + way,
            };
        });
    }

    /// The line is gone, and with it what was to be recorded.
    fn lost(&self) -> Failure {
        let Tally {
            seconds, readings, ..
        } = *self.tally.borrow();
        let why = self.broke.as_deref().unwrap_or("it was closed");
        let message = format!("lost the line to the arm after {seconds:.1} s: {why}");
        Failure::new(Kind::Driver(ErrorKind::Port), message)
            .hint(format!("the {readings} readings before that are kept"))
    }
}

/// From one pose to the next, mm.
fn way(a: &Pose, b: &Pose) -> f64 {
    let apart = |a: f32, b: f32| f64::from(b) - f64::from(a);
    let [x, y, z] = [apart(a.x, b.x), apart(a.y, b.y), apart(a.z, b.z)];
    (x * x + y * y + z * z).sqrt()
}
