//! Behaviour common to all calls: connecting, ids, timeouts, danger, doubt, threads. Each test has
//! its own registry.

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
