//! File formats for recordings of a Dobot Magician arm, and their analysis.
//!
//! * [`trace`]: all bytes of the lines, as pcapng.
//! * [`pieces`]: decodes such bytes into frames, damaged frames and noise; [`hex`] reads pasted
//!   text.
//! * [`Reading`]s of a host, written in any format ([`WriteReadings`]): rows ([`csv`]), JSON lines
//!   (`jsonl`, feature `json`), or a recording (`mcap`, feature `mcap`).
//! * `mcap`: recordings on a clock, as MCAP for Foxglove and similar viewers. With feature `sim`
//!   also the complete state of a virtual arm (`mcap::Recorder`).
//! * `replay` (feature `sim`): sends a trace to a virtual arm again and compares the answers.
//! * `law` (features `mcap` and `sim`): measures how far the poses of a trace or of readings are
//!   from the law of motion.
//!
//! The crate knows formats only: everything goes through `std::io::Write` or byte slices. It opens
//! no file, has no thread and reads no clock, so all of it builds for `wasm32-unknown-unknown`.
//!
//! # Why the virtual arm is an optional feature
//!
//! Without `sim` the crate depends on the protocol alone, so a driver that writes traces does not
//! compile a simulator. Two parts need a virtual arm: the recorder of its state and the replay of a
//! trace. Both follow a `Controller` on its clock, one as an observer, the other by advancing it.
//! They are here, above the simulator, so that the simulator knows no file format; and not in the
//! driver, so that a page in a browser can record and replay without one.
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

/// Compiles the program in the README as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
