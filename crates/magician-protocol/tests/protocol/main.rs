//! Tests of table, frames and bytes in one program: `cargo test --test protocol golden::` runs
//! those of one file.

mod material;

mod alarms;
mod arguments;
mod control;
mod deframer;
mod faults;
mod golden;
mod json;
mod leniencies;
mod ranges;
mod round_trip;
mod table;
mod vectors;
