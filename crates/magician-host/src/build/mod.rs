//! Builders of commands: functions named for the arm's motions, tools and settings.
//!
//! Each returns a command as a value and has no other effect. The driver's `Arm::run` checks a list
//! and runs it, `Arm::start` runs commands as they come, and `Arm::enqueue_set` takes a single one;
//! programs may keep and repeat commands, which are `Copy`.
//!
//! Lengths are mm, angles degrees. The frame is the arm's: origin where the base axis meets the
//! shoulder axis, X forward, Y to the arm's left, Z up. The table is below z = 0.
//!
//! ```
//! use magician_host::build;
//!
//! let pick = [
//!     build::jump_to(220.0, 40.0, -30.0, 0.0),
//!     build::suction(true),
//!     build::wait(std::time::Duration::from_millis(300)),
//!     build::jump_to(220.0, -40.0, -30.0, 0.0),
//!     build::suction(false),
//! ];
//! assert_eq!(pick.len(), 5);
//! ```

mod conveyor;
mod io;
mod jog;
mod motion;
mod rail;
mod sensor;
mod speed;
mod tool;

pub use conveyor::*;
pub use io::*;
pub use jog::{Axis, JogDirection, UnknownAxis};
pub use motion::*;
pub use rail::*;
pub use sensor::*;
pub use speed::*;
pub use tool::*;
