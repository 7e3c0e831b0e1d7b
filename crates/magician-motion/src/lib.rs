//! Kinematics, limits, paths and velocity profiles of the Dobot Magician arm.
//!
//! Pure mathematics: no clock, no I/O, no allocation, and the same results on every platform.
//! Lengths are in mm, angles in degrees, times in seconds, or in whole microseconds where a name
//! ends in `_us`. Sections of "the model" refer to `docs/reference/MODEL.md` in the repository.
//!
//! The path from a request to a position:
//!
//! 1. [`Planner`] turns a [`Move`], a [`Jog`] or a path segment into a [`Plan`].
//! 2. A plan holds a [`Trajectory`], cut at the first joint limit or edge of reach on the way, and
//!    the [`Crossing`] that describes the cut.
//! 3. [`Trajectory::sample`] gives joints and pose at any time, computed from the start of the
//!    motion.
//!
//! [`ArmModel`] holds the numbers of one firmware, [`MotionLaw`] the 20 ms periods in which a real
//! controller moves, and [`Fence`] the user's bounds for the tool tip.
//!
//! ```
//! use magician_motion::{ArmModel, Geometry, JointAngles, ToolBias};
//!
//! let arm = Geometry::magician(ToolBias::SUCTION);
//! let pose = arm.forward(&JointAngles::HOME);
//! assert!((pose.x - 259.104).abs() < 1e-3);
//!
//! let joints = arm.inverse_within(&pose, &ArmModel::MAGICIAN.limits)?;
//! assert!((joints.j2 - 45.0).abs() < 1e-9);
//! # Ok::<(), magician_motion::MotionError>(())
//! ```
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod angle;
mod apex;
mod arc;
mod arc_plan;
mod arc_reach;
mod arc_segment;
mod axis_motion;
mod boundary;
mod crossing;
mod error;
mod fence;
mod geometry;
mod jog;
mod joint_segment;
mod jump;
mod kinematics;
mod law;
mod limits;
mod line_segment;
mod link_table;
mod look_ahead;
mod min_duration;
mod model;
mod move_segment;
mod path_segment;
mod planner;
mod power_up;
mod roots;
mod segment;
mod speeds;
mod state;
mod tool_path;
mod top_view;
mod trajectory;
mod velocity_profile;
mod wrist;

pub use axis_motion::AxisMotion;
pub use error::{MotionError, SpeedQuantity, Unreachable};
pub use fence::{Breach, Cuboid, Fence, FenceError, FencePart};
pub use geometry::{Geometry, ParseToolError, ToolBias};
pub use jog::{Jog, JogAxis};
pub use jump::{JumpHeights, Transfer};
pub use kinematics::{JointAngles, Pose};
pub use law::MotionLaw;
pub use limits::{Bound, LIMIT_TOLERANCE, Limits, Range};
pub use link_table::{Link, LinkJoint, Shape};
pub use look_ahead::{CpSegment, CpSpeeds, LookAhead};
pub use model::{ArmModel, Ceilings, Homing, Paths, Rail};
pub use planner::{Crossing, Move, MoveKind, Plan, Planner, Target};
pub use power_up::{ArcDefaults, CpDefaults, JogDefaults, PowerUp, PtpDefaults};
pub use speeds::Speeds;
pub use state::ArmState;
pub use top_view::TopView;
pub use trajectory::Trajectory;
pub use velocity_profile::{KinematicLimits, VelocityProfile};

/// Compiles the program in the README as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
