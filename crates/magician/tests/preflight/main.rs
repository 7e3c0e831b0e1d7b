//! The check before a program, against the virtual arm.

mod bench;
mod firmware;
mod guards;
mod moves;
mod programs;
mod times;
