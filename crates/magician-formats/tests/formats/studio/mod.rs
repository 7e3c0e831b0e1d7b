//! Programs from DobotStudio, read and run on the virtual arm.

mod blockly;
mod blockly_blocks;
mod blockly_refusals;
mod machine;
mod playback;
mod playback_refusals;
mod playback_writing;
