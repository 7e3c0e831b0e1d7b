//! Tests of drawings and programs from file to arm in one binary:
//! `cargo test --test program gcode::` runs those of a file.

mod interrupted;

mod accepted;
mod bad_options;
mod check;
mod curves;
mod drawn;
mod ending;
mod fills;
mod fit;
mod framed;
mod gcode;
mod held;
mod hops;
mod in_front;
mod lossy;
mod order;
mod page;
mod parts;
mod placing;
mod playback_rail;
mod points;
mod prepared;
mod properties;
mod rehearse;
mod remedies;
mod samples;
mod stopped;
mod testgrid;
mod transparent;
