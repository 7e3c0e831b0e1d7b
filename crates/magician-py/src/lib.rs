//! What the Python package is made of: the driver, the virtual arm and the programs, for Python.
//!
//! The public interface is written in Python (`python/magician`), where it has its names, its types and its
//! documentation. Here is what it stands on, one class each, without a word of its own:
//!
//! * [`core::Core`] is a connected arm. Every method returns a [`call::Call`] at once.
//! * [`call::Call`] is something under way: a thread waits for it with the interpreter free and interrupts heard, or an
//!   event loop is told when it has ended. So the blocking and the asyncio interface are the same one twice.
//! * [`values`] carries the fields of any command between Python and the protocol's table.
//! * [`program::PyPlan`] is a plan, [`run`] has an arm do it, [`cell::Cell`] is a virtual arm seen from outside,
//!   [`picture::Picture`] what either shows of itself.
//! * [`errors`] makes Python's exceptions of the driver's errors, by their kind alone.

mod call;
mod cell;
mod core;
mod errors;
mod picture;
mod program;
mod run;
mod runtime;
mod values;

use pyo3::prelude::*;

/// The native part of `magician`.
#[pymodule]
mod _magician {
    #[pymodule_export]
    use crate::call::Call;
    #[pymodule_export]
    use crate::cell::Cell;
    #[pymodule_export]
    use crate::core::Core;
    #[pymodule_export]
    use crate::picture::{Ink, Picture};
    #[pymodule_export]
    use crate::program::{PyPlan, Start};
    #[pymodule_export]
    use crate::run::{Course, draw_arm};
}
