//! Tests of file formats and of their content. `cargo test --test formats gcode::` runs those of
//! one format.

mod gcode;
mod hpgl;
mod no_loss;
mod plan;
mod studio;
mod svg;
mod words;
