//! The host's side of a Dobot Magician arm, without I/O and without a clock.
//!
//! All of it is sans-io state machines and pure functions: the caller passes bytes and instants in
//! and takes frames and events out. The crate `magician` drives them over real lines and re-exports
//! them; browser pages and other runtimes can do the same.
//!
//! * [`connection`] sends requests and matches replies to them; [`stream`] keeps any number of
//!   queued commands flowing over a connection; [`proxy`] shares one arm among several programs.
//! * [`admission`] decides which connection gives way when a listener has too many.
//! * [`build`] makes commands from intentions; [`preflight`] checks them before a byte is sent.
//! * [`picture`] tracks the state of an arm from the frames that pass; [`gate`] decides when a jog
//!   may begin.
//! * [`faults`] (feature) simulates a bad line from a seed; [`pair`] (feature) joins a host and a
//!   virtual arm on one virtual clock.
//!
//! Lengths are mm, angles degrees, times microseconds unless a name says otherwise. Errata (E37)
//! are listed in `docs/reference/ERRATA.md` of the repository, model sections in
//! `docs/reference/MODEL.md`.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod admission;
pub mod build;
mod burning;
pub mod connection;
mod error;
#[cfg(any(test, feature = "faults"))]
pub mod faults;
pub mod gate;
mod message;
#[cfg(any(test, feature = "pair"))]
pub mod pair;
pub mod picture;
pub mod preflight;
pub mod proxy;
mod remedy;
mod rest;
pub mod stream;

pub use burning::{
    LASER_POWER, LASER_SUPPLY, burns, frame_burns, frame_releases_queue, raises_laser_pin,
};
pub use error::{Error, ErrorCode, ErrorKind, Result};
pub use magician_model::{MotionSettings, PtpMove};
pub use magician_motion::{
    ArmModel, ArmState, Breach, Cuboid, Fence, FenceError, FencePart, Geometry, JointAngles,
    Limits, ToolBias, Trajectory, VelocityProfile,
};
pub use magician_protocol::{
    self as protocol, Alarm, AlarmSet, Ctrl, FrameBuf, QueuedCmdIndex as QueueIndex, Set, commands,
};
pub use message::{Message, MessageValue, OptionName, ToMessageValue, message_decimals};
pub use picture::{ArmOutputs, ArmPicture, GripperState};
#[cfg(feature = "counters")]
#[doc(hidden)]
pub use preflight::PLANNED;
pub use preflight::check_power;
pub use remedy::{Act, Action, PinUse, Remedy, SET_PIN, Setting, SettingValue, Voice};
pub use rest::{REST_READ_INTERVAL, REST_TIME, RestDetector};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
