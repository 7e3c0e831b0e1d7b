//! The protocol's chapters: what each command does. A chapter is named after the document's.

mod alarm;
mod arc;
mod calibration;
mod cp;
mod home;
mod info;
pub(crate) mod io;
mod jog;
mod lost_step;
mod pose;
mod ptp;
mod queue;
pub(crate) mod teach;
mod tool;
pub(crate) mod trigger;
mod wait;
mod wifi;
