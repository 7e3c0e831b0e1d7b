//! What is true of all calls: connecting, ids, timeouts, danger, doubt, threads. Each test has arms of its own.

mod bench;
mod calls;
mod connecting;
mod danger;
mod doubts;
mod fence;
mod ids;
mod searching;
mod standing;
mod threads;
#[cfg(unix)]
mod wires;
