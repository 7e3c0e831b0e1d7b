//! Measurements of an arm and the line to it, as shown by `magician doctor` and `magician bench`.
//!
//! * Computed rates of a line: [`Exchange`] and [`LineSpeed`].
//! * Measurements that only read, harmless on any arm: [`round_trips`], [`reads`],
//!   [`back_to_back`], [`listen`].
//! * Faults of an arm, as data: [`Diagnosis`].
//! * Measurements that use the queue: [`queue_trial`] with commands that do nothing; [`streamed`]
//!   and [`stops`] with a path that the arm really draws ([`Ring`]).
//! * Measurements without an arm: [`added_latency`].
//!
//! Only the diagnosis judges whether a value is good.
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
pub use added::{AddedLatency, added_latency};
pub use cpu::processor_time;
pub use diagnosis::{
    Advice, Diagnosis, DiagnosisObserver, Finding, Measured, NoArm, Part, try_queue,
};
pub use exchange::{Exchange, Mixed};
pub use hearing::{OTHER_SPEEDS, ProbeReply, hear_datagrams, listen};
pub use line_speed::LineSpeed;
pub use rates::{Rate, Timed, reads, round_trips};
pub use ring::Ring;
pub use spread::Timings;
pub use stopping::{Stops, stops};
pub use stream::{Load, StreamResult, streamed};
pub use trial::{BackToBack, QueueTrial, back_to_back, queue_trial};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
