use std::time::Duration;

use magician::protocol::{Ctrl, Row};
use magician::{Arm, Error, Options, Set, Target};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::call::Call;
use crate::{errors, values};

/// A connected arm.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Core {
    pub(crate) arm: Arm,
}

/// The row of a command by its id.
fn row(id: u8) -> PyResult<&'static Row> {
    Row::with_id(id).ok_or_else(|| PyKeyError::new_err(format!("no command has the id {id}")))
}

/// A command that is set, from the values of its fields.
pub(crate) fn command(py: Python<'_>, id: u8, fields: &Bound<'_, PyTuple>) -> PyResult<Set> {
    let row = row(id)?;
    let Some(layout) = row.set else {
        let error = Error::invalid("it cannot be set, only read").with_command(row.name);
        return Err(errors::raise(py, &error));
    };
    let params = values::encode(layout, fields)?;
    Set::decode(id, &params).map_err(|error| errors::raise(py, &Error::from(error)))
}

#[pymethods]
impl Core {
    /// Connects to the arm at a port.
    #[staticmethod]
    #[pyo3(signature = (port, *, timeout, window))]
    fn connect(py: Python<'_>, port: &str, timeout: f64, window: usize) -> PyResult<Call> {
        let target: Target = port.parse().map_err(|error| errors::raise(py, &error))?;
        let timeout = Duration::try_from_secs_f64(timeout);
        let timeout = timeout.map_err(|_| {
            let error = Error::invalid("the timeout must be a number of seconds, 0 or more");
            errors::raise(py, &error)
        })?;
        let options = Options::default().timeout(timeout).window(window);
        Ok(Call::start(
            async move { Arm::connect_with(&target, options).await },
            |py, arm| Ok(Py::new(py, Core { arm })?.into_any()),
        ))
    }

    /// Asks for the value of a command.
    fn get(&self, id: u8, fields: &Bound<'_, PyTuple>) -> PyResult<Call> {
        let row = row(id)?;
        let params = match row.query {
            Some(layout) => values::encode(layout, fields)?,
            None => Vec::new(),
        };
        let arm = self.arm.clone();
        let ask = async move { arm.raw(id, Ctrl::GET, &params).await };
        Ok(Call::start(ask, move |py, reply| {
            let Some(layout) = row.value else {
                return Ok(py.None());
            };
            let fields = values::decode(py, layout, reply.frame().params())?;
            Ok(fields.into_any().unbind())
        }))
    }

    /// Sets a value or orders an action, at once.
    fn set(&self, py: Python<'_>, id: u8, fields: &Bound<'_, PyTuple>) -> PyResult<Call> {
        let frame = magician::FrameBuf::set(&command(py, id, fields)?, Ctrl::SET);
        let frame = frame.map_err(|error| errors::raise(py, &Error::from(error)))?;
        let arm = self.arm.clone();
        Ok(Call::plain(async move {
            let frame = frame.frame();
            arm.raw(frame.id(), frame.ctrl(), frame.params())
                .await
                .map(drop)
        }))
    }

    /// Puts a command into the arm's queue and tells its index.
    fn enqueue(&self, py: Python<'_>, id: u8, fields: &Bound<'_, PyTuple>) -> PyResult<Call> {
        let command = command(py, id, fields)?;
        let arm = self.arm.clone();
        Ok(Call::start(
            async move { arm.enqueue_set(&command).await },
            |py, index| Ok(index.0.into_pyobject(py)?.into_any().unbind()),
        ))
    }

    /// Checks commands, runs them and waits for their end.
    fn perform(&self, py: Python<'_>, commands: Vec<(u8, Bound<'_, PyTuple>)>) -> PyResult<Call> {
        let commands = commands
            .into_iter()
            .map(|(id, fields)| command(py, id, &fields));
        let commands = commands.collect::<PyResult<Vec<Set>>>()?;
        let arm = self.arm.clone();
        Ok(Call::plain(async move {
            arm.perform(&commands).await.map(drop)
        }))
    }

    /// Homes the arm.
    fn home(&self) -> Call {
        let arm = self.arm.clone();
        Call::plain(async move { arm.home().await })
    }

    /// Stops the arm, whatever is going on.
    fn stop(&self) -> Call {
        let arm = self.arm.clone();
        Call::plain(async move { arm.stop().await })
    }

    /// Ends the connection.
    fn close(&self) -> Call {
        let arm = self.arm.clone();
        Call::plain(async move {
            arm.close().await;
            Ok(())
        })
    }
}
