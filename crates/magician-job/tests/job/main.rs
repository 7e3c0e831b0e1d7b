//! Tests of jobs, teaching and manual jogging in one binary: `cargo test --test job pauses::` runs
//! those of a file.

mod fixtures;

mod burns;
mod early_ends;
mod killed;
mod lifecycle;
mod pauses;
mod pendant;
mod speed;
mod teach;
mod pause_steps;
