//! The async handle over a virtual arm in this process, on a clock that jumps.

mod bench;
mod blocking;
mod checks;
mod endings;
mod holds;
mod lines;
mod runs;
mod verbs;
