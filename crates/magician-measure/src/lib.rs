//! Measurements of an arm and the line to it: what `magician doctor` and `magician bench` show.
//!
//! * What is computed: [`Exchange`] and [`LineSpeed`], the rates that a line allows.
//! * What only reads, and is harmless on any arm: [`round_trips`], [`reads`], [`back_to_back`], [`listen`].
//! * What is wrong with an arm, as data: [`Diagnosis`].
//! * What uses the queue: [`queue_trial`] with commands that do nothing; [`streamed`] and [`stops`] with a path that
//!   the arm really draws ([`Ring`]).
//! * What needs no arm: [`added_latency`].
//!
//! But for the diagnosis nothing here decides whether a figure is good.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(unix)]
mod added;
mod cpu;
mod diagnosis;
mod exchange;
mod hearing;
mod line_speed;
mod rates;
mod ring;
mod spread;
mod stopping;
mod stream;
mod tap;
#[cfg(test)]
mod tests;
mod trial;

#[cfg(unix)]
pub use added::{Added, added_latency};
pub use cpu::processor_time;
pub use diagnosis::{Advice, Attendant, Diagnosis, Finding, Measured, NoArm, Part, try_queue};
pub use exchange::{Exchange, Mixed};
pub use hearing::{Heard, OTHER_SPEEDS, hear_datagrams, listen};
pub use line_speed::LineSpeed;
pub use rates::{Rate, Timed, reads, round_trips};
pub use ring::Ring;
pub use spread::Spread;
pub use stopping::{Stops, stops};
pub use stream::{Load, Streamed, streamed};
pub use trial::{BackToBack, QueueTrial, back_to_back, queue_trial};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
