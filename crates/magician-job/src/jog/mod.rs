//! Moving an arm by hand: what can be jogged, and the control that has to be held for it.

mod axis;
mod hands;
mod hold;

pub use axis::{Axis, Heading};
pub use hands::{Done, Hands, Order, OrderError, Ratios, ToolOrder, What};
pub use hold::{Hold, Turn};
