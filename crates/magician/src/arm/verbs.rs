//! Single commands of the protocol: get, set, enqueue, raw.

use magician_protocol::{Ctrl, FrameBuf, NoArgs, Queueable, Readable, Set, Writable};

use super::Arm;
use super::flow::{self};
use crate::connection::Request;
use crate::{Error, QueueIndex, Result};

/// Single commands.
impl Arm {
    /// Reads a value.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`](crate::ErrorKind::Timeout) without an answer,
    /// [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if the answer cannot be decoded,
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if the line broke.
    pub async fn get<T: Readable<Query = NoArgs>>(&self) -> Result<T> {
        self.get_with(&NoArgs).await
    }

    /// Reads a value that depends on a query, such as the level of a pin.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn get_with<T: Readable>(&self, query: &T::Query) -> Result<T> {
        let request = Request::get::<T>(query)?;
        let reply = self.request_read(request).await?;
        let value = T::decode(reply.frame().params()).map_err(Error::from);
        value.map_err(|error| error.with_command(T::ROW.get_name))
    }

    /// Sets a value or executes an immediate command. QueuedCmdForceStopExec overtakes pending
    /// requests; those not sent yet fail with [`ErrorKind::Closed`](crate::ErrorKind::Closed).
    ///
    /// # Errors
    /// Same as [`get`](Self::get); [`ErrorKind::Uncertain`](crate::ErrorKind::Uncertain) if a
    /// command that must not be repeated was not answered,
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a command that burns without
    /// permission ([`Options::allow_laser`](super::Options::allow_laser)).
    pub async fn set<T: Writable>(&self, value: &T) -> Result<()> {
        self.order(Request::set(value)?).await.map(drop)
    }

    /// Sends an immediate command, after checking that it may start the queue if it does.
    async fn order(&self, request: Request) -> Result<FrameBuf> {
        self.permission()
            .check_release(&request.frame().frame())
            .await?;
        self.ask(request).await
    }

    /// Sends a command chosen at run time, as [`set`](Self::set) does.
    ///
    /// # Errors
    /// Same as [`set`](Self::set).
    pub async fn set_any(&self, command: &Set) -> Result<()> {
        let order = FrameBuf::set(command, Ctrl::SET)?;
        self.order(Request::of(order)).await.map(drop)
    }

    /// Puts a command into the arm's queue and returns its index. Does not start the queue.
    ///
    /// # Errors
    /// [`ErrorKind::QueueFull`](crate::ErrorKind::QueueFull) if there is no room, also after a
    /// Clear until the command in progress has finished;
    /// [`ErrorKind::Uncertain`](crate::ErrorKind::Uncertain) if the arm may or may not have
    /// accepted it; [`ErrorKind::Closed`](crate::ErrorKind::Closed) if that happened to a command
    /// of another task while this one waited for its turn; else as [`get`](Self::get).
    pub async fn enqueue<T>(&self, value: &T) -> Result<QueueIndex>
    where
        T: Queueable + Copy + Into<Set>,
    {
        self.enqueue_set(&(*value).into()).await
    }

    /// Queues a command chosen at run time, as [`enqueue`](Self::enqueue) does.
    ///
    /// # Errors
    /// Same as [`enqueue`](Self::enqueue);
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for a command that cannot be
    /// queued.
    pub async fn enqueue_set(&self, command: &Set) -> Result<QueueIndex> {
        self.queue().fill(flow::queued(command)?, command).await
    }

    /// Queues raw parameters as [`enqueue_set`](Self::enqueue_set) does, in any form that arms
    /// accept (errata E11). They are sent unchanged.
    ///
    /// # Errors
    /// Same as [`enqueue_set`](Self::enqueue_set);
    /// [`ErrorKind::Unexpected`](crate::ErrorKind::Unexpected) if the parameters are no form of the
    /// command.
    pub async fn enqueue_form(&self, id: u8, params: &[u8]) -> Result<QueueIndex> {
        let command = Set::decode(id, params)?;
        flow::queued(&command)?;
        let request = Request::raw(id, Ctrl::QUEUED, params)?;
        self.queue().fill(request, &command).await
    }

    /// Sends any frame and returns its reply. With Ctrl bit 1 set it counts as a queued command,
    /// but the room in the queue is not checked.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) if the parameters do not fit a
    /// frame, else as [`get`](Self::get) and [`enqueue`](Self::enqueue).
    pub async fn raw(&self, id: u8, ctrl: Ctrl, params: &[u8]) -> Result<FrameBuf> {
        let request = Request::raw(id, ctrl, params)?;
        if !ctrl.queued() {
            return self.order(request).await;
        }
        let deadline = self.deadline();
        let mut flow = self.queue().take_turn(deadline, "a raw command").await?;
        // The effect of a raw command on the queue is unknown, so the next call reads the space
        // again.
        flow.room = 0;
        self.ask_until(request, deadline).await
    }
}
