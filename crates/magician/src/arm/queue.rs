//! The command queue of the arm: start, clear, look, and fill.
//!
//! A queued command is accepted with an index; the arm counts the finished ones by the same index.
//! Filling is serialised by the lock [`Flow`], which also caches the free places, so that the space
//! is read only when the cache says zero. Commands that other programs left in the queue are found
//! by counting: if more commands wait than this connection has unfinished, the queue is foreign,
//! and is not started by accident.

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
use crate::{Action, Error, ErrorCode, ErrorKind, QueueIndex, Result, Setting, SettingValue};

/// Command queue of an arm, returned by [`Arm::queue`]. [`Arm::enqueue`] and [`Arm::run`] fill it.
#[derive(Clone, Copy, Debug)]
pub struct Queue<'a> {
    arm: &'a Arm,
}

impl Queue<'_> {
    /// Starts the queue (document 1.19.1).
    ///
    /// A start may cut off the motion under way (model section 14). So none is sent while a queue
    /// runs that this connection started, and none before the arm is at rest.
    ///
    /// # Errors
    /// [`ErrorCode::Busy`] if the arm still moves after five seconds, else as [`get`](Arm::get).
    /// After [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) the queue may be running: the start
    /// is not retransmitted.
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
                    // Any other error is about the line, not about the motion.
                    _ => error,
                })?;
        }
        self.start_standing().await
    }

    /// Starts the queue of an arm that is at rest.
    pub(super) async fn start_standing(self) -> Result<()> {
        self.arm.set(&QueuedCmdStartExec {}).await
    }

    /// Starts the queue if it is empty, and returns true if it was. Nothing moves.
    ///
    /// The queue of an arm is stopped at power-up. Programs written for one whose queue runs would
    /// otherwise wait for their first command forever.
    ///
    /// # Errors
    /// Same as [`start`](Self::start).
    pub async fn start_if_empty(self) -> Result<bool> {
        // Commands that another program left there must not start to run.
        let empty = self.waiting().await? == 0;
        if empty {
            // Even with an empty queue the arm may move, by an immediate motion of another program.
            self.start().await?;
        }
        Ok(empty)
    }

    /// Drops the commands in the queue (document 1.19.6). The motion under way may end early (model
    /// section 14). A run in progress ends.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get).
    pub async fn clear(self) -> Result<()> {
        self.arm.set(&QueuedCmdClear {}).await
    }

    /// Reads the number of free places in the queue.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get).
    pub async fn left_space(self) -> Result<u32> {
        let read = self.arm.get::<QueuedCmdLeftSpace>().await?;
        Ok(read.left_space)
    }

    /// Reads the index of the queued command that finished last, 0 before the first.
    ///
    /// # Errors
    /// Same as [`get`](Arm::get).
    pub async fn current_index(self) -> Result<QueueIndex> {
        let read = self.arm.get::<QueuedCmdCurrentIndex>().await?;
        Ok(QueuedCmdIndex(read.queued_cmd_current_index))
    }

    /// Returns the number of commands in the queue.
    pub(super) async fn waiting(self) -> Result<u32> {
        let room = self.left_space().await?;
        let (_, capacity) = self.arm.stats().await?;
        Ok(capacity.saturating_sub(room))
    }
}

/// Filling the queue.
impl<'a> Queue<'a> {
    /// Refuses to continue if commands of other programs wait in the queue.
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
            .remedy((Setting::Keep, SettingValue::On), format!("runs {them}")))
    }

    /// Returns the number of waiting commands that this connection did not send.
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

    /// Sends a queued request once there is room for it.
    pub(super) async fn fill(self, request: Request, command: &Set) -> Result<QueueIndex> {
        self.arm.permission().check([command])?;
        let deadline = self.arm.deadline();
        let doubts = self.doubts();
        // If a command of another call became uncertain while this one waited for its turn, this
        // one could run without it.
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
        // The cache stays at zero if the caller drops this future, so the next call reads the space
        // again.
        let mut room = std::mem::take(&mut flow.room);
        let reply = self.arm.ask_until(request, deadline).await;
        let index = self.accepted(&mut room, reply)?;
        flow.room = room;
        Ok(index)
    }

    /// Returns the number of queued commands up to now whose acceptance is uncertain.
    fn doubts(self) -> u64 {
        self.arm.inner.shared.disruptions.doubts()
    }

    /// Notes an empty queue in the picture: the next command put into it is the next to run.
    async fn note_room(self, room: u32) -> Result<()> {
        let (_, capacity) = self.arm.stats().await?;
        if room >= capacity {
            self.arm.picture().queue_is_empty();
        }
        Ok(())
    }

    /// Waits for the exclusive right to fill the queue.
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

    /// Updates the free places after the reply to a queued command, and returns its index.
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
    /// Returns the command queue.
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

    /// Reads the active alarms. An active alarm is not an error.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn alarms(&self) -> Result<AlarmSet> {
        let read = self.get::<AlarmsState>().await?;
        Ok(read.alarms_state)
    }

    /// Builds the error for a wait that ends with these alarms.
    pub(super) async fn stopped_by(&self, alarms: AlarmSet) -> Error {
        // If the tool bias cannot be read, the alarms are reported without that hint.
        let tool_unknown = self
            .front_end()
            .tool_is_unknown(&alarms)
            .await
            .unwrap_or(false);
        Error::alarm(alarms, tool_unknown)
    }

    /// Clears the alarms. This also lifts their hold on the queue if no cause remains.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn clear_alarms(&self) -> Result<()> {
        self.set(&ClearAlarmsState {}).await
    }
}
