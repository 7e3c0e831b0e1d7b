//! Files of what a Dobot Magician arm did.
//!
//! * [`trace`]: everything that passed on the lines, byte for byte, as pcapng.
//! * [`pieces`]: what such bytes are: frames with their meaning, damaged ones, noise; [`hex`]: the text that people paste.
//! * [`Reading`]s of a host, written to a file of any format ([`WriteReadings`]): as rows ([`csv`]), as JSON lines (`jsonl`,
//!   feature `json`), as a recording (`mcap`, feature `mcap`).
//! * `mcap`: what an arm did on a clock, as MCAP for Foxglove and its like; with feature `sim` also all that a virtual arm
//!   shows (`mcap::Recorder`).
//! * `replay` (feature `sim`): a trace sent to a virtual arm once more, and the answers compared.
//! * `law` (features `mcap` and `sim`): how far the poses of a trace or of readings are from the law of motion.
//!
//! Formats only: everything goes through `std::io::Write` or slices of bytes. Nothing here opens a file, has a thread or
//! reads a clock, so all of it builds for `wasm32-unknown-unknown`.
//!
//! # Why a virtual arm is a feature here
//!
//! Without `sim` the crate knows the protocol alone: a driver that writes traces does not compile a simulator. What needs
//! a virtual arm is the recorder of its whole state and the replay of a trace. Both follow a `Controller` from instant to
//! instant of its clock: the one is its observer, the other lets its time pass. They stand here, above the simulator, so
//! that the simulator knows of no file format; and not in the driver, so that a page in a browser can record and replay
//! without one.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod csv;
pub mod hex;
#[cfg(feature = "json")]
pub mod jsonl;
#[cfg(all(feature = "mcap", feature = "sim"))]
pub mod law;
#[cfg(feature = "mcap")]
pub mod mcap;
pub mod pieces;
mod reading;
#[cfg(feature = "sim")]
pub mod replay;
pub mod trace;

pub use reading::{Reading, WriteReadings};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
