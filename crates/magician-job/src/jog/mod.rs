//! Manual jogging: controls and the orders they give ([`Pendant`]), the hold-to-run control
//! ([`HoldToRun`]), and the session that carries out orders on an arm ([`PendantSession`]).
//!
//! No keys, pictures or sentences here: the program with the controls presents orders and their
//! outcomes.

mod hold;
mod order;
mod pendant;
mod session;
mod tools;
mod worker;

pub use hold::{HoldAction, HoldToRun};
pub use magician::build::{Axis, JogDirection, UnknownAxis};
pub use order::{Activity, OrderDone, OrderError, PendantOrder, ToolOrder};
pub use pendant::{JogFrame, JogMode, Pendant};
pub use session::{PendantEvent, PendantSession, device_name, rail_position};
pub use tools::ToolState;
