//! Lock on filling the queue.

use magician_protocol::{Ctrl, FrameBuf, Set};

use crate::connection::Request;
use crate::{Error, Result, message};

/// Cached room in the queue. The holder of its lock may fill the queue.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// Places known to be free; 0 if unknown.
    pub(super) room: u32,
}

/// Returns the request that queues a command.
pub(super) fn queued(command: &Set) -> Result<Request> {
    let row = command.row();
    if !row.queueable {
        let error = Error::invalid(message!("it cannot be queued; set it directly"));
        return Err(error.with_command(row.set_name));
    }
    Ok(Request::of(FrameBuf::set(command, Ctrl::QUEUED)?))
}
