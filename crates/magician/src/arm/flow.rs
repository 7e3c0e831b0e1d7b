//! Which call may fill the queue.

use magician_protocol::{Ctrl, FrameBuf, Set};

use crate::connection::Request;
use crate::{Error, Result};

/// What is known of the room in the queue. A call that fills the queue holds this.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// Places known to be free.
    pub(super) room: u32,
}

/// The request that queues a command.
pub(super) fn queued(command: &Set) -> Result<Request> {
    let row = command.row();
    if !row.queueable {
        let error = Error::invalid("it cannot be queued; set it directly");
        return Err(error.with_command(row.set_name));
    }
    Ok(Request::of(FrameBuf::set(command, Ctrl::QUEUED)?))
}
