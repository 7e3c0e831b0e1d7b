//! Geometry, paths and velocity profiles, one program: `cargo test --test motion jump::` does those of a file.

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
