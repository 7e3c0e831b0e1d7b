//! What the Python package is made of: the driver, the virtual arm and the programs, for Python.
//!
//! The public interface is written in Python (`python/magician`), where it has its names, its types and its
//! documentation. Here is what it stands on, one class each, without a word of its own:
//!
//! * [`core::Core`] is a connected arm. Every method returns a [`call::Call`] at once.
//! * [`call::Call`] is something under way: a thread waits for it with the interpreter free and interrupts heard, or an
//!   event loop is told when it has ended. So the blocking and the asyncio interface are the same one twice.
//! * [`values`] carries the fields of any command between Python and the protocol's table.
//! * [`frames`] are what programs for other people's libraries send.
//! * [`errors`] makes Python's exceptions of the driver's errors, by their kind alone.

mod call;
mod core;
mod errors;
mod frames;
mod runtime;
mod values;

use pyo3::prelude::*;

/// The native part of `magician`.
#[pymodule]
mod _magician {
    #[pymodule_export]
    use crate::call::Call;
    #[pymodule_export]
    use crate::core::Core;
    #[pymodule_export]
    use crate::frames::{command_id, serial_ports};
}
