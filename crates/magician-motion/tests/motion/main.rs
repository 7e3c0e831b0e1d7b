//! Integration tests of geometry, paths and velocity profiles in one program.
//! `cargo test --test motion jump::` runs those of one file.

mod support;

mod arc;
mod arc_crossings;
mod braking;
mod continuous_path;
mod crossings;
mod jog;
mod jump;
mod kinematics;
mod law;
mod look_ahead;
mod min_duration;
mod point_to_point;
mod ruckig;
mod velocity_profile;
