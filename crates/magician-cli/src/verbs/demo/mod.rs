//! Demonstration.
mod picture;
mod scene;
