//! Driver for the Dobot Magician arm.
#![forbid(unsafe_code)]

pub mod connection;
