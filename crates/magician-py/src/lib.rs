//! What the Python package is made of: the driver, the virtual arm and the programs, for Python.
//!
//! The public interface is written in Python (`python/magician`), where it has its names, its types and its
//! documentation. Here is what it stands on, without a word of its own:
//!
//! * [`core::Core`] is a connected arm. Every method that takes time returns a [`call::Call`] at once.
//! * [`call::Call`] is something under way: a thread waits for it with the interpreter free and interrupts heard, or an
//!   event loop is told when it has ended. So the blocking and the asyncio interface are the same one twice.
//! * [`values`] carries commands between Python and the protocol's table.
//! * [`serving`] offers virtual arms, and arms that are shared, to other programs.
//! * [`traffic`] is what bytes of a line are; [`recording`] puts an arm on record, and replays a session.
//! * [`teaching`] is a program that a person shows the arm, [`calibrate`] what touched points come to.
//! * [`frames`] are what programs for other people's libraries send.
//! * [`program::PyPlan`] is a plan, [`run`] has an arm do it, [`cell::Cell`] is a virtual arm seen from outside,
//!   [`picture::Picture`] what either shows of itself.
//! * [`simulation`] has virtual arms that are stepped, without a driver.
//! * [`station`] is a session at a station, and an arm through it.
//! * [`command`] is the `magician` command, linked in.
//! * [`mod@conform`] runs the conformance suite on an arm, [`mod@doctor`] finds out what is wrong with it.
//! * [`apart`] is how those two run: on a thread of their own, as calls.
//! * [`kinematics`] computes poses and joint angles of whole arrays.
//! * [`errors`] makes Python's exceptions of the driver's errors, by their kind alone; [`voice`] says in them what a
//!   Python program does, not what the command line does.
//! * [`runtime`] has the package's threads and [`logging`] what the driver says.

mod apart;
mod calibrate;
mod call;
mod cell;
mod command;
mod conform;
mod core;
mod doctor;
mod errors;
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
// A free-threaded Python switches its lock on for it: the classes are frozen and nothing is unsafe, but no such Python was
// at hand to run the tests on.
#[pymodule(gil_used = true)]
mod _magician {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::calibrate::{
        keep_sheet, keep_surface, keep_tip, kept_settings, touched_sheet, touched_tip,
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
