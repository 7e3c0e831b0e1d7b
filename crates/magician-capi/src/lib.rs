//! The vendor's C interface, `DobotDll`, on top of the driver: the code shared by three libraries.
//!
//! The vendor's library comes in three families, which export the same names with incompatible
//! arguments: `v1` without ids, `v2` with a leading `dobotId`, `v3` with a leading `masterId` and
//! `slaveId`. One binary cannot serve them all, so the packages `magician-capi-v1` to `-v3` are
//! three shared libraries of one line each: [`export!`].
//!
//! * `functions.rs` is a table with one row per function: its arguments without the ids, the
//!   families that have it, and its body. [`FUNCTIONS`] is the same table as data.
//! * [`session`] holds the connected arms and everything common to all calls; [`call`] has the few
//!   operations of which most functions consist.
//! * [`mod@pointer`] wraps the pointers of the caller, and is the only place that touches its
//!   memory.
//! * [`headers`] generates the C headers of each family from a common source.
//! * [`structure`] maps C structures to rows of the protocol with the same layout.
//!
//! This crate knows nothing about robots: layouts come from the protocol's table, behaviour from
//! the driver.

mod abi;
pub mod call;
mod code;
pub mod functions;
pub mod headers;
mod helper_thread;
mod log;
mod notice;
pub mod pointer;
pub mod session;
pub mod structure;
mod voice;

pub use abi::{Family, Function, Ids, Kind};
pub use code::{Code, Fault, Outcome};
pub use functions::FUNCTIONS;

#[doc(hidden)]
pub use abi::{guard, on_arm};
