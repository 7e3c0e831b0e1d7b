//! Translation of the vendor's DobotLink protocol to the API of a station. No I/O, no clock.
//!
//! DobotLab's scripts, DobotEDU, DobotRPC and dobotkit speak JSON-RPC to DobotLink, a program for
//! Windows and macOS. A [`Link`] is one connection of such a program: it takes the program's calls,
//! translates each into calls of a station's API, and answers as DobotLink does. It does not decide
//! who may move the arm: the program is a session of the station like any other.
//!
//! * [`METHODS`](methods()): the vendor's 149 calls as data (`methods.toml`).
//! * [`Link`]: the connection, a state machine.
//! * [`LinkReport`]: counts of calls, unknown parameters and errors.
//!
//! Behaviour of DobotLink that moves an arm by mistake is not imitated: a lost answer is not
//! repeated, and a missing coordinate is an error instead of 0. `docs/guide/LINK.md` lists the
//! differences.

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
pub use methods::{
    Access, AnswerTime, Method, Param, ParamType, ResultField, VirtualAnswer, WireType, methods,
};
pub use report::{AnsweredCall, LinkReport};

/// Compiles the program in the README as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
