//! Streams against a virtual arm in virtual time: order, horizon, laser, losses, interruptions.

mod doubled;
mod entries;
mod flow;
mod full_line;
mod laser;
mod others;
mod recovery;
mod resuming;
mod rig;
