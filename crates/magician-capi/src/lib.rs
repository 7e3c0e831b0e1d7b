//! The vendor's C interface, `DobotDll`, on top of the driver: what the three shared libraries share.
//!
//! The vendor's library comes in three families that have the same names and incompatible arguments: `v1` without ids,
//! `v2` with a `dobotId` first, `v3` with a `masterId` and a `slaveId` first. One binary cannot serve them all, so the
//! packages `magician-capi-v1` to `-v3` are three shared libraries, each of one line: [`export!`].
//!
//! * The table in `functions.rs` says every function once: its arguments without the ids, the families that have
//!   it, and what it does. [`FUNCTIONS`] is the same table to look at.
//! * [`session`] is the connected arms and what is true of all calls; [`call`] is the verbs that most functions are.
//! * [`mod@pointer`] is what C hands over, and the only place that touches its memory.
//! * [`headers`] makes each family's C headers from their common source.
//! * [`structure`] names the C structures and the rows of the protocol that they are laid out as.
//!
//! No robot knowledge is here: layouts are the protocol's table, behaviour is the driver's.

mod abi;
pub mod call;
mod code;
pub mod functions;
pub mod headers;
mod log;
mod notice;
pub mod pointer;
pub mod session;
mod stand_in;
pub mod structure;
mod voice;

pub use abi::{Family, Function, Ids, Kind};
pub use code::{Code, Fault, Outcome};
pub use functions::FUNCTIONS;

#[doc(hidden)]
pub use abi::{guard, on_arm};
