//! Tests of images as laser power and as pen lines.

mod bench;
mod engrave;
mod lines;
mod outline;
mod plan;
