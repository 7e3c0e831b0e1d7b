//! Tests of the command as a process: started, fed, killed, its output read.
//!
//! One test program, so that shared code is compiled and linked once. `cargo test --test command
//! pads::` runs the tests of one file.

mod magician;

mod arm;
mod calibrate;
mod closed_terminal;
mod config;
mod conform;
mod dashboard;
mod decode;
mod doctor;
mod drawing_end;
mod files;
mod floods;
mod framing;
mod front_ends;
mod full_disk;
mod homing;
mod hostile;
mod interrupt;
mod laser;
mod offline;
mod options;
mod pads;
mod pause;
mod peripherals;
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
mod station_jobs;
mod suspend;
mod terminal;
mod through_station;
mod trace;
mod unattended;
mod unrestored_settings;
mod waits;
