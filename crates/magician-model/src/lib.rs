//! Meaning of the protocol's commands for the arm's motions.
//!
//! `magician-protocol` has the commands and `magician-motion` the maths, and neither knows the
//! other. This crate connects them, for the virtual arm and the host alike: [`MotionSettings`]
//! holds the settings that motions depend on and derives speeds, jump heights and tool bias from
//! them; [`Capped`] lowers settings to the arm's ceilings; [`PtpMove`] turns a point-to-point
//! command into a request for the planner.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod ceilings;
mod ptp;
mod settings;

pub use ceilings::Capped;
pub use ptp::PtpMove;
pub use settings::{MotionSettings, tool_to_wire};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
