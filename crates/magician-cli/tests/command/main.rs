//! Tests of the command as a process: started, fed, killed, its output read.
//!
//! One test program, so that shared code is compiled and linked once. `cargo test --test command
//! pads::` runs the tests of one file.

mod magician;

mod arm;
mod beside;
mod calibrate;
mod closed;
mod config;
mod conform;
mod dashboard;
mod debts;
mod decode;
mod doctor;
mod doors;
mod ending;
mod files;
mod floods;
mod framing;
mod full_disk;
mod homing;
mod hostile;
mod interrupt;
mod laser;
mod lives;
mod offline;
mod options;
mod pads;
mod pause;
mod power;
mod presets;
mod proxy;
mod record;
mod replay;
mod resume;
mod run;
mod screen;
mod serve;
mod sim;
mod site;
mod station_ends;
mod suspend;
mod terminal;
mod through;
mod trace;
mod unattended;
mod waits;
