//! The table of the interface: every function once (interface sections 4 and 6).
//!
//! A row: what it comes to ([`Kind`](crate::Kind)), the ids it begins with ([`Ids`](crate::Ids)), its name, its
//! arguments after the ids, the families that have it so, and its body.
//!
//! The file is long because it is the table.

use std::ffi::c_int;

use crate::Function;

/// What the bodies and arguments of the rows are written with.
pub mod names {
    pub use std::ffi::c_int;

    pub use magician::commands;

    pub use crate::call::Queued::{Always, Said};
    pub use crate::call::{self, get, put, queue, queue_in, set};
    pub use crate::pointer::{Buffer, In, Out, Text};
    pub use crate::session;
    pub use crate::structure::*;
    /// `bool` as C passes it: only the low byte counts, for callers without prototypes pass an `int`.
    pub type Bool = u8;
}

/// Every function of the interface.
pub const FUNCTIONS: &[Function] = crate::functions!(crate list_rows list);

/// The id of the arm: there is only one where none is given.
#[doc(hidden)]
#[must_use]
pub fn first(given: &[c_int]) -> c_int {
    given.first().copied().unwrap_or_default()
}

/// Hands the table to another macro of this crate.
#[doc(hidden)]
#[macro_export]
macro_rules! functions {
    ($home:tt $then:ident $($first:tt)*) => {
        $home::$then! { $($first)*

    // Session

    /// Lists where arms could be, separated by blanks, and returns how many there are.
    Host None SearchDobot(list: Buffer, size: u32) in [v1 v2 v3] = |_, list, size| session::search(list, size);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer) in [v1]
        = |_, port, baud, firmware, version| session::connect_v1(port, baud, firmware, version);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, firmware: Buffer, version: Buffer, id: Out<i32>) in [v2]
        = |_, port, baud, firmware, version, id| session::connect_v2(port, baud, firmware, version, id);
    /// Connects to the arm at a port, or to the first that is found when no name is given.
    Host None ConnectDobot(port: Text, baud: u32, info: Out<ConnectInfo>) in [v3]
        = |_, port, baud, info| session::connect_v3(port, baud, info);
    /// Ends the connection. The arm goes on with what is in its queue.
    Host Master DisconnectDobot() in [v1 v2 v3] = session::disconnect;
    /// How long calls may take, in milliseconds: 3000 unless set. It may be set before there is a connection.
    Host Master SetCmdTimeout(milliseconds: u32) in [v1 v2 v3] = session::set_timeout;
    /// Returns at once: no event loop is needed.
    Host None DobotExec() in [v1 v2 v3] = |_| 0;
    /// Returns at once: nothing needs to be called again and again.
    Host None PeriodicTask() in [v1 v2 v3] = |_| 0;
    /// Puts the sentence of the calling thread's last fault into a text, as much as fits, and returns its length; 0 if
    /// there was none. The text may be null.
    Host None MagicianLastError(text: Buffer, size: u32) in [v1 v2 v3] = |_, text, size| session::last_error(text, size);
    /// Allows dangerous commands by their names, with commas between them, or `all`.
    Host None MagicianAllow(names: Text) in [v1 v2 v3] = |_, names| session::allow(names);

    // Pose

    /// Where the arm is.
    Command Arm GetPose(pose: Out<Pose>) in [v1 v2 v3] = |arm, pose| get(arm, pose);

    // Homing

    /// Homes the arm.
    Command Arm SetHOMECmd(command: In<HOMECmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, command, _, index| queue_in(arm, command, Always, index);

    // Jog

    /// Moves while a key is held; command 0 ends it.
    Command Arm SetJOGCmd(command: In<JOGCmd>, queued: Bool, index: Out<u64>) in [v1 v2 v3]
        = |arm, command, queued, index| queue_in(arm, command, Said(queued), index);

    // Queue

    /// Lets the queue run.
    Command Arm SetQueuedCmdStartExec() in [v1 v2 v3] = |arm| set(arm, &commands::QueuedCmdStartExec {});
    /// Index of the command that ended last.
    Command Arm GetQueuedCmdCurrentIndex(index: Out<u64>) in [v1 v2 v3] = |arm, index| call::current_index(arm, index);

        }
    };
}
