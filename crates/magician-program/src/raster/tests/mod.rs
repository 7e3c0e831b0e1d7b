mod bench;
mod engrave;
mod lines;
mod outline;
mod plan;
