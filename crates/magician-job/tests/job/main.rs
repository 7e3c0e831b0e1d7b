//! Jobs, teaching and moving by hand, one program: `cargo test --test job pauses::` does those of a file.

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
