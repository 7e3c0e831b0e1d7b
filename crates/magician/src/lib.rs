//! Driver for the Dobot Magician desktop arm: the whole protocol, typed, async and blocking, over
//! USB serial, Wi-Fi, TCP, Bluetooth LE (feature `ble`, off by default), and to a virtual arm in this process.
//!
//! * [`Arm`] is a connected arm for programs on tokio, [`blocking::Arm`] the same for all others.
//! * [`Target`] says where the arm is; [`ports`](fn@ports) lists where it could be.
//! * [`build`] makes commands of intentions, [`preflight`] checks them; [`commands`] has every command of the protocol.
//! * [`connection`] is the engine under both handles, without I/O and without a clock.
//! * [`proxy`] lets several programs share one arm.
//! * `serve` (feature `serve`) has listening ends for other programs: pseudo-terminals, TCP, UDP, discovery.
//!
//! Lengths are mm, angles degrees, times seconds unless a name says otherwise. An erratum (E37) that is cited is in
//! `docs/reference/ERRATA.md` of the repository, a model section in `docs/reference/MODEL.md`.
//!
//! This is a convenience, not a safety function. The protocol has no heartbeat: an arm whose host
//! dies without a word finishes what is in its queue.
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
//! Programs of a page or less in `examples`, each for one thing. All take a port as their first argument, `sim` if there is none:
//! `cargo run -p magician --example pose -- sim`. On a real arm those that move it say so; keep clear of it.
//!
//! | example | what it shows |
//! |---|---|
//! | `pose` | what an arm says of itself; nothing moves |
//! | `pick_and_place` | the suction cup, and lists of commands that are checked before they run |
//! | `two_arms` | two arms at once, async |
//! | `stop` | a program without end, and a stop from another thread |
//! | `jog` | a jog for as long as a key is held |
//! | `sensor` | a colour sensor, an infrared sensor, and an input that the arm waits for |
//! | `alarm` | what an error tells of an alarm, and how a program goes on after it |
//! | `reconnect` | a run that outlives a cable which is pulled |
//! | `transport` | a transport of one's own |
//! | `scenario` | a program with a test: an arm in a world that is looked at in the end |
//! | `sort` | all of it: a cell with a belt, sensors and cubes |
//! | `drawing` | as many short segments as a line carries, measured |
//! | `serve` | a virtual arm for other programs |
//! | `path` (of `magician-job`) | a plan as a job: its progress, a pause, and on |
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
// Without lines there is a `Port` to name, and none to list or to find again.
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
    HomingRecord, Jog, JogOptions, Laser, Lifted, Link, Motors, Options, Pins, Progress, Queue,
    Ran, Run, RunOptions, Sample, Samples, SettingsBackup, StateOptions, StateWatch, Status,
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
    ArmSnapshot, Level, LightsOut, Pin, StateReadings, sets_in_motion,
};
pub use magician_host::{
    Act, Action, ArmOutputs, Error, ErrorCode, ErrorKind, Given, GripperState, Message,
    MessageValue, OptionName, PinUse, REST_READ_INTERVAL, REST_TIME, Remedy, RestDetector, Result,
    Setting, Voice, build, burns, connection, message, preflight, proxy, stream,
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
