//! Programs for DobotLink at a station with a virtual arm, in virtual time.

mod every_call;
mod program;
mod queue;
mod access;
