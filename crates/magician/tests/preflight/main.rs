//! The check before a program, against the virtual arm.

mod bench;
mod builders;
mod guards;
mod moves;
mod programs;
mod times;
