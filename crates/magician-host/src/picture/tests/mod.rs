//! What the parts of a picture hold together.

mod frames;
mod law;
mod parts;
mod rig;
