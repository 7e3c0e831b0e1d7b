//! The async handle over a virtual arm in this process, on a clock that jumps.

mod bench;
mod blocking;
mod bounded_jogs;
mod chaos;
mod checks;
mod clones;
mod desk;
mod endings;
mod fence;
mod fitted;
mod frames;
mod gate;
mod holds;
mod homing;
mod jog_figures;
mod jogs;
mod laser;
mod lines;
mod onlookers;
mod outputs;
mod over;
mod reconnecting;
mod runs;
mod streams;
mod verbs;
mod virtual_time;
