//! Driver for the Dobot Magician desktop arm: the whole protocol, typed, async and blocking, over
//! USB serial, Wi-Fi, TCP, Bluetooth LE (feature `ble`, off by default), and to a virtual arm in
//! this process.
//!
//! * [`Arm`] is a connection to an arm for programs on tokio; [`blocking::Arm`] is the same for
//!   programs without a runtime.
//! * [`Target`] is the address of an arm; [`ports`](fn@ports) lists the ports of this computer.
//! * [`build`] makes commands from intentions (move, draw, grip); [`preflight`] checks them before
//!   they are sent; [`commands`] has every command of the protocol.
//! * [`connection`] is the protocol engine under both handles, without I/O and without a clock.
//! * [`proxy`] shares one arm among several programs.
//! * `serve` (feature `serve`) makes an arm available to other programs: pseudo-terminals, TCP,
//!   UDP, discovery.
//!
//! Lengths are in mm, angles in degrees and times in seconds unless a name says otherwise. Errata
//! (E37) are listed in `docs/reference/ERRATA.md` of the repository, model sections in
//! `docs/reference/MODEL.md`.
//!
//! This is a convenience, not a safety function. The protocol has no heartbeat: if the host dies,
//! the arm finishes the commands that are in its queue.
//!
//! ```
//! use magician::{blocking::Arm, build};
//!
//! # fn main() -> magician::Result<()> {
//! let arm = Arm::connect("sim")?; // or "/dev/ttyUSB0", "COM3", "udp:192.168.1.5"
//! arm.home()?;
//! arm.move_to(220.0, 0.0, 50.0, 0.0)?; // x, y, z in mm, r in degrees
//! assert_eq!(arm.pose()?.z, 50.0);
//! arm.run(&[
//!     build::jump_to(220.0, 60.0, -20.0, 0.0),
//!     build::suction(true),
//!     build::jump_to(220.0, -60.0, -20.0, 0.0),
//!     build::suction(false),
//! ])?; // checked as a whole before a byte of it is sent
//! arm.stop()?; // from any thread
//! # Ok(())
//! # }
//! ```
//!
//! # Examples
//!
//! Programs of a page or less in `examples`, one subject each. All take a port as their first
//! argument and default to `sim`: `cargo run -p magician --example pose -- sim`. Examples that move
//! a real arm say so; keep clear of it.
//!
//! | example | what it shows |
//! |---|---|
//! | `pose` | identity, pose and state of an arm; nothing moves |
//! | `pick_and_place` | the suction cup, and lists of commands that are checked before they run |
//! | `two_arms` | two arms at once, async |
//! | `stop` | an endless program, stopped from another thread |
//! | `jog` | a jog for as long as a key is held |
//! | `sensor` | a colour sensor, an infrared sensor, and an input that the arm waits for |
//! | `alarm` | the information in an alarm error, and how a program continues after it |
//! | `reconnect` | a run that survives a pulled cable |
//! | `transport` | a custom transport |
//! | `scenario` | a program with a test: an arm in a simulated world whose final state is checked |
//! | `sort` | everything together: a cell with a belt, sensors and cubes |
//! | `drawing` | measures how many short segments a second a line carries |
//! | `serve` | a virtual arm for other programs |
//! | `path` (of `magician-job`) | a plan as a job: progress, pause and resume |
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod arm;
#[cfg(feature = "config")]
pub mod arms;
pub mod blocking;
#[doc(hidden)]
pub mod dirs;
#[cfg(feature = "lines")]
pub mod discovery;
#[doc(hidden)]
pub mod files;
// Without `lines` the type `Port` still exists, but nothing lists ports or finds one again.
#[cfg_attr(not(feature = "lines"), allow(dead_code, unused_imports))]
mod ports;
mod raw;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "serve")]
pub mod serve;
#[cfg(feature = "sim")]
mod simulation;
#[cfg(feature = "stations")]
#[doc(hidden)]
pub mod stations;
mod target;
mod transport;
#[cfg(feature = "sim")]
mod virtual_arm;

pub use arm::{
    Arm, ArmIdentity, ClockRate, CommandSource, EndNotice, Event, Events, Feeder, Homing,
    HomingRecord, Jog, JogOptions, Laser, LiftResult, Link, Motors, Options, Pins, Progress, Queue,
    Run, RunOptions, RunSummary, Sample, Samples, SettingsBackup, StateOptions, StateWatch, Status,
    Stopper, Streaming,
};
#[doc(hidden)]
pub use arm::{FrontEnd, Permission};
pub use magician_host::admission;
#[cfg(feature = "faults")]
pub use magician_host::faults;
pub use magician_host::gate;
#[cfg(any(test, feature = "pair"))]
pub use magician_host::pair;
pub use magician_host::picture::{
    ArmSnapshot, LaserOffPose, Level, Pin, StateReadings, sets_in_motion,
};
pub use magician_host::{
    Act, Action, ArmOutputs, Error, ErrorCode, ErrorKind, GripperState, Message, MessageValue,
    OptionName, PinUse, REST_READ_INTERVAL, REST_TIME, Remedy, RestDetector, Result, Setting,
    SettingValue, Voice, build, burns, connection, message, preflight, proxy, stream,
};
pub use magician_motion::{
    ArmModel, ArmState, Breach, Cuboid, Fence, FenceError, FencePart, Geometry, JointAngles,
    Limits, ToolBias, Trajectory, VelocityProfile,
};
pub use magician_protocol::{
    self as protocol, Alarm, AlarmSet, Ctrl, FrameBuf, QueuedCmdIndex as QueueIndex, Set, commands,
};
#[cfg(feature = "sim")]
pub use magician_sim as sim;
pub use ports::{Adapter, Port, Usb, ports, unbound_adapters};
pub use raw::{LineOptions, RawLine};
#[cfg(feature = "sim")]
pub use simulation::{ActionKind, Observation, Simulation, StepAction};
pub use target::{IntoTarget, SimSpeed, Target};
#[cfg(feature = "trace")]
pub use transport::{Tap, Tracer};
#[cfg(feature = "sim")]
pub use virtual_arm::VirtualArm;

/// Compiles the README's program with the tests.
#[cfg(all(doctest, feature = "sim"))]
#[doc = include_str!("../README.md")]
struct Readme;
