//! Tests of jobs, teaching and manual jogging in one binary: `cargo test --test job pauses::` runs
//! those of a file.

mod place;

mod burns;
mod ends;
mod killed;
mod life;
mod pauses;
mod pendant;
mod speed;
mod teach;
mod waits;
