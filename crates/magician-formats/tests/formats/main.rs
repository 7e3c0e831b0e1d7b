//! Files and what they become: `cargo test --test formats gcode::` does those of a format.

mod gcode;
mod hpgl;
mod no_loss;
mod plan;
mod studio;
mod svg;
mod words;
