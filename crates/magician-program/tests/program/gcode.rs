//! G-code: placement, motion, and marks on the paper.

mod arcs;
mod begin;
mod depths;
mod drawn;
#[path = "../../../magician-formats/tests/formats/gcode/reading.rs"]
mod reading;
mod refused;

use reading::*;
