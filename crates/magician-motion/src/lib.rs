//! Kinematics, limits, paths and speed laws of the Dobot Magician arm.
