//! The table, frames and bytes, one program: `cargo test --test protocol golden::` does those of a file.

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
