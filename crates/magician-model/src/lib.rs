//! What the commands of the protocol mean to the arm's motions.
//!
//! [`MotionSettings`] are the values that hosts set and motions depend on, and the speeds, heights and tool bias that follow
//! from them, [`Capped`] what the arm lowers to its ceilings; [`PtpMove`] is a point-to-point command as a request for the planner. Neither `magician-protocol` nor
//! `magician-motion` can say that, as they do not know each other.
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
