//! Programs for DobotLink, on a station.
//!
//! DobotLab's scripts, DobotEDU, DobotRPC and dobotkit speak JSON-RPC to the vendor's DobotLink. [`Link`] is one connection of such
//! a program, without I/O and clock: it takes their calls, makes calls of a station's API of them, and answers as DobotLink
//! does. What moves the arm, and who may, is decided by the station alone.
//!
//! * [`METHODS`](methods()): the vendor's 149 calls as data (`methods.toml`).
//! * [`Link`]: the connection.
//! * [`LinkReport`]: which calls came, and what was odd about them.

#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod answers;
mod calls;
mod error;
mod link;
mod methods;
mod params;
mod report;
mod results;
mod rpc;
mod waits;
mod wire;

pub use error::{ErrorCode, LinkError};
pub use link::{Link, LinkOptions, StationCall};
pub use methods::{Access, Class, Kind, Method, Param, ResultField, VirtualAnswer, Wire, methods};
pub use report::{LinkReport, Noted};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
