//! Programs whose commands are supplied while they run.

use std::sync::Arc;

use magician::{Feeder, RunOptions};
use pyo3::prelude::*;

use super::Core;
use super::motion::{guards, run_summary};
use crate::call::Call;
use crate::runtime::Local;
use crate::values;

/// Feed of commands into a run.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Feed {
    feeder: Local<Arc<Feeder>>,
}

#[pymethods]
impl Core {
    /// Starts a run that is fed at most `ahead` commands ahead of the arm. Returns the feed, and
    /// the call for the end.
    fn stream(
        &self,
        py: Python<'_>,
        ahead: usize,
        skip: Vec<String>,
        allow_laser: bool,
    ) -> PyResult<(Feed, Call)> {
        let guards = guards(py, &skip, false)?;
        let arm = self.burning(py, allow_laser)?;
        let (feeder, run) = arm.stream(ahead, RunOptions::default().guards(guards));
        let call = Call::moving(&arm, |_| run.wait(|_| {}), run_summary);
        let feeder = Local::new(Arc::new(feeder));
        Ok((Feed { feeder }, call))
    }
}

#[pymethods]
impl Feed {
    /// Number of commands that can be fed now.
    fn free(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.feeder.get(py)?.free().unwrap_or(0))
    }

    /// Number of commands finished by the arm, as last read.
    fn finished(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.feeder.get(py)?.finished())
    }

    /// Waits for room. Returns true if the run accepts more commands.
    fn room(&self, py: Python<'_>) -> PyResult<Call> {
        let feeder = Arc::clone(self.feeder.get(py)?);
        let room = async move { Ok::<_, magician::Error>(feeder.has_room().await) };
        Ok(Call::start(room, |py, room| {
            Ok(room.into_pyobject(py)?.to_owned().into_any().unbind())
        }))
    }

    /// Feeds the next command.
    fn push(&self, command: &Bound<'_, PyAny>) -> PyResult<()> {
        let feeder = self.feeder.get(command.py())?;
        feeder.push(values::command(command)?);
        Ok(())
    }

    /// Waits briefly, because no command is ready yet.
    fn rest(&self, py: Python<'_>) -> PyResult<Call> {
        let feeder = Arc::clone(self.feeder.get(py)?);
        Ok(Call::plain(async move {
            feeder.rest().await;
            Ok(())
        }))
    }

    /// Ends the feed: there are no more commands.
    fn end(&self, py: Python<'_>) -> PyResult<()> {
        self.feeder.get(py)?.end();
        Ok(())
    }
}
