//! Agreement of the parts of a picture.

mod frames;
mod law;
mod parts;
mod rig;
