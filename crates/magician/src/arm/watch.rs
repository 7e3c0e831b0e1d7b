//! Waiting for a queue index, with detection of alarms and of a queue that is stuck.
//!
//! The protocol sends no notification, so a wait polls the current index. An alarm ends it. If the
//! index has not changed for a while, a closer look distinguishes a slow command from a stopped
//! queue, a cleared one, or the hold of an alarm: by the pace that the picture knows of the running
//! command, and by two equal poses.

use std::time::Duration;

use magician_host::picture::QueuedPace;
use magician_protocol::commands::{Pose, PoseL, QueuedCmdCurrentIndex};
use tokio::time::{Instant, sleep};

use super::Arm;
use crate::{Action, Error, ErrorCode, QueueIndex, Result, message};

/// Delay of the first look, and longest interval of the following ones. Choice: a short command is
/// reported soon, and a long wait does not load the line.
pub(super) const FIRST_PAUSE: Duration = Duration::from_millis(2);
const PAUSE: Duration = Duration::from_millis(50);
/// Time without progress after which the queue and the pose are examined. Choice.
pub(super) const STANDING: Duration = Duration::from_millis(1500);
/// Time without motion after which a running command counts as stuck. Only homing, waits and
/// triggers take longer. Choice.
const STUCK_AFTER: Duration = Duration::from_secs(15);
/// Time for which a queue may stand that this connection has not started: another program may start
/// it. A caller that wants to wait longer calls again. Choice.
const GRACE: Duration = Duration::from_secs(5);
/// Longest homing, and longest command of another program. Choice, with margin over the 25 s of a
/// homing (model section 11).
const MAX_COMMAND_TIME: Duration = Duration::from_secs(60);

/// Progress of a wait or a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Index of the command that finished last.
    pub current: QueueIndex,
    /// Index of the last command in the queue, or of the one waited for.
    pub last: QueueIndex,
    /// Commands that this run has put into the queue.
    pub sent: u64,
    /// Number of commands of this run; `None` if unknown.
    pub total: Option<u64>,
    /// Time since the last answer while a run waits for a silent arm; zero while it answers. It
    /// grows up to [`RunOptions::patience`](crate::RunOptions::patience).
    pub silent: Duration,
}

/// State of a wait.
#[derive(Debug)]
pub(super) struct Watch {
    progress: Progress,
    /// Time of the last change of index or pose.
    changed: Instant,
    /// Last pose and rail position.
    pose: Option<(Pose, Option<PoseL>)>,
    /// Expected time without progress, on top of the limits above.
    lasts: Duration,
    /// Stops before the wait began.
    stops: u64,
    /// True for a stream, which counts its commands itself, and may clear the queue to resume from
    /// an earlier command.
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

    /// Marks the wait as one for the commands of a stream.
    pub(super) fn of_stream(self) -> Self {
        Self {
            counted: true,
            ..self
        }
    }

    /// Sets the duration of its only command.
    pub(super) fn lasts(&mut self, time: Duration) {
        self.lasts = time;
    }

    pub(super) fn sent(&mut self, sent: u64, last: Option<QueueIndex>) {
        self.progress.sent = sent;
        self.progress.last = last.unwrap_or(self.progress.last);
    }

    /// Notes the index of the last finished command.
    pub(super) fn saw(&mut self, current: u64) -> Progress {
        if current != self.progress.current.0 {
            self.progress.current.0 = current;
            self.changed();
        }
        self.progress
    }

    /// Returns the progress at the last look.
    pub(super) fn progress(&self) -> Progress {
        self.progress
    }

    /// Returns the progress at the end of all commands.
    pub(super) fn at_its_end(&mut self) -> Progress {
        self.progress.current = self.progress.last;
        self.progress
    }

    /// Returns an error if a stop or a queue fault came since the wait began.
    pub(super) fn not_stopped(&self, arm: &Arm) -> Result<()> {
        arm.queue_fault(Some(self.stops))?;
        if arm.stops() == self.stops {
            return Ok(());
        }
        let message = message!("stopped; unfinished commands were dropped");
        Err(Error::new(ErrorCode::Stopped, message))
    }

    /// Restarts the time without progress: the arm moves, or is expected to stand.
    pub(super) fn changed(&mut self) {
        self.changed = Instant::now();
        self.pose = None;
    }
}

/// Polling.
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

    /// Polls the index, the alarms and, without progress, the arm.
    pub(super) async fn look(&mut self, arm: &Arm) -> Result<Progress> {
        let read = arm.get::<QueuedCmdCurrentIndex>().await?;
        self.look_from(arm, read.queued_cmd_current_index).await
    }

    /// Continues as [`look`](Self::look) with an index that was read already.
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
            // The command may have finished between the two reads, before the alarm was raised.
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

    /// Examines a queue without progress: is the arm at rest?
    async fn look_closer(&mut self, arm: &Arm, pace: Option<QueuedPace>) -> Result<()> {
        if !self.counted {
            self.still_queued(arm).await?;
        }
        // The pose does not show the rail.
        let rail = match pace {
            Some(QueuedPace::Rail) => Some(arm.get::<PoseL>().await?),
            // Everything else shows in the pose, so the read is spared.
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
        // A stream starts the queue itself, so no other program has to be waited for.
        let grace = if started || self.counted {
            STUCK_AFTER
        } else {
            GRACE
        };
        let patience = match pace {
            Some(QueuedPace::Home) => MAX_COMMAND_TIME,
            Some(QueuedPace::Motor(time)) if stopped => time,
            // A stop cuts waits and triggers short.
            _ if stopped => STANDING,
            // A trigger may never come: any time is legitimate.
            Some(QueuedPace::Trigger) => return Ok(()),
            Some(QueuedPace::Motion | QueuedPace::Rail) if started => {
                return self.confirm_hold(arm).await;
            }
            Some(QueuedPace::Motion | QueuedPace::Rail | QueuedPace::Moment) => grace,
            Some(QueuedPace::Pause(time) | QueuedPace::Motor(time)) => time.saturating_add(grace),
            // A command of another program, or one the picture has lost: as long as any may take.
            None => MAX_COMMAND_TIME,
        };
        if self.changed.elapsed() < patience {
            return Ok(());
        }
        let (last, current) = (self.progress.last.0, self.progress.current.0);
        let message = match (stopped, started) {
            (true, _) => message!(
                "waiting for queue index {last}: it stays at {current}, and its queue is stopped",
                last,
                current
            ),
            (_, true) => message!(
                "waiting for queue index {last}: it stays at {current} and the arm stands still",
                last,
                current
            ),
            _ => message!(
                "waiting for queue index {last}: it stays at {current} and the arm stands still; \
                    its queue was not started, or is stopped",
                last,
                current
            ),
        };
        Err(match (stopped, started) {
            (false, true) => Error::new(ErrorCode::NotFinished, message),
            _ => Error::new(ErrorCode::QueueStopped, message)
                .remedy(Action::StartQueue, "lets it continue"),
        })
    }

    /// Returns an error if the queue is empty before the awaited index: it was cleared, or the arm
    /// was reset.
    async fn still_queued(&self, arm: &Arm) -> Result<()> {
        let (_, capacity) = arm.stats().await?;
        if arm.queue().left_space().await? < capacity
            || arm.queue().current_index().await? != self.progress.current
        {
            return Ok(());
        }
        let message = message!(
            "queue index {last} will not come: the arm's queue is empty and stands at {current}; \
                it was cleared, or the arm was reset",
            last = self.progress.last.0,
            current = self.progress.current.0
        );
        Err(Error::new(ErrorCode::Dropped, message))
    }

    /// Returns the error for the hold of an alarm (two equal poses although motion should run),
    /// unless the index changed just now.
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
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) as soon as an alarm holds the queue, or if the
    /// hold of an alarm that has vanished still keeps the arm from moving; else as
    /// [`get`](Self::get).
    ///
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) if there is no progress for longer than
    /// the commands explain: after 1.5 s in a queue that this handle has stopped, after 5 s in one
    /// that another program may be about to start. A trigger explains any time.
    pub async fn wait(&self, index: QueueIndex) -> Result<()> {
        self.wait_with(index, |_| {}).await
    }

    /// Waits as [`wait`](Self::wait) does, and reports the progress.
    ///
    /// # Errors
    /// Same as [`wait`](Self::wait).
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
