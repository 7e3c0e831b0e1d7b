//! Driver for the Dobot Magician arm.
