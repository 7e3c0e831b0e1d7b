use magician_host::picture::QueueLook;
use magician_protocol::commands::{
    AlarmsState, ClearAlarmsState, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
    QueuedCmdStartExec,
};
use magician_protocol::{AlarmSet, FrameBuf, Layout, NoArgs, QueuedCmdIndex, Set};
use tokio::sync::MutexGuard;
use tokio::time::{Instant, timeout_at};

use super::Arm;
use super::flow::Flow;
use crate::connection::Request;
use crate::message;
use crate::{Action, Error, ErrorCode, ErrorKind, Given, QueueIndex, Result, Setting};

/// The queue of an arm: [`Arm::queue`] hands it out. [`Arm::enqueue`] and [`Arm::run`] put commands into it.
#[derive(Clone, Copy, Debug)]
pub struct Queue<'a> {
    arm: &'a Arm,
}

impl Queue<'_> {
    /// Lets the queue run (document 1.19.1). A start may end the motion under way (model section 14): none is sent while a
    /// queue runs that was started over this connection, and none before the arm stands.
    ///
    /// # Errors
    /// [`ErrorCode::Busy`] if the arm moves and still does after five seconds, else as [`get`](Arm::get). On
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) the queue may run: nothing is sent twice.
    pub async fn start(self) -> Result<()> {
        if !self.arm.stands().await? {
            if self.arm.picture().motion().started() == Some(true) {
                return Ok(());
            }
            self.arm
                .wait_still()
                .await
                .map_err(|error| match error.code() {
                    ErrorCode::StopUnconfirmed => {
                        Error::new(ErrorCode::Busy, message!("the arm moves"))
                    }
                    _ => error,
                })?;
        }
        self.start_standing().await
    }

    /// Lets the queue of an arm that stands run.
    pub(super) async fn start_standing(self) -> Result<()> {
        self.arm.set(&QueuedCmdStartExec {}).await
    }

    /// Lets the queue run if it is empty, and says whether it was: nothing moves by that. An arm is switched on with its queue
    /// stopped, and programs that were written on one that was started long ago wait for their first command for ever.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub async fn start_if_empty(self) -> Result<bool> {
        // What another program has left there is not set going.
        let empty = self.waiting().await? == 0;
        if empty {
            // The arm may move all the same: by an immediate motion of another program.
            self.start().await?;
        }
        Ok(empty)
    }

    /// Drops what waits in the queue (document 1.19.6). The motion under way may end where it is (model section 14). A run
    /// under way ends.
    ///
    /// # Errors
    /// As [`get`](Arm::get).
    pub async fn clear(self) -> Result<()> {
        self.arm.set(&QueuedCmdClear {}).await
    }

    /// Free places in the arm's queue.
    ///
    /// # Errors
    /// As [`get`](Arm::get).
    pub async fn left_space(self) -> Result<u32> {
        let read = self.arm.get::<QueuedCmdLeftSpace>().await?;
        Ok(read.left_space)
    }

    /// Index of the queued command that was finished last, 0 before the first.
    ///
    /// # Errors
    /// As [`get`](Arm::get).
    pub async fn current_index(self) -> Result<QueueIndex> {
        let read = self.arm.get::<QueuedCmdCurrentIndex>().await?;
        Ok(QueuedCmdIndex(read.queued_cmd_current_index))
    }

    /// How many places of the arm's queue are taken.
    pub(super) async fn waiting(self) -> Result<u32> {
        let room = self.left_space().await?;
        let (_, capacity) = self.arm.stats().await?;
        Ok(capacity.saturating_sub(room))
    }
}

/// Filling it.
impl<'a> Queue<'a> {
    /// Commands that other programs left in the queue are not run by accident.
    pub(super) fn refuse_foreign(self, look: &QueueLook) -> Result<()> {
        let waiting = self.foreign_commands(look);
        let (message, them) = match waiting {
            0 => return Ok(()),
            1 => (
                message!(
                    "1 command of an earlier program waits in the arm's queue and would run first"
                ),
                "it",
            ),
            count => (
                message!(
                    "{count} commands of an earlier program wait in the arm's queue and would run first",
                    count
                ),
                "them",
            ),
        };
        Err(Error::new(ErrorCode::ForeignCommands, message)
            .remedy(Action::Stop, format!("drops {them}"))
            .remedy((Setting::Keep, Given::On), format!("runs {them}")))
    }

    /// How many commands wait in the queue that this connection did not put there.
    pub(super) fn foreign_commands(self, look: &QueueLook) -> u32 {
        let waiting = look.waiting();
        let picture = self.arm.picture();
        let running = picture.motion().started() == Some(true);
        let ours = picture.own().waiting(look.current, running);
        if ours >= u64::from(waiting) {
            0
        } else {
            waiting
        }
    }

    /// Puts a request into the queue, when there is room for its command.
    pub(super) async fn fill(self, request: Request, command: &Set) -> Result<QueueIndex> {
        self.arm.permission().check([command])?;
        let deadline = self.arm.deadline();
        let doubts = self.doubts();
        let mut flow = self.take_turn(deadline, command.row().set_name).await?;
        if self.doubts() != doubts {
            let message = message!("it was not sent: an earlier command is uncertain");
            let error = Error::new(ErrorCode::AfterUncertain, message);
            return Err(error.with_command(command.row().set_name));
        }
        if flow.room == 0 {
            let request = Request::get::<QueuedCmdLeftSpace>(&NoArgs)?;
            let reply = self.arm.ask_until(request, deadline).await?;
            let read = QueuedCmdLeftSpace::decode(reply.frame().params())?;
            flow.room = read.left_space;
            self.note_room(flow.room).await?;
        }
        if flow.room == 0 {
            let error = Error::new(ErrorCode::QueueFull, message!("the arm's queue is full"));
            return Err(error.with_command(command.row().set_name));
        }
        // A caller that goes away meanwhile leaves behind what has to be counted anew.
        let mut room = std::mem::take(&mut flow.room);
        let reply = self.arm.ask_until(request, deadline).await;
        let index = self.accepted(&mut room, reply)?;
        flow.room = room;
        Ok(index)
    }

    /// Queued commands so far that became uncertain.
    fn doubts(self) -> u64 {
        self.arm.inner.shared.disruptions.doubts()
    }

    /// An empty queue is noted: what is put into it next runs next.
    async fn note_room(self, room: u32) -> Result<()> {
        let (_, capacity) = self.arm.stats().await?;
        if room >= capacity {
            self.arm.picture().queue_is_empty();
        }
        Ok(())
    }

    /// The queue is filled by one at a time.
    pub(super) async fn take_turn(
        self,
        deadline: Instant,
        name: &str,
    ) -> Result<MutexGuard<'a, Flow>> {
        let turn = timeout_at(deadline, self.arm.inner.flow.lock()).await;
        turn.map_err(|_| {
            let message = message!("another task is filling the queue");
            Error::new(ErrorCode::NotSent, message).with_command(name)
        })
    }

    /// Accounts for the answer to a queued command.
    pub(super) fn accepted(self, room: &mut u32, reply: Result<FrameBuf>) -> Result<QueueIndex> {
        let reply = reply.inspect_err(|error| {
            *room = 0;
            if [ErrorKind::Uncertain, ErrorKind::Unexpected].contains(&error.kind()) {
                self.arm.inner.shared.disruptions.doubt();
            }
        })?;
        let index = QueuedCmdIndex::decode(reply.frame().params())?;
        *room = room.saturating_sub(1);
        Ok(index)
    }
}

impl Arm {
    /// The queue.
    ///
    /// ```
    /// use magician::{Arm, build};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// let arm = Arm::connect("sim").await?;
    /// let index = arm.enqueue_set(&build::move_to(220.0, 0.0, 50.0, 0.0)).await?;
    /// arm.queue().start().await?;
    /// arm.wait(index).await?;
    /// assert_eq!(arm.queue().left_space().await?, 32);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub const fn queue(&self) -> Queue<'_> {
        Queue { arm: self }
    }

    /// The alarms that stand. That some stand is no error.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn alarms(&self) -> Result<AlarmSet> {
        let read = self.get::<AlarmsState>().await?;
        Ok(read.alarms_state)
    }

    /// The error for a wait that ends with these alarms.
    pub(super) async fn stopped_by(&self, alarms: AlarmSet) -> Error {
        // Where the bias cannot be read the alarms speak for themselves.
        let tool_unknown = self
            .front_end()
            .tool_is_unknown(&alarms)
            .await
            .unwrap_or(false);
        Error::alarm(alarms, tool_unknown)
    }

    /// Clears the alarms, and with them the hold on the queue if no cause stands any more.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn clear_alarms(&self) -> Result<()> {
        self.set(&ClearAlarmsState {}).await
    }
}
