//! Where the arm is and how it moves (model sections 4, 7, 11 and 14).
//!
//! All that moves is a [`Trajectory`](magician_motion::Trajectory): it has a beginning and an end,
//! and is asked where it is. What it is for, and what follows it, is its [`MotionKind`]. Planning
//! looks at an [`ArmView`] and changes nothing; [`Motion`] changes when a plan begins or ends.

mod homing;
mod jog;
mod kind;
pub(crate) mod limits;
mod outputs;
mod path;
pub(crate) mod plan;
mod rail;
mod state;
mod true_pose;
mod view;

pub(crate) use jog::JogPlan;
pub(crate) use kind::{Jogged, MotionKind, Stage};
pub(crate) use outputs::Outputs;
pub(crate) use path::{PathLine, PathPoint, Segment};
pub(crate) use rail::RailPath;
pub(crate) use state::{Ended, Motion, Start};
pub(crate) use view::ArmView;
