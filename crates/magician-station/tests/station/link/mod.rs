//! Programs for DobotLink at a station with a virtual arm, in virtual time.

mod access;
mod every_call;
mod program;
mod queue;
