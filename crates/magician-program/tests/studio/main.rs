//! Programs made in DobotStudio, read and run on the virtual arm.

mod machine;
mod playback;
mod playback_refusals;
mod playback_writing;
