//! Runs: many commands in a row through the arm's queue.
//!
//! A run keeps the queue full enough that the arm does not stop between commands, and empty enough
//! that it does not continue for long if the host dies ([`RunOptions::horizon`]). The [`Stream`] in
//! the driver task decides what goes out when; [`Run`] takes commands from the caller, checks
//! permissions and fence, plans their durations, and attends to the run until its end.

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
use super::driver::RunProgress;
use super::watch::{Progress, Watch};
use crate::build;
use crate::connection::Micros;
use crate::message;
use crate::preflight::{CheckedProgram, Preflight};
use crate::stream::Leftover;
use crate::{Error, ErrorCode, Result};
pub use options::{RunOptions, RunSummary};
use plan::{Backlog, LaserTracker, Planned, Route};
pub(in crate::arm) use source::Supply;
pub use source::{CommandSource, Feeder};
pub use streaming::Streaming;

/// Program in progress, from [`Arm::start`].
///
/// [`wait`](Self::wait) runs it. If that fails and [`is_interrupted`](Self::is_interrupted) is
/// true, the line broke or a lost answer left it uncertain which commands the arm has accepted. The
/// arm finishes those, and another `wait` continues with the first command it did not accept. That
/// `wait` first determines which command this is, and checks that the arm stands where its last
/// finished command ends. If anything disagrees, it fails with the expected and the found value and
/// sends nothing. A run never continues by itself.
///
/// After any other error the run is over, and `wait` fails: after a stop or a reset (also during a
/// lost line), after an alarm, and if the future of `wait` was dropped, because its progress is
/// then unknown.
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
    /// True after the last command: some iterators start over when polled again.
    ended: bool,
    /// Shared state with the feeder, if the commands come from one.
    supply: Option<Arc<Supply>>,
    options: RunOptions,
    /// Check of each command as it comes from the source.
    checks: Option<Preflight>,
    /// Number of commands checked.
    checked: usize,
    /// Positions and durations of the commands, once needed.
    route: Route,
    /// Check against the fence.
    fenced: Option<Preflight>,
    /// Position at which the first command begins.
    begins_at: Option<[f64; 4]>,
    planned: bool,
    /// Commands taken from the source and not yet sent to the driver task.
    pending: VecDeque<Planned>,
    leftover: Option<Leftover>,
    /// Stop count at the submission of the run; `None` before the submission and after the end.
    stops_at_start: Option<u64>,
    /// State of the queue at the start; `None` once the run has put a command into it.
    queue_at_start: Option<QueueLook>,
    /// Planned duration of the commands, us.
    planned_time: Micros,
    /// Commands sent to the driver task and not yet accepted by the arm.
    backlog: Backlog,
    /// Stop count of the caller, if the arm was read before the start.
    stops: Option<u64>,
    summary: RunSummary,
    total: Option<u64>,
    laser: LaserTracker,
    /// Error of a refused command. The run ends before this command.
    refused: Option<Error>,
    /// Number of clears on reconnected lines at the last submission.
    clears: u64,
}

impl Arm {
    /// Starts any number of commands, supplied while they run: [`Run::wait`] takes them one by one
    /// as room and horizon allow.
    ///
    /// They are sent **without a check** except for [laser](super::Options::allow_laser) and
    /// [fence](super::Options::fence); [`run`](Self::run) checks a list first. Nothing is sent
    /// before [`Run::wait`].
    pub fn start<C>(&self, commands: C) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        self.start_with(commands, RunOptions::default())
    }

    /// Starts commands as [`start`](Self::start) does, with options.
    pub fn start_with<C>(&self, commands: C, options: RunOptions) -> Run<C::IntoIter>
    where
        C: IntoIterator<Item = Set>,
    {
        Run::new(self, commands.into_iter(), options)
    }

    /// Starts a program that was checked from where the arm stands; its commands are not planned
    /// again. Nothing is sent before [`Run::wait`].
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
            stops_at_start: None,
            queue_at_start: None,
            planned_time: 0,
            backlog: Backlog::default(),
            stops: options.stops,
            summary: RunSummary::default(),
            total,
            laser: LaserTracker::default(),
            refused: None,
            clears: 0,
        }
    }

    /// Checks for an alarm at the end: a refused or aborted motion counts as finished, and for the
    /// last one only the alarm shows it. Homing may end under an alarm.
    async fn check_none_refused(&self) -> Result<()> {
        let last = self.summary.last;
        if last.is_some_and(|last| self.arm.picture().own().homes(last)) {
            return Ok(());
        }
        let alarms = self.arm.alarms().await?;
        if alarms.blocking() {
            return Err(self.arm.stopped_by(alarms).await);
        }
        Ok(())
    }

    /// Takes positions and durations of the commands from `course`, a check that starts where the
    /// commands start, instead of reading the settings again. For commands that passed
    /// [`Preflight::program`].
    pub fn along(mut self, course: Preflight) -> Self {
        self.route = Route::along(course);
        self.planned = true;
        self
    }

    /// Runs the remaining commands: puts them into the queue as room and horizon allow, starts it,
    /// and returns when the last has finished. `progress` is called now and then.
    ///
    /// The first commands are queued while the queue is stopped, so nothing moves unless all of
    /// them were accepted.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`](crate::ErrorKind::Alarm) as soon as an alarm holds the queue,
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if commands of an earlier
    /// program wait in the queue, [`ErrorKind::Closed`](crate::ErrorKind::Closed) after a stop,
    /// else as [`Arm::enqueue`] and [`Arm::wait`]. Commands queued before the error stay in the
    /// queue: [`Arm::stop`] drops them.
    ///
    /// On a second call also [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if the arm is
    /// not where it should be, and [`ErrorKind::Closed`](crate::ErrorKind::Closed) if the run is
    /// [over](Self::is_interrupted).
    pub async fn wait(&mut self, mut progress: impl FnMut(Progress)) -> Result<RunSummary> {
        let arm = self.arm.clone();
        let stops = self.stops.take().unwrap_or_else(|| arm.stops());
        self.check_not_over()?;
        self.wait_for_command().await;
        let mut flow = arm.queue().take_turn(arm.call_deadline(), "a run").await?;
        // A run dropped halfway leaves a queue whose room has to be read again.
        flow.room = 0;
        arm.queue_fault(None)?;
        // A resumed run is in the middle of its queue, where these checks would refuse it.
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
            // If commands of other programs may run, the stream reads the queue itself.
            self.queue_at_start = Some(look).filter(|_| !self.options.keep);
        }
        // Held until the end of the run.
        let _turn = self.within_fence(&arm, begins).await?;
        self.plan().await?;
        self.check_ahead()?;
        if self.leftover.is_none() && self.pending.is_empty() {
            return Ok(self.summary);
        }
        let mut watch = Watch::new(self.total, stops).of_stream();
        let (mut feed, reached, ending) = self.hand_over(stops).await?;
        let handed = Instant::now();
        let end = self
            .attend(&mut feed, &reached, ending, &mut watch, &mut progress)
            .await?;
        self.note(end.reached);
        self.stops_at_start = self.stops_at_start.filter(|_| end.outcome.is_err());
        // Commands that the task returns, and those still in the channel, come before our own.
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
        watch.sent(self.summary.commands, self.summary.last);
        progress(watch.at_its_end());
        // Firmware probably turns the laser off at the end of a path, but this is unconfirmed: send
        // it explicitly.
        if self.laser.must_switch_off() {
            arm.set_any(&build::laser(false)).await?;
        }
        if let Some(error) = self.refused.take() {
            return Err(error);
        }
        self.check_none_refused().await?;
        self.note_end(handed.elapsed());
        arm.homing().settle().await;
        Ok(self.summary)
    }

    /// True if the run was interrupted and [`wait`](Self::wait) can continue it. A later stop ends
    /// it for good.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.leftover.is_some() && self.stops_at_start == Some(self.arm.stops())
    }

    /// Returns an error if the run is over: the task has not returned the rest, or a stop has ended
    /// it.
    fn check_not_over(&self) -> Result<()> {
        if self.stops_at_start.is_none() || self.is_interrupted() {
            return Ok(());
        }
        self.arm.queue_fault(self.stops_at_start)?;
        Err(Error::new(
            ErrorCode::RunOver,
            message!(
                "this run is over: it ended by a stop or an error, or was not waited for; begin a new \
                one"
            ),
        ))
    }

    /// Returns the result so far. Commands count once the arm has accepted them.
    #[must_use]
    pub fn ran(&self) -> RunSummary {
        self.summary
    }

    /// Returns the progress at an interruption.
    fn reached(&self) -> RunProgress {
        let indices = self.summary.first.zip(self.summary.last);
        RunProgress {
            accepted: self.summary.commands,
            indices: indices.map(|(first, last)| (first.0, last.0)),
            current: 0,
        }
    }

    fn note(&mut self, reached: RunProgress) {
        self.summary.commands = reached.accepted;
        self.summary.first = reached.indices.map(|(first, _)| QueuedCmdIndex(first));
        self.summary.last = reached.indices.map(|(_, last)| QueuedCmdIndex(last));
    }
}
