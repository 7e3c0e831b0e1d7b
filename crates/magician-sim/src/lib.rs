//! A virtual Dobot Magician controller: bytes in, bytes out, and time that the caller advances.
//!
//! [`Controller`] is the whole arm behind its connectors. It answers byte for byte as the real one
//! does, and keeps its queue, its alarms and its motion. It has no clock, no thread and no I/O: the
//! caller hands it bytes and instants. [`Runner`] puts it on a wall clock with a baud rate.
//!
//! A [`Profile`] holds the firmware: all values at power-up, and every choice made where no
//! document describes the behaviour. A [`World`] holds everything outside of the arm: table,
//! objects, belt, script. [`fidelity`] reports which assumptions an arm's answers have relied on.
//!
//! Errata (E37) are in `docs/reference/ERRATA.md` of the repository, model sections in
//! `docs/reference/MODEL.md`.
//!
//! ```
//! use magician_sim::{Controller, LinkId, Profile};
//!
//! let mut arm = Controller::new(Profile::default());
//! let usb = LinkId(0);
//!
//! // Disable the rail: an exchange captured from a real arm.
//! let replies = arm.exchange(usb, &[0xAA, 0xAA, 0x04, 0x03, 0x01, 0x01, 0x00, 0xFB]);
//! assert_eq!(replies[0].bytes(), [0xAA, 0xAA, 0x02, 0x03, 0x01, 0xFC]);
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod controller;
mod convert;
mod device;
pub mod document;
mod event;
pub mod fidelity;
mod link;
mod observer;
mod pace;
mod profile;
mod runner;
pub mod scenario;
mod state;
pub mod world;

pub use controller::Controller;
pub use device::io::pins::{PinState, Signal};
pub use device::io::steppers::{CONVEYOR_PULSES_PER_MM, StepperState};
pub use device::io::tools::ToolOutput;
pub use device::store::flash::{Flash, FlashError};
pub use event::{Event, Refusal};
pub use link::{LineState, LinkId};
pub use magician_protocol::{ArmInstant, HostInstant};
pub use observer::Observer;
pub use pace::{ArmClock, LineTiming, Speed, SpeedError};
pub use profile::{
    Defaults, FidelityRules, HandTeaching, Identity, JogAxisChange, LimitChoice, LimitSets,
    LostStepDefaults, MotionRules, Offline, PinFunctions, Pins, PowerUp, Profile, ProfileError,
    QueueRules, Stopping, Tools, Wifi, WifiDefaults,
};
pub use runner::Runner;
pub use scenario::{Scenario, ScenarioError};
pub use state::{ControllerState, QueueState};
pub use world::{ExternalEvent, World};

/// Microseconds of the arm's clock since the start of a motion: the time axis of trajectories.
pub(crate) type Micros = u64;

/// Compiles the program in the README as a doctest.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
