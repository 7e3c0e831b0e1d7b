//! Handing a run over to the driver task, and attending to it.
//!
//! The task feeds the stream; the handle supplies commands through a channel and polls for alarms
//! meanwhile. The intervals balance two goals: to report an alarm soon, and not to take time of the
//! line from the commands.

use std::future::Future;
use std::pin::pin;
use std::task::Poll;
use std::time::Duration;

use tokio::sync::{mpsc, oneshot, watch as cell};
use tokio::time::{Instant, interval_at, sleep_until, timeout_at};

use super::{CommandSource, Run};
use crate::arm::driver::{Message, Program, RunEnd, RunProgress, micros};
use crate::arm::watch::{FIRST_PAUSE, Progress, STANDING, Watch};
use crate::stream::{ArmPace, Item, Stream, StreamSettings};
use crate::{Error, ErrorKind, Result};

/// First poll for alarms, and longest interval, while a single command runs for its planned time.
/// An alarm that refuses it is raised at once. Choices.
const FIRST_POLL_DELAY: Duration = Duration::from_millis(60);
const MAX_PLANNED_POLL_INTERVAL: Duration = Duration::from_millis(500);
/// Longest interval of polls otherwise. Choice.
const MAX_POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Interval of polls while commands flow. An alarm that holds the queue would soon end the flow,
/// and a poll costs as much of the line as a command. Choice.
const FLOWING_POLL_INTERVAL: Duration = Duration::from_secs(1);
/// Interval of progress reports during silence. Choice: a user sees seconds count.
const SILENCE_REPORT_INTERVAL: Duration = Duration::from_secs(1);
/// Capacity of the channel to the task. Choice: two bursts.
const CHANNEL_CAPACITY: usize = 64;
/// Commands handed on at once if the arm takes them as fast as they come: the task and its handle
/// then wake each other once per burst. Choice.
const BURST_SIZE: u32 = 32;
/// Time per command below which the arm is in-process, so that bursts pay. A line takes
/// milliseconds, and there each command is requested from the source when its turn comes.
const IN_PROCESS_COMMAND_TIME: Duration = Duration::from_micros(100);
/// Longest time the caller's commands may block within a burst. Choice: the source shares the
/// thread with the driver.
const MAX_SOURCE_BLOCKING: Duration = Duration::from_millis(1);

impl<C: CommandSource> Run<C> {
    /// Submits the program to the task.
    pub(super) async fn hand_over(
        &mut self,
        stops: u64,
    ) -> Result<(
        Option<mpsc::Sender<Item>>,
        cell::Receiver<RunProgress>,
        oneshot::Receiver<RunEnd>,
    )> {
        let (running, pace) = {
            let picture = self.arm.picture();
            (picture.runs_queue(), picture.pace())
        };
        let settings = StreamSettings {
            horizon: micros(self.options.horizon),
            laser_horizon: micros(self.options.laser_horizon),
            window: self.arm.inner.options.window,
            patience: micros(self.options.patience.max(self.arm.timeout())),
            running,
            pace,
            trust_pose: self.options.trust_pose,
            ..StreamSettings::default()
        };
        let beginning = self.beginning().await?;
        let arm = self.arm.clone();
        let place = timeout_at(arm.call_deadline(), arm.inner.messages.reserve()).await;
        let place = place.map_err(|_| Error::stuck())?;
        let place = place.map_err(|_| Error::closed())?;
        // No await from here on: a dropped call has either submitted it or not.
        let clears = arm.inner.shared.disruptions.clears();
        // The clear happened on a reconnected line: the commands before it are gone from the queue.
        let cleared = std::mem::replace(&mut self.clears, clears) != clears;
        if self.leftover.is_some() {
            // The rest of an interrupted run was counted before.
            self.options.lead = None;
        }
        let stream = match self.leftover.take() {
            Some(leftover) if cleared => Stream::resume(leftover.cleared(), settings),
            Some(leftover) => Stream::resume(leftover, settings),
            None => match beginning {
                Some(beginning) => Stream::beginning(settings, beginning),
                None => Stream::new(settings),
            },
        };
        self.stops_at_start = Some(stops);
        let (feed, inlet) = mpsc::channel(CHANNEL_CAPACITY);
        let (show, reached) = cell::channel(self.reached());
        let (end, ending) = oneshot::channel();
        let program = Program {
            stream,
            feed: inlet,
            supply: self.supply.clone(),
            offered: 0,
            stops,
            reached: show,
            end,
        };
        place.send(Message::Run(Box::new(program)));
        Ok((Some(feed), reached, ending))
    }

    /// Feeds the task, and polls for alarms meanwhile.
    pub(super) async fn attend(
        &mut self,
        feed: &mut Option<mpsc::Sender<Item>>,
        reached: &cell::Receiver<RunProgress>,
        mut ending: oneshot::Receiver<RunEnd>,
        watch: &mut Watch,
        progress: &mut impl FnMut(Progress),
    ) -> Result<RunEnd> {
        let on_time = self.on_time();
        let (mut pause, longest) = if on_time {
            (FIRST_POLL_DELAY, MAX_PLANNED_POLL_INTERVAL)
        } else {
            (FIRST_PAUSE, MAX_POLL_INTERVAL)
        };
        let begun = Instant::now();
        let mut looked = begun;
        let (mut burst, mut handed) = (1, begun);
        let mut look = pin!(sleep_until(begun + pause));
        let mut news = reached.clone();
        loop {
            let held = self.is_far_ahead(&mut news);
            tokio::select! {
                // The end first: a poll after it would report on a queue that others may use by
                // then.
                biased;
                end = &mut ending => return end.map_err(|_| Error::closed()),
                () = &mut look => {
                    let before = self.summary.commands;
                    let seen = *reached.borrow();
                    self.note(seen);
                    watch.sent(self.summary.commands, self.summary.last);
                    // A virtual clock that waits for the source must not count as a stuck arm.
                    if self.supply.as_ref().is_some_and(|supply| supply.clock_waiting()) {
                        watch.changed();
                    }
                    if on_time {
                        watch.lasts(Duration::from_micros(self.planned_time));
                    }
                    let flows = self.summary.commands > before;
                    if flows && looked.elapsed() < FLOWING_POLL_INTERVAL {
                        progress(watch.saw(seen.current));
                    } else {
                        let before = watch.progress();
                        let current = (flows || on_time).then_some(seen.current);
                        let looks = self.look(watch, begun, current);
                        match report_while_waiting(looks, before, progress, &mut ending).await {
                            PollOutcome::Seen(None) => {}
                            PollOutcome::Seen(Some(seen)) => progress(seen),
                            PollOutcome::Failed(error) => return self.ends_too(error, ending).await,
                            PollOutcome::Over(end) => return end.map(|end| *end).ok_or_else(Error::closed),
                        }
                        looked = Instant::now();
                    }
                    pause = (pause * 2).min(longest);
                    look.as_mut().reset(Instant::now() + pause);
                }
                // A closed channel means that the task has ended the program; `ending` reports it.
                Ok(()) = news.changed(), if held => {}
                () = self.feed_on(feed, burst, reached), if !held => {
                    let now = Instant::now();
                    // Averaged over the burst, because a wake-up is shared by all of its commands.
                    let each = now.duration_since(std::mem::replace(&mut handed, now)) / burst;
                    burst = if each < IN_PROCESS_COMMAND_TIME { BURST_SIZE } else { 1 };
                }
            }
        }
    }

    /// True if the commands ahead of the arm last long enough for now.
    fn is_far_ahead(&mut self, reached: &mut cell::Receiver<RunProgress>) -> bool {
        let accepted = reached.borrow_and_update().accepted;
        let long = |lead| self.backlog.is_long(accepted, lead);
        self.options.lead.is_some_and(long)
    }

    /// Hands on the next commands when there is room for `burst` of them, and closes the feed at
    /// the end. No command is taken from the source that cannot be handed on.
    async fn feed_on(
        &mut self,
        feed: &mut Option<mpsc::Sender<Item>>,
        burst: u32,
        reached: &cell::Receiver<RunProgress>,
    ) {
        let Some(sender) = feed else {
            return std::future::pending().await;
        };
        // Without permits the task has ended the program, and `ending` reports it.
        let over = match sender.reserve_many(burst as usize).await {
            Ok(permits) => {
                self.wait_for_command().await;
                let begun = Instant::now();
                // A slow source must not block the thread.
                let mut in_time = permits.take_while(|_| begun.elapsed() < MAX_SOURCE_BLOCKING);
                loop {
                    let Some(permit) = in_time.next() else {
                        break false;
                    };
                    if self.is_far_ahead(&mut reached.clone()) {
                        break false;
                    }
                    match self.next() {
                        Poll::Ready(Some(item)) => permit.send(item),
                        Poll::Ready(None) => break true,
                        Poll::Pending => break false,
                    }
                }
            }
            Err(_) => true,
        };
        if over {
            *feed = None;
        }
    }

    /// Polls for the cause of a held queue: from the commands in it, and before the first from a
    /// queue without room. `current` is the current index if it was read recently.
    async fn look(
        &self,
        watch: &mut Watch,
        begun: Instant,
        current: Option<u64>,
    ) -> Result<Option<Progress>> {
        if self.summary.last.is_some() {
            let seen = match current {
                Some(current) => watch.look_from(&self.arm, current).await,
                None => watch.look(&self.arm).await,
            };
            return seen.map(Some);
        }
        if begun.elapsed() >= STANDING && self.arm.queue().left_space().await? == 0 {
            let alarms = self.arm.alarms().await?;
            if alarms.blocking() {
                return Err(self.arm.stopped_by(alarms).await);
            }
        }
        Ok(None)
    }

    /// True if the only command ends at its planned time, so that nothing can be seen before.
    fn on_time(&self) -> bool {
        self.total == Some(1) && self.arm.picture().pace() == ArmPace::OnTime
    }

    /// Handles a failed poll. A broken or silent line also ends the program, and the task then
    /// returns the rest of it.
    async fn ends_too(&self, error: Error, ending: oneshot::Receiver<RunEnd>) -> Result<RunEnd> {
        let line = matches!(error.kind(), ErrorKind::Port | ErrorKind::Timeout);
        if line
            && error.command().is_some()
            && let Ok(Ok(end)) = timeout_at(self.arm.call_deadline(), ending).await
        {
            return Ok(end);
        }
        Err(error)
    }
}

/// Outcome of a poll.
enum PollOutcome {
    Seen(Option<Progress>),
    Failed(Error),
    /// The run ended first.
    Over(Option<Box<RunEnd>>),
}

/// Awaits a poll, and reports every second that it is not answered yet.
async fn report_while_waiting(
    look: impl Future<Output = Result<Option<Progress>>>,
    before: Progress,
    progress: &mut impl FnMut(Progress),
    ending: &mut oneshot::Receiver<RunEnd>,
) -> PollOutcome {
    let begun = Instant::now();
    let mut seconds = interval_at(begun + SILENCE_REPORT_INTERVAL, SILENCE_REPORT_INTERVAL);
    let mut look = pin!(look);
    loop {
        tokio::select! {
            // The result of the poll first: the end is not lost, the caller's loop finds it next.
            biased;
            seen = &mut look => return seen.map_or_else(PollOutcome::Failed, PollOutcome::Seen),
            end = &mut *ending => return PollOutcome::Over(end.ok().map(Box::new)),
            _ = seconds.tick() => progress(Progress { silent: begun.elapsed(), ..before }),
        }
    }
}
