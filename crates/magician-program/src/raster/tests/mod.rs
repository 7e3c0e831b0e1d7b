mod bench;
mod engrave;
mod outline;
mod plan;
