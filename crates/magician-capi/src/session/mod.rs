//! The connected arms, and everything common to all calls.
//!
//! * [`Registry`] maps ids to arms. The library has one, to whose methods the functions of this
//!   module forward. Each test creates its own.
//! * [`Session`] is one connected arm, through which every call passes.
//!
//! A call holds no lock while it waits for an arm, with one exception: `ConnectDobot` of `v1` holds
//! one, so a concurrent `ConnectDobot` of `v1` waits until it returns.

mod arm;
mod connect;
mod danger;
mod doubt;
mod place;
mod pool;
mod registry;
mod search;
mod standstill;
mod text_probe;

use std::ffi::c_int;
use std::sync::LazyLock;

use crate::code::Outcome;
use crate::pointer::{Buffer, Out, Text};
use crate::structure::ConnectInfo;
use crate::{Family, notice};

pub use arm::Session;
pub use place::Environment;
pub use registry::{Registry, Timeouts};

/// The registry of the library.
static ARMS: LazyLock<Registry> = LazyLock::new(Registry::default);

/// Runs the body of a function on a connected arm; see [`Registry::run`].
pub fn run(
    family: Family,
    name: &'static str,
    id: c_int,
    body: impl FnOnce(&Session) -> Outcome,
) -> c_int {
    ARMS.run(family, name, id, body)
}

/// `SearchDobot`; see [`Registry::search`].
pub fn search(list: Buffer, size: u32) -> c_int {
    ARMS.search(list, size)
}

/// `ConnectDobot` of `v1`; see [`Registry::connect_v1`].
pub fn connect_v1(port: Text, baud: u32, firmware: Buffer, version: Buffer) -> c_int {
    ARMS.connect_v1(port, baud, firmware, version)
}

/// `ConnectDobot` of `v2`; see [`Registry::connect_v2`].
pub fn connect_v2(port: Text, baud: u32, firmware: Buffer, version: Buffer, id: Out<i32>) -> c_int {
    ARMS.connect_v2(port, baud, firmware, version, id)
}

/// `ConnectDobot` of `v3`; see [`Registry::connect_v3`].
pub fn connect_v3(port: Text, baud: u32, info: Out<ConnectInfo>) -> c_int {
    ARMS.connect_v3(port, baud, info)
}

/// `DisconnectDobot`; see [`Registry::disconnect`].
pub fn disconnect(id: c_int) -> c_int {
    ARMS.disconnect(id)
}

/// `SetCmdTimeout`; see [`Registry::set_timeout`].
pub fn set_timeout(id: c_int, milliseconds: u32) -> c_int {
    ARMS.set_timeout(id, milliseconds)
}

/// `MagicianAllow`; see [`Registry::allow`].
pub fn allow(names: Text) -> c_int {
    ARMS.allow(names)
}

/// `MagicianLastError`: writes the sentence of the calling thread's last fault, truncated to fit.
/// Returns its full length without the NUL, or 0 if there was no fault.
pub fn last_error(text: Buffer, size: u32) -> c_int {
    let sentence = notice::sentence();
    text.put(sentence.as_bytes(), size as usize);
    c_int::try_from(sentence.len()).unwrap_or(c_int::MAX)
}
