use magician_protocol::{Ctrl, FrameBuf, NoArgs, Queueable, Readable, Set, Writable};

use super::Arm;
use super::flow::{self};
use crate::connection::Request;
use crate::{Error, QueueIndex, Result};

/// The verbs.
impl Arm {
    /// Asks for a value.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout), [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) when the answer cannot be read,
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) when the line broke.
    pub async fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T> {
        self.get_with(&NoArgs).await
    }

    /// Asks for a value that depends on something, the level of a pin for one.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T> {
        let request = Request::get::<T>(query)?;
        let reply = self.ask_for(request).await?;
        let value = T::decode(reply.frame().params()).map_err(Error::from);
        value.map_err(|error| error.with_command(T::ROW.get_name))
    }

    /// Sets a value or orders an action, at once. QueuedCmdForceStopExec overtakes whatever waits, and what has not gone out
    /// when it does fails with [`ErrorKind::Closed`](crate::ErrorKind::Closed).
    ///
    /// # Errors
    /// As [`get`](Self::get); [`ErrorKind::Uncertain`](crate::ErrorKind::Uncertain) when an action that must not be repeated was
    /// not answered, [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for what burns where that is not allowed
    /// ([`Options::allow_laser`](super::Options::allow_laser)).
    pub async fn set<T: Writable>(&self, value: &T) -> Result<()> {
        self.order(Request::set(value)?).await.map(drop)
    }

    /// What is not queued, where a queue that it lets run may run.
    async fn order(&self, request: Request) -> Result<FrameBuf> {
        self.permission()
            .check_release(&request.frame().frame())
            .await?;
        self.ask(request).await
    }

    /// As [`set`](Self::set), for a command chosen at run time.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub async fn set_any(&self, command: &Set) -> Result<()> {
        let order = FrameBuf::set(command, Ctrl::SET)?;
        self.order(Request::of(order)).await.map(drop)
    }

    /// Puts a command into the arm's queue and tells its index. It does not start the queue.
    ///
    /// # Errors
    /// [`ErrorKind::QueueFull`](crate::ErrorKind::QueueFull) when there is no room, or not yet: after a Clear the command under way has to finish first;
    /// [`ErrorKind::Uncertain`](crate::ErrorKind::Uncertain) when it cannot be told whether the arm took it; [`ErrorKind::Closed`](crate::ErrorKind::Closed) when that befell
    /// another task's command while this one waited for its turn; else as [`get`](Self::get).
    pub async fn enqueue<T>(&self, value: &T) -> Result<QueueIndex>
    where
        T: Queueable + Copy + Into<Set>,
    {
        self.enqueue_set(&(*value).into()).await
    }

    /// As [`enqueue`](Self::enqueue), for a command chosen at run time.
    ///
    /// # Errors
    /// As [`enqueue`](Self::enqueue); [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a command that cannot be queued.
    pub async fn enqueue_set(&self, command: &Set) -> Result<QueueIndex> {
        self.queue().fill(flow::queued(command)?, command).await
    }

    /// As [`enqueue_set`](Self::enqueue_set), for parameters in any form that arms take (errata E11): they are sent as
    /// they are.
    ///
    /// # Errors
    /// As [`enqueue_set`](Self::enqueue_set); [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) for what is no form of the command.
    pub async fn enqueue_form(&self, id: u8, params: &[u8]) -> Result<QueueIndex> {
        let command = Set::decode(id, params)?;
        flow::queued(&command)?;
        let request = Request::raw(id, Ctrl::QUEUED, params)?;
        self.queue().fill(request, &command).await
    }

    /// Sends any frame and returns the frame that answers it. With Ctrl bit 1 set it is a queued
    /// command like any other, but for the room in the queue, which is not looked at.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) when the parameters do not fit a frame, else as
    /// [`get`](Self::get) and [`enqueue`](Self::enqueue).
    pub async fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf> {
        let request = Request::raw(id, ctrl, params)?;
        if !ctrl.queued() {
            return self.order(request).await;
        }
        let deadline = self.deadline();
        let mut flow = self.queue().take_turn(deadline, "a raw command").await?;
        flow.room = 0;
        self.ask_until(request, deadline).await
    }
}
