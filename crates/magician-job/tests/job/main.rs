//! Tests of jobs, teaching and manual jogging in one binary: `cargo test --test job pauses::` runs
//! those of a file.

mod fixtures;

mod burns;
mod early_ends;
mod killed;
mod lifecycle;
mod pause_steps;
mod pauses;
mod pendant;
mod speed;
mod teach;
