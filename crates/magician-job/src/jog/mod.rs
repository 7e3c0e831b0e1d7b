//! Moving an arm by hand, with a teach pendant, buttons on a page, keys: which order each control comes to ([`Pendant`]), the
//! control that has to be held ([`HoldToRun`]), and the arm that takes the orders ([`PendantSession`]).
//!
//! Nothing here knows a key, a picture or a sentence: what an order and its end look like is for the program that has the controls.

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
