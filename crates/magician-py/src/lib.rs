//! Native part of the Python package: driver, virtual arm and programs, exposed to Python.
//!
//! The public interface is written in Python (`python/magician`), with its names, types and
//! documentation. This crate provides the operations underneath it, without any names or texts of
//! its own:
//!
//! * [`core::Core`] is a connected arm. Every method that takes time returns a [`call::Call`] at
//!   once.
//! * [`call::Call`] is an operation in progress. A thread waits for it with the interpreter's lock
//!   released and signals handled, or an event loop is notified when it has ended. Therefore the
//!   blocking and the asyncio interface share one implementation.
//! * [`values`] converts commands between Python and the protocol's table.
//! * [`serving`] offers virtual and shared arms to other programs.
//! * [`traffic`] decodes the bytes of a line; [`recording`] records an arm and replays sessions.
//! * [`teaching`] builds a program from points that a person shows the arm; [`calibrate`] evaluates
//!   touched points.
//! * [`frames`] sends the raw frames of programs written for other libraries.
//! * [`program::PyPlan`] is a plan, [`run`] runs it on an arm, [`cell::Cell`] is a virtual arm with
//!   its world, [`picture::Picture`] an image of any of them.
//! * [`simulation`] steps virtual arms directly, without a driver.
//! * [`station`] is a session at a station, and arms reached through it.
//! * [`command`] is the `magician` command, linked in.
//! * [`mod@conform`] runs the conformance suite on an arm, [`mod@doctor`] diagnoses an arm and its
//!   line.
//! * [`examinations`] runs these two on threads of their own, as calls.
//! * [`kinematics`] computes poses and joint angles of whole arrays.
//! * [`errors`] maps errors of the driver to Python exceptions, by their kind alone; [`voice`]
//!   words their remedies as Python calls.
//! * [`runtime`] owns the threads of the package, and [`logging`] forwards the driver's log.

mod calibrate;
mod call;
mod cell;
mod command;
mod conform;
mod core;
mod doctor;
mod errors;
mod examinations;
mod files;
mod frames;
mod kinematics;
mod logging;
mod picture;
mod program;
mod recording;
mod run;
mod runtime;
mod serving;
mod simulation;
mod station;
mod teaching;
mod traffic;
mod values;
mod voice;

use pyo3::prelude::*;

/// The native part of `magician`.
// Keeps the GIL on in a free-threaded Python. The classes are frozen and nothing is unsafe, but no
// such Python was available to run the tests on.
#[pymodule(gil_used = true)]
mod _magician {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::calibrate::{
        save_sheet, save_surface, save_tip, sheet_from_touches, stored_settings, tip_from_touches,
    };
    #[pymodule_export]
    use crate::call::Call;
    #[pymodule_export]
    use crate::cell::Cell;
    #[pymodule_export]
    use crate::command::run_command;
    #[pymodule_export]
    use crate::conform::conform;
    #[pymodule_export]
    use crate::core::{Core, Events, Feed, Jog, Program, StateWatch};
    #[pymodule_export]
    use crate::core::{command, decode, discover, encode, end, find, forked, ports, tools};
    #[pymodule_export]
    use crate::doctor::doctor;
    #[pymodule_export]
    use crate::errors::every_error;
    #[pymodule_export]
    use crate::files::{check_distinct, write_whole};
    #[pymodule_export]
    use crate::frames::command_id;
    #[pymodule_export]
    use crate::kinematics::{forward, inverse, inverse_of, reach};
    #[pymodule_export]
    use crate::picture::{Ink, Picture, draw_arm};
    #[pymodule_export]
    use crate::program::{PyPlan, Start};
    #[pymodule_export]
    use crate::recording::{Recording, replay};
    #[pymodule_export]
    use crate::run::Job;
    #[pymodule_export]
    use crate::serving::{Served, serve_proxy, serve_sim};
    #[pymodule_export]
    use crate::simulation::{Saved, Sims};
    #[pymodule_export]
    use crate::station::{Notices, Station};
    #[pymodule_export]
    use crate::teaching::Lesson;
    #[pymodule_export]
    use crate::traffic::{hex_bytes, pieces};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        use magician::build::{CONVEYOR_FARTHEST, CONVEYOR_FASTEST, CONVEYOR_PULSES_PER_MM};

        crate::runtime::first_interpreter(module.py())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("CONVEYOR_PULSES_PER_MM", CONVEYOR_PULSES_PER_MM)?;
        module.add("CONVEYOR_FASTEST", CONVEYOR_FASTEST)?;
        module.add("CONVEYOR_FARTHEST", CONVEYOR_FARTHEST)
    }
}
