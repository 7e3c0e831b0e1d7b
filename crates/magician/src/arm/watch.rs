//! Waiting: by index, with an eye on alarms and on an arm that stands still.

use std::time::Duration;

use magician_host::picture::QueuedPace;
use magician_protocol::commands::{Pose, PoseL, QueuedCmdCurrentIndex};
use tokio::time::{Instant, sleep};

use super::Arm;
use crate::{Action, Error, ErrorCode, QueueIndex, Result};

/// How soon the first look follows, and how far apart looks are at most.
pub(super) const FIRST_PAUSE: Duration = Duration::from_millis(2);
const PAUSE: Duration = Duration::from_millis(50);
/// A queue whose index stands so long, with an arm that stands still, is looked into.
pub(super) const STANDING: Duration = Duration::from_millis(1500);
/// Nothing but homing, waits and triggers takes longer than this without a movement.
const STUCK: Duration = Duration::from_secs(15);
/// How long a queue may be at rest that this program has not started: another one may start it. A longer wait asks
/// anew.
const GRACE: Duration = Duration::from_secs(5);
/// Longest homing, and longest command of another program's (model section 11: 25 s).
const LONG: Duration = Duration::from_secs(60);

/// How far a wait or a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Index of the command that finished last.
    pub current: QueueIndex,
    /// Index of the last command that was put into the queue, or that is waited for.
    pub last: QueueIndex,
    /// Commands this run has put into the queue.
    pub sent: u64,
    /// Commands this run has in all, when it is known.
    pub total: Option<u64>,
    /// How long the arm has not answered while a run waits for it; zero as long as it answers. It grows up to
    /// [`RunOptions::patience`](crate::RunOptions::patience).
    pub silent: Duration,
}

/// What a wait has seen so far.
#[derive(Debug)]
pub(super) struct Watch {
    progress: Progress,
    /// When the index, or the pose, changed last.
    changed: Instant,
    /// Where the arm was seen, and the rail.
    pose: Option<(Pose, Option<PoseL>)>,
    /// The index stands for so long by itself.
    lasts: Duration,
    /// Stops before it began.
    stops: u64,
    /// A stream counts what is in the queue, and may have emptied it to go on from further back.
    counted: bool,
}

impl Watch {
    pub(super) fn new(total: Option<u64>, stops: u64) -> Self {
        Self {
            lasts: Duration::ZERO,
            stops,
            counted: false,
            progress: Progress {
                current: magician_protocol::QueuedCmdIndex(0),
                last: magician_protocol::QueuedCmdIndex(0),
                sent: 0,
                total,
                silent: Duration::ZERO,
            },
            changed: Instant::now(),
            pose: None,
        }
    }

    /// Of what a stream puts into the queue.
    pub(super) fn of_stream(self) -> Self {
        Self {
            counted: true,
            ..self
        }
    }

    /// Its only command takes so long.
    pub(super) fn lasts(&mut self, time: Duration) {
        self.lasts = time;
    }

    pub(super) fn sent(&mut self, sent: u64, last: Option<QueueIndex>) {
        self.progress.sent = sent;
        self.progress.last = last.unwrap_or(self.progress.last);
    }

    /// The index of the command that finished last was read.
    pub(super) fn saw(&mut self, current: u64) -> Progress {
        if current != self.progress.current.0 {
            self.progress.current.0 = current;
            self.changed();
        }
        self.progress
    }

    /// As it was seen last.
    pub(super) fn progress(&self) -> Progress {
        self.progress
    }

    /// Everything has finished.
    pub(super) fn at_its_end(&mut self) -> Progress {
        self.progress.current = self.progress.last;
        self.progress
    }

    /// What is watched is not over because of a stop.
    pub(super) fn not_stopped(&self, arm: &Arm) -> Result<()> {
        arm.queue_fault(Some(self.stops))?;
        if arm.stops() == self.stops {
            return Ok(());
        }
        let message = "stopped; unfinished commands were dropped";
        Err(Error::new(ErrorCode::Stopped, message))
    }

    /// It moves, or has to stand for now.
    pub(super) fn changed(&mut self) {
        self.changed = Instant::now();
        self.pose = None;
    }
}

/// Looks.
impl Watch {
    pub(super) async fn until(
        &mut self,
        arm: &Arm,
        index: QueueIndex,
        progress: &mut impl FnMut(Progress),
    ) -> Result<()> {
        let mut pause = FIRST_PAUSE;
        loop {
            let seen = self.look(arm).await?;
            progress(seen);
            if seen.current >= index {
                return Ok(());
            }
            sleep(pause).await;
            pause = (pause * 2).min(PAUSE);
        }
    }

    /// One look at the queue, the alarms and, when the index stands, the arm.
    pub(super) async fn look(&mut self, arm: &Arm) -> Result<Progress> {
        let read = arm.get::<QueuedCmdCurrentIndex>().await?;
        self.look_from(arm, read.queued_cmd_current_index).await
    }

    /// As [`look`](Self::look), when the current index has been read already.
    pub(super) async fn look_from(&mut self, arm: &Arm, current: u64) -> Result<Progress> {
        arm.queue_fault(Some(self.stops))?;
        let progress = self.saw(current);
        if progress.current >= progress.last {
            return Ok(progress);
        }
        self.not_stopped(arm)?;
        let pace = arm.picture().own().running(current);
        let alarms = arm.alarms().await?;
        if alarms.blocking() && pace != Some(QueuedPace::Home) {
            // The command may have finished before the alarm was raised.
            let again = arm.queue().current_index().await?;
            if again >= progress.last {
                self.progress.current = again;
                return Ok(self.progress);
            }
            return Err(arm.stopped_by(alarms).await);
        }
        if self.changed.elapsed() >= self.lasts.saturating_add(STANDING) {
            self.look_closer(arm, pace).await?;
        }
        Ok(progress)
    }

    /// The index stands: does the arm?
    async fn look_closer(&mut self, arm: &Arm, pace: Option<QueuedPace>) -> Result<()> {
        if !self.counted {
            self.still_queued(arm).await?;
        }
        let rail = match pace {
            Some(QueuedPace::Rail) => Some(arm.get::<PoseL>().await?),
            _ => None,
        };
        let pose = (arm.get::<Pose>().await?, rail);
        let before = self.pose.replace(pose);
        if before != Some(pose) {
            if before.is_some() {
                self.changed();
            }
            return Ok(());
        }
        let (started, stopped) = {
            let picture = arm.picture();
            let motion = picture.motion();
            (motion.started() == Some(true), motion.stopped())
        };
        // What a stream puts into a queue that stands is started by it.
        let grace = if started || self.counted {
            STUCK
        } else {
            GRACE
        };
        let patience = match pace {
            Some(QueuedPace::Home) => LONG,
            Some(QueuedPace::Motor(time)) if stopped => time,
            // Waits and triggers are cut short by a stop.
            _ if stopped => STANDING,
            Some(QueuedPace::Trigger) => return Ok(()),
            Some(QueuedPace::Motion | QueuedPace::Rail) if started => {
                return self.confirm_hold(arm).await;
            }
            Some(QueuedPace::Motion | QueuedPace::Rail | QueuedPace::Moment) => grace,
            Some(QueuedPace::Pause(time) | QueuedPace::Motor(time)) => time.saturating_add(grace),
            None => LONG,
        };
        if self.changed.elapsed() < patience {
            return Ok(());
        }
        let hint = match (stopped, started) {
            (true, _) => ", and its queue is stopped",
            (_, true) => " and the arm stands still",
            _ => " and the arm stands still; its queue was not started, or is stopped",
        };
        let message = format!(
            "waiting for queue index {}: it stays at {}{hint}",
            self.progress.last.0, self.progress.current.0
        );
        Err(match (stopped, started) {
            (false, true) => Error::new(ErrorCode::NotFinished, message),
            _ => Error::new(ErrorCode::QueueStopped, message)
                .remedy(Action::StartQueue, "lets it continue"),
        })
    }

    /// An empty queue whose index has not come to what is waited for: it was dropped.
    async fn still_queued(&self, arm: &Arm) -> Result<()> {
        let (_, capacity) = arm.stats().await?;
        if arm.queue().left_space().await? < capacity
            || arm.queue().current_index().await? != self.progress.current
        {
            return Ok(());
        }
        let message = format!(
            "queue index {} will not come: the arm's queue is empty and stands at {}; it was \
             cleared, or the arm was reset",
            self.progress.last.0, self.progress.current.0
        );
        Err(Error::new(ErrorCode::Dropped, message))
    }

    /// Two equal poses and a motion that does not run: the hold of an alarm, unless the index moved
    /// in this very moment.
    async fn confirm_hold(&self, arm: &Arm) -> Result<()> {
        if arm.queue().current_index().await? == self.progress.current {
            return Err(Error::held());
        }
        Ok(())
    }
}

impl Arm {
    /// Waits until a queued command has finished.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) as soon as an alarm holds the queue, or when the hold of an alarm that
    /// has gone by itself keeps the arm from moving; [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) when nothing happens for
    /// longer than the commands explain (a trigger explains any time): after 1.5 s in a queue that this handle has
    /// stopped and nothing of it starts again, after 5 s in one that it found as it was, where another program may be
    /// about to start it; else as [`get`](Self::get).
    pub async fn wait(&self, index: QueueIndex) -> Result<()> {
        self.wait_with(index, |_| {}).await
    }

    /// As [`wait`](Self::wait), and tells how far it is.
    ///
    /// # Errors
    /// As [`wait`](Self::wait).
    pub async fn wait_with(
        &self,
        index: QueueIndex,
        mut progress: impl FnMut(Progress),
    ) -> Result<()> {
        let mut watch = Watch::new(None, self.stops());
        watch.sent(0, Some(index));
        watch.until(self, index, &mut progress).await?;
        self.homing().settle().await;
        Ok(())
    }
}
