//! Integration tests of the virtual arm in one program. `cargo test --test virtual_arm queue::`
//! runs those of one file.

mod arm;
mod host;

mod alarms;
mod arc;
mod contracts;
mod cp;
mod document;
mod fidelity;
mod flash;
mod golden;
mod homing;
mod hosts;
mod io;
mod jog;
mod lost_step;
mod motion;
mod offline;
mod periods;
mod profile;
mod properties;
mod queue;
mod rail;
mod runner;
mod scenario;
mod seams;
mod steppers;
mod structure;
mod teaching;
mod trigger;
mod values;
