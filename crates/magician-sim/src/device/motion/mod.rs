//! State and motion of the arm (model sections 4, 7, 11 and 14).
//!
//! Everything that moves is a [`Trajectory`](magician_motion::Trajectory), which answers where it
//! is at any time. Its [`MotionKind`] says what follows its end. Planning works on an [`ArmView`]
//! and changes nothing; [`Motion`] changes only when a plan begins or ends.
//!
//! The commanded state and the true pose are separate: GetPose reports the commanded one, and lost
//! steps or an unknown base angle are the difference, which only the world and homing see.

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
pub(crate) use kind::{HomingStage, JogTarget, MotionKind};
pub(crate) use outputs::Outputs;
pub(crate) use path::{PathLine, PathPoint, Segment};
pub(crate) use rail::RailPath;
pub(crate) use state::{Motion, MotionEnd, PlannedMotion};
pub(crate) use view::ArmView;
