//! Many commands in a row: never more than the queue holds or may run on alone, never less than keeps the arm moving.

mod attend;
mod options;
mod plan;
mod source;
mod streaming;

use std::collections::VecDeque;
use std::sync::Arc;

use magician_host::picture::QueueLook;
use magician_protocol::{QueuedCmdIndex, Set};
use tokio::time::Instant;

use super::Arm;
use super::driver::Reached;
use super::watch::{Progress, Watch};
use crate::build;
use crate::connection::Micros;
use crate::message;
use crate::preflight::{CheckedProgram, Preflight};
use crate::stream::Leftover;
use crate::{Error, ErrorCode, Result};
pub use options::{Ran, RunOptions};
use plan::{Ahead, Light, Planned, Route};
pub(in crate::arm) use source::Supply;
pub use source::{CommandSource, Feeder};
pub use streaming::Streaming;

/// A program on its way through the arm's queue, from [`Arm::start`].
///
/// [`wait`](Self::wait) runs it. When that fails and [`is_interrupted`](Self::is_interrupted), the line broke or an
/// answer left a doubt that could not be settled then: the arm has finished what it had, and `wait` called once more goes on
/// at the very command that it did not take. First it finds out which that is, and that the arm stands where the last
/// finished command leaves it; where that does not add up it fails with both values, and nothing is sent. Nothing goes
/// on by itself.
///
/// After anything else it is over, and `wait` fails: after a stop or a reset (also one that came while the line was gone),
/// after an alarm, and when the future of `wait` was dropped before its end, because its progress is then unknown.
///
/// ```
/// use magician::{Arm, ErrorKind, build};
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> magician::Result<()> {
/// # let arm = Arm::connect("sim").await?;
/// let square = [(200.0, 0.0), (200.0, 40.0), (240.0, 40.0), (240.0, 0.0)];
/// let path = square.map(|(x, y)| build::path_to(x, y, 0.0));
/// let mut run = arm.start(path);
/// while let Err(error) = run.wait(|_| {}).await {
///     if error.kind() != ErrorKind::Port || !run.is_interrupted() {
///         return Err(error);
///     }
///     arm.reconnected().await?; // and ask the user whether to go on
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
#[must_use = "it only runs while it is waited for"]
pub struct Run<C> {
    arm: Arm,
    commands: C,
    /// It has no more commands: some iterators begin anew when they are asked once more.
    ended: bool,
    /// What the connection's task has to know of them, if they come from a feeder.
    supply: Option<Arc<Supply>>,
    options: RunOptions,
    /// Checks each command as it comes, and how many it has.
    checks: Option<Preflight>,
    checked: usize,
    /// Where the commands lead and how long they take, once that is of use.
    route: Route,
    /// Where they lead by the arm's fence, and where the first of them begins.
    fenced: Option<Preflight>,
    begins_at: Option<[f64; 4]>,
    planned: bool,
    /// Taken from `commands` and not handed on.
    pending: VecDeque<Planned>,
    leftover: Option<Leftover>,
    /// Stops before it was handed to the task; `None` while nothing of it was, and when it is done.
    begun: Option<u64>,
    /// The queue when it began, as long as nothing was put into it.
    look: Option<QueueLook>,
    /// How long its commands take by the check, us.
    lasts: Micros,
    /// What was handed on since it was handed over.
    ahead: Ahead,
    /// The count of earlier stops, where the arm was read before the start.
    stops: Option<u64>,
    ran: Ran,
    total: Option<u64>,
    light: Light,
    /// The command before which it ends, because the laser may not burn.
    refused: Option<Error>,
    /// How often the queue had been cleared on a line that was found again when it was handed over last.
    clears: u64,
}

impl Arm {
    /// Commands to be run as they come, any number of them: [`Run::wait`] takes one after the other as room and horizon allow. They
    /// are sent as they are, **without a check** but for [laser](super::Options::allow_laser) and [fence](super::Options::fence):
    /// [`run`](Self::run) checks a list beforehand. Nothing is sent before [`Run::wait`].
    pub fn start<C>(&self, commands: C) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        self.start_with(commands, RunOptions::default())
    }

    /// As [`start`](Self::start), with options.
    pub fn start_with<C>(&self, commands: C, options: RunOptions) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        Run::new(self, commands.into_iter(), options)
    }

    /// A program that was checked from where the arm stands: its commands are not planned once more.
    /// Nothing is sent before [`Run::wait`].
    pub fn start_checked(
        &self,
        program: CheckedProgram,
        options: RunOptions,
    ) -> Run<std::iter::Empty<Set>> {
        let mut run = Run::new(self, std::iter::empty(), options);
        run.route = Route::of(&program);
        run.pending = { program.into_items().into_iter() }
            .map(Planned::known)
            .collect();
        run.total = Some(run.pending.len() as u64);
        (run.planned, run.ended) = (true, true);
        run
    }
}

impl<C: CommandSource> Run<C> {
    pub(super) fn new(arm: &Arm, commands: C, options: RunOptions) -> Self {
        let total = commands.total();
        Self {
            arm: arm.front_end().patient(options.patience),
            commands,
            ended: false,
            supply: None,
            options,
            checks: None,
            checked: 0,
            route: Route::Unknown,
            fenced: None,
            begins_at: None,
            planned: false,
            pending: VecDeque::new(),
            leftover: None,
            begun: None,
            look: None,
            lasts: 0,
            ahead: Ahead::default(),
            stops: options.stops,
            ran: Ran::default(),
            total,
            light: Light::default(),
            refused: None,
            clears: 0,
        }
    }

    /// A motion that the arm refuses, or breaks off, counts as finished: of the last one only the alarm tells. Homing may
    /// end under one.
    async fn check_none_refused(&self) -> Result<()> {
        let last = self.ran.last;
        if last.is_some_and(|last| self.arm.picture().own().homes(last)) {
            return Ok(());
        }
        let alarms = self.arm.alarms().await?;
        if alarms.blocking() {
            return Err(self.arm.stopped_by(alarms).await);
        }
        Ok(())
    }

    /// Tells how long the commands take and where they lead from this check, made before them, instead of reading the
    /// arm's settings once more: what passed [`Preflight::program`] need not be looked up again.
    pub fn along(mut self, course: Preflight) -> Self {
        self.route = Route::along(course);
        self.planned = true;
        self
    }

    /// Runs what has not been run: puts commands into the queue as room and horizon allow, starts it, and returns when the last has
    /// finished. `progress` is called now and then.
    ///
    /// What fits goes in while the queue is stopped, so that nothing moves unless all of it was taken.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) as soon as an alarm holds the queue,
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) when commands of an earlier
    /// program wait in the queue, [`ErrorKind::Closed`](crate::ErrorKind::Closed) when a stop came,
    /// else as [`Arm::enqueue`] and [`Arm::wait`]. What was put into the queue
    /// before the error stays there: [`Arm::stop`] drops it. When it goes on also [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if the arm does not stand
    /// where it should, [`ErrorKind::Closed`](crate::ErrorKind::Closed) if it is [over](Self::is_interrupted).
    pub async fn wait(&mut self, mut progress: impl FnMut(Progress)) -> Result<Ran> {
        let arm = self.arm.clone();
        let stops = self.stops.take().unwrap_or_else(|| arm.stops());
        self.may_go_on()?;
        self.come().await;
        let mut flow = arm.queue().take_turn(arm.call_deadline(), "a run").await?;
        // A run that is dropped half-way leaves a queue that has to be counted again.
        flow.room = 0;
        arm.queue_fault(None)?;
        let begins = (self.leftover.as_ref()).is_none_or(|leftover| !leftover.has_begun());
        if begins {
            arm.come_to_rest().await?;
            let look = arm.known().look_at_queue().await?;
            if look.waiting() == 0 {
                arm.picture().queue_is_empty();
            }
            if self.options.keep {
                arm.permission().check_queue().await?;
            } else {
                arm.queue().refuse_foreign(&look)?;
            }
            let moves = self.may_move_arm();
            arm.homing().warn_if_not_homed(moves).await?;
            // Where commands of others may run, the stream looks for itself.
            self.look = Some(look).filter(|_| !self.options.keep);
        }
        // Held to the end of the run.
        let _turn = self.within_fence(&arm, begins).await?;
        self.plan().await?;
        self.check_ahead()?;
        if self.leftover.is_none() && self.pending.is_empty() {
            return Ok(self.ran);
        }
        let mut watch = Watch::new(self.total, stops).of_stream();
        let (mut feed, reached, ending) = self.hand_over(stops).await?;
        let handed = Instant::now();
        let end = self
            .attend(&mut feed, &reached, ending, &mut watch, &mut progress)
            .await?;
        self.note(end.reached);
        self.begun = self.begun.filter(|_| end.outcome.is_err());
        if let Some((leftover, mut rest)) = end.rest {
            self.leftover = Some(leftover);
            let mut unseen = VecDeque::new();
            while let Ok(item) = rest.try_recv() {
                unseen.push_back(Planned::given_back(item));
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
        // That the laser of a path goes out by itself where the arm comes to rest is likely and not certain.
        if self.light.goes_out() {
            arm.set_any(&build::laser(false)).await?;
        }
        if let Some(error) = self.refused.take() {
            return Err(error);
        }
        self.check_none_refused().await?;
        self.note_end(handed.elapsed());
        arm.homing().settle().await;
        Ok(self.ran)
    }

    /// Whether it ended before its end and [`wait`](Self::wait) may go on with it. A stop that comes later still
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
        self.arm.queue_fault(self.begun)?;
        Err(Error::new(
            ErrorCode::RunOver,
            message!(
                "this run is over: it ended by a stop or an error, or was not waited for; begin a new \
                one"
            ),
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
}
