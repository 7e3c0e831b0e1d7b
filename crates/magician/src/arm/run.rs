//! Many commands in a row: never more than the queue holds or may run on alone, never less than keeps the arm moving.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::commands::QueuedCmdCurrentIndex;
use magician_protocol::{QueuedCmdIndex, Set};
use tokio::sync::{mpsc, oneshot, watch as cell};
use tokio::time::{Instant, sleep_until, timeout_at};

use super::Arm;
use super::driver::{End, Message, Program, Reached, micros};
use super::watch::{FIRST_PAUSE, Progress, STANDING, Watch};
use crate::stream::{Item, Leftover, Stream, StreamSettings};
use crate::words::{Guards, Preflight};
use crate::{Error, ErrorKind, QueueIndex, Result};

/// Longest time between two looks for alarms.
const LOOK_PAUSE: Duration = Duration::from_millis(100);
/// The same while commands go out: an alarm that holds the queue would end that soon, and a look costs as much of the line
/// as a command.
const SELDOM: Duration = Duration::from_secs(1);
/// Commands on their way to the task.
const FEED: usize = 64;
/// So few are in the arm whatever they take: their times are of no use.
const ALWAYS: usize = 2;
/// So many are looked at beforehand, to read only what they depend on.
const AHEAD: usize = 32;

/// How [`Arm::run_with`] treats a queue.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct RunOptions {
    /// Runs commands of an earlier program that still wait in the queue, before these. Off at first.
    pub keep: bool,
    /// Most motion that the arm has in its queue, so that it does not go on for long when this program dies: the arm has
    /// no watchdog. Two commands are in it however long they take. Two seconds at first.
    pub horizon: Duration,
    /// The same while the laser may be lit. One second at first.
    pub laser_horizon: Duration,
    /// Lets an interrupted run go on although nobody knows where its last finished command left the arm. Off at first.
    pub trust_pose: bool,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            keep: false,
            horizon: Duration::from_secs(2),
            laser_horizon: Duration::from_secs(1),
            trust_pose: false,
        }
    }
}

impl RunOptions {
    /// Sets [`keep`](Self::keep).
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.keep = keep;
        self
    }

    /// Sets [`horizon`](Self::horizon).
    #[must_use]
    pub fn horizon(mut self, horizon: Duration) -> Self {
        self.horizon = horizon;
        self
    }

    /// Sets [`laser_horizon`](Self::laser_horizon).
    #[must_use]
    pub fn laser_horizon(mut self, horizon: Duration) -> Self {
        self.laser_horizon = horizon;
        self
    }

    /// Sets [`trust_pose`](Self::trust_pose).
    #[must_use]
    pub fn trust_pose(mut self, trust: bool) -> Self {
        self.trust_pose = trust;
        self
    }
}

/// What a run has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ran {
    /// How many commands the arm took and finished.
    pub commands: u64,
    /// Index of the first.
    pub first: Option<QueueIndex>,
    /// Index of the last.
    pub last: Option<QueueIndex>,
}

/// A program on its way through the arm's queue, from [`Arm::begin`].
///
/// [`finish`](Self::finish) runs it. When that fails and [`is_interrupted`](Self::is_interrupted), the line broke or an
/// answer left a doubt that could not be settled then: the arm has finished what it had, and `finish` called once more goes on
/// at the very command that it did not take. First it finds out which that is, and that the arm stands where the last
/// finished command leaves it; where that does not add up it fails with both values, and nothing is sent. Nothing goes
/// on by itself.
///
/// After anything else it is over, and `finish` fails: after a stop or a reset (also one that came while the line was gone),
/// after an alarm, and when the future of `finish` was dropped before its end, for then nobody knows how far it came.
///
/// ```
/// use magician::{Arm, ErrorKind, RunOptions, words};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// # let arm = Arm::connect(&"sim".parse()?).await?;
/// let square = [(200.0, 0.0), (200.0, 40.0), (240.0, 40.0), (240.0, 0.0)];
/// let path = square.map(|(x, y)| words::path_to(x, y, 0.0));
/// let mut run = arm.begin(path, RunOptions::default());
/// while let Err(error) = run.finish(|_| {}).await {
///     if error.kind() != ErrorKind::Port || !run.is_interrupted() {
///         return Err(error);
///     }
///     arm.reconnected().await?; // and ask whoever is there whether to go on
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
#[must_use = "it runs when it is finished"]
pub struct Run<C> {
    arm: Arm,
    commands: C,
    options: RunOptions,
    /// Where the commands lead and how long they take, once that is of use.
    course: Option<Preflight>,
    planned: bool,
    /// Taken from `commands` and not handed on.
    pending: VecDeque<Planned>,
    leftover: Option<Leftover>,
    /// Stops before it was handed to the task; `None` while nothing of it was, and when it is done.
    begun: Option<u64>,
    ran: Ran,
    total: Option<u64>,
}

#[derive(Debug)]
enum Planned {
    Fresh(Set),
    Item(Item),
}

impl Arm {
    /// Runs commands through the queue: puts them in as room and horizon allow, starts the queue, and returns
    /// when the last has finished. `progress` is called now and then.
    ///
    /// What fits goes in while the queue is stopped, so that nothing moves unless all of it was taken. The commands are
    /// sent as they are; [`perform`](Self::perform) checks them first.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) as soon as an alarm holds the queue,
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) when commands of an earlier
    /// program wait in the queue, [`ErrorKind::Closed`](crate::ErrorKind::Closed) when a stop came,
    /// else as [`enqueue`](Self::enqueue) and [`wait`](Self::wait). What was put into the queue
    /// before the error stays there: [`stop`](Self::stop) drops it.
    pub async fn run<C>(&self, commands: C, progress: impl FnMut(Progress)) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        self.run_with(commands, RunOptions::default(), progress)
            .await
    }

    /// As [`run`](Self::run), with options.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub async fn run_with<C>(
        &self,
        commands: C,
        options: RunOptions,
        progress: impl FnMut(Progress),
    ) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        self.begin(commands, options).finish(progress).await
    }

    /// A program that can go on after the line has broken; nothing is sent before [`Run::finish`].
    pub fn begin<C>(&self, commands: C, options: RunOptions) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        let commands = commands.into_iter();
        let total = match commands.size_hint() {
            (least, Some(most)) if least == most => Some(least as u64),
            _ => None,
        };
        Run {
            arm: self.clone(),
            commands,
            options,
            course: None,
            planned: false,
            pending: VecDeque::new(),
            leftover: None,
            begun: None,
            ran: Ran::default(),
            total,
        }
    }

    /// Commands that others put into the queue and nobody has run are not run by accident.
    async fn refuse_strangers(&self, room: u32) -> Result<()> {
        let (_, capacity) = self.stats().await?;
        let waiting = capacity.saturating_sub(room);
        if waiting == 0 {
            return Ok(());
        }
        let current = self.get::<QueuedCmdCurrentIndex>().await?;
        let running = self.exposure().started() == Some(true);
        let ours = (self.own()).waiting(current.queued_cmd_current_index, running);
        if ours >= u64::from(waiting) {
            return Ok(());
        }
        let (commands, them) = match waiting {
            1 => ("1 command of an earlier program waits".to_owned(), "it"),
            more => (
                format!("{more} commands of an earlier program wait"),
                "them",
            ),
        };
        Err(Error::invalid(format!(
            "{commands} in the arm's queue and would run first: `magician stop` drops {them}, `--keep` runs {them}"
        )))
    }
}

impl<C: Iterator<Item = Set>> Run<C> {
    /// Tells how long the commands take and where they lead from this check, made before them, instead of reading the
    /// arm's settings once more: what passed [`Preflight::program`] need not be looked up again.
    pub fn along(mut self, course: Preflight) -> Self {
        self.course = Some(course.guards(Guards::NONE));
        self.planned = true;
        self
    }

    /// Runs what has not been run, to its end.
    ///
    /// # Errors
    /// As [`Arm::run`]; and when it goes on, [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if the arm does not stand
    /// where it should, [`ErrorKind::Closed`](crate::ErrorKind::Closed) if it is [over](Self::is_interrupted).
    pub async fn finish(&mut self, mut progress: impl FnMut(Progress)) -> Result<Ran> {
        let arm = self.arm.clone();
        let stops = arm.stops();
        self.may_go_on()?;
        let mut flow = arm.take_turn(arm.deadline(), "a run").await?;
        // Whoever goes away in the middle of a run leaves behind what has to be counted anew.
        flow.room = 0;
        arm.mishap(None)?;
        let begins = (self.leftover.as_ref()).is_none_or(|leftover| !leftover.has_begun());
        if begins {
            let room = arm.left_space().await?;
            arm.note_room(room).await?;
            if !self.options.keep {
                arm.refuse_strangers(room).await?;
            }
            arm.warn_if_not_homed().await?;
        }
        self.plan().await?;
        if self.leftover.is_none() && self.pending.is_empty() {
            return Ok(self.ran);
        }
        let mut watch = Watch::new(self.total, stops);
        let (mut feed, reached, ending) = self.hand_over(stops).await?;
        let end = self
            .attend(&mut feed, &reached, ending, &mut watch, &mut progress)
            .await?;
        self.note(end.reached);
        self.begun = self.begun.filter(|_| end.outcome.is_err());
        if let Some((leftover, mut rest)) = end.rest {
            self.leftover = Some(leftover);
            let mut unseen = VecDeque::new();
            while let Ok(item) = rest.try_recv() {
                unseen.push_back(Planned::Item(item));
            }
            unseen.append(&mut self.pending);
            self.pending = unseen;
        }
        if let Err(error) = end.outcome {
            watch.not_stopped(&arm)?;
            return Err(error);
        }
        watch.sent(self.ran.commands, self.ran.last);
        progress(watch.at_its_end());
        Ok(self.ran)
    }

    /// Whether it ended before its end and [`finish`](Self::finish) may go on with it. A stop that comes later still
    /// ends it for good.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.leftover.is_some() && self.begun == Some(self.arm.stops())
    }

    /// What the task has not given back, and what a stop has ended, is not gone on with.
    fn may_go_on(&self) -> Result<()> {
        if self.begun.is_none() || self.is_interrupted() {
            return Ok(());
        }
        self.arm.mishap(self.begun)?;
        Err(Error::new(
            ErrorKind::Closed,
            "this run is over: a stop or an error ended it, or nobody waited for its end; begin a new one",
        ))
    }

    /// What it has done so far. Commands count when the arm has taken them.
    #[must_use]
    pub fn ran(&self) -> Ran {
        self.ran
    }

    /// How far it was when it was interrupted.
    fn reached(&self) -> Reached {
        let indices = self.ran.first.zip(self.ran.last);
        Reached {
            accepted: self.ran.commands,
            indices: indices.map(|(first, last)| (first.0, last.0)),
            current: 0,
        }
    }

    fn note(&mut self, reached: Reached) {
        self.ran.commands = reached.accepted;
        self.ran.first = reached.indices.map(|(first, _)| QueuedCmdIndex(first));
        self.ran.last = reached.indices.map(|(_, last)| QueuedCmdIndex(last));
    }

    /// Reads what the times of the commands depend on, unless they are too few to matter.
    async fn plan(&mut self) -> Result<()> {
        if std::mem::replace(&mut self.planned, true) {
            if self.pending.is_empty() {
                self.look_ahead(1);
            }
            return Ok(());
        }
        self.look_ahead(AHEAD);
        if self.pending.len() <= ALWAYS {
            return Ok(());
        }
        let course = match self.pending.len() < AHEAD {
            true => {
                let all: Vec<Set> = self.pending.iter().map(Planned::command).collect();
                self.arm.preflight_for(&all).await?
            }
            false => self.arm.preflight().await?,
        };
        self.course = Some(course.guards(Guards::NONE));
        Ok(())
    }

    fn look_ahead(&mut self, count: usize) {
        while self.pending.len() < count
            && let Some(command) = self.commands.next()
        {
            self.pending.push_back(Planned::Fresh(command));
        }
    }

    fn next(&mut self) -> Option<Item> {
        let planned = self.pending.pop_front();
        match planned.or_else(|| self.commands.next().map(Planned::Fresh))? {
            Planned::Item(item) => Some(item),
            Planned::Fresh(command) => Some(item(self.course.as_mut(), command)),
        }
    }

    /// Gives the program to the task.
    async fn hand_over(
        &mut self,
        stops: u64,
    ) -> Result<(
        Option<mpsc::Sender<Item>>,
        cell::Receiver<Reached>,
        oneshot::Receiver<End>,
    )> {
        let settings = StreamSettings {
            horizon: micros(self.options.horizon),
            laser_horizon: micros(self.options.laser_horizon),
            window: self.arm.inner.options.window,
            patience: micros(self.arm.inner.options.timeout),
            trust_pose: self.options.trust_pose,
            ..StreamSettings::default()
        };
        let arm = self.arm.clone();
        let place = timeout_at(arm.deadline(), arm.inner.messages.reserve()).await;
        let place = place.map_err(|_| Error::stuck())?;
        let place = place.map_err(|_| Error::closed())?;
        // From here on nothing is waited for: whoever goes away has handed it over, or not.
        let stream = match self.leftover.take() {
            Some(leftover) => Stream::resume(leftover, settings),
            None => Stream::new(settings),
        };
        self.begun = Some(stops);
        let (feed, inlet) = mpsc::channel(FEED);
        let (show, reached) = cell::channel(self.reached());
        let (end, ending) = oneshot::channel();
        let program = Program {
            stream,
            feed: inlet,
            stops,
            reached: show,
            end,
        };
        place.send(Message::Run(Box::new(program)));
        Ok((Some(feed), reached, ending))
    }

    /// Feeds the task, and looks for alarms meanwhile.
    async fn attend(
        &mut self,
        feed: &mut Option<mpsc::Sender<Item>>,
        reached: &cell::Receiver<Reached>,
        mut ending: oneshot::Receiver<End>,
        watch: &mut Watch,
        progress: &mut impl FnMut(Progress),
    ) -> Result<End> {
        let mut pause = FIRST_PAUSE;
        let mut look = Instant::now() + pause;
        let mut looked = Instant::now();
        let begun = looked;
        loop {
            tokio::select! {
                biased;
                end = &mut ending => return end.map_err(|_| Error::closed()),
                () = sleep_until(look) => {
                    let before = self.ran.commands;
                    let seen = *reached.borrow();
                    self.note(seen);
                    watch.sent(self.ran.commands, self.ran.last);
                    let flows = self.ran.commands > before;
                    if flows && looked.elapsed() < SELDOM {
                        progress(watch.saw(seen.current));
                    } else {
                        match self.look(watch, begun, flows.then_some(seen.current)).await {
                            Ok(None) => {}
                            Ok(Some(seen)) => progress(seen),
                            Err(error) => return self.ends_too(error, ending).await,
                        }
                        looked = Instant::now();
                    }
                    pause = (pause * 2).min(LOOK_PAUSE);
                    look = Instant::now() + pause;
                }
                () = fed(feed, || self.next()) => {}
            }
        }
    }

    /// A look for what holds the queue: by what was put into it, and before that, when it has no room for a long time.
    /// `current` is the current index, if it has just been read.
    async fn look(
        &self,
        watch: &mut Watch,
        begun: Instant,
        current: Option<u64>,
    ) -> Result<Option<Progress>> {
        if self.ran.last.is_some() {
            let seen = match current {
                Some(current) => self.arm.look_from(watch, current).await,
                None => self.arm.look(watch).await,
            };
            return seen.map(Some);
        }
        if begun.elapsed() >= STANDING && self.arm.left_space().await? == 0 {
            let alarms = self.arm.alarms().await?;
            if alarms.blocking() {
                return Err(Error::alarm(alarms));
            }
        }
        Ok(None)
    }

    /// A look has failed. What ended it, a line that broke or does not answer, ends the program too, and then the task
    /// gives back what is left of it.
    async fn ends_too(&self, error: Error, ending: oneshot::Receiver<End>) -> Result<End> {
        let line = matches!(error.kind(), ErrorKind::Port | ErrorKind::Timeout);
        if line
            && error.command().is_some()
            && let Ok(Ok(end)) = timeout_at(self.arm.deadline(), ending).await
        {
            return Ok(end);
        }
        Err(error)
    }
}

/// Hands the next command on when there is room; without one it closes the feed. None is taken that cannot be handed on.
async fn fed(feed: &mut Option<mpsc::Sender<Item>>, next: impl FnOnce() -> Option<Item>) {
    let Some(sender) = feed else {
        return std::future::pending().await;
    };
    // Without a permit the task has ended the program and says so.
    if let Ok(permit) = sender.reserve().await
        && let Some(item) = next()
    {
        return permit.send(item);
    }
    *feed = None;
}

impl Planned {
    fn command(&self) -> Set {
        match self {
            Self::Fresh(command) => *command,
            Self::Item(item) => item.command,
        }
    }
}

/// What is known of a command beforehand.
fn item(course: Option<&mut Preflight>, command: Set) -> Item {
    let unknown = Item {
        command,
        time: u64::MAX,
        end: None,
        laser: true,
    };
    let Some(Ok(step)) = course.map(|course| course.check(&command)) else {
        return unknown;
    };
    let pose = step.end.map(|end| end.pose);
    Item {
        command,
        time: micros(step.time),
        end: pose.map(|pose| [pose.x, pose.y, pose.z, pose.r]),
        laser: step.laser,
    }
}
