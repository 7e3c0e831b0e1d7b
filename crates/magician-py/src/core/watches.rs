//! State watches, events and jogs.

use std::sync::{Arc, Mutex as Lock, PoisonError};

use magician::build::JogDirection;
use magician::{Error, Event, JogOptions, Pin, StateOptions, Status};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use tokio::sync::Mutex;

use super::{Core, link, seconds};
use crate::call::Call;
use crate::runtime::Local;
use crate::{errors, values};

/// Watch of the arm's state.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct StateWatch {
    /// Two watches: one for waiting, one for reading without waiting.
    watches: Local<(Arc<Mutex<magician::StateWatch>>, magician::StateWatch)>,
}

/// Subscription to the arm's events.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Events {
    events: Local<Arc<Mutex<magician::Events>>>,
}

/// A jog under way.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Jog {
    jog: Local<Lock<Option<magician::Jog>>>,
}

/// Builds pins of one kind. The driver checks the addresses.
fn pins(py: Python<'_>, addresses: &[i64], kind: fn(u8) -> Pin) -> PyResult<Vec<Pin>> {
    let pin = |address: &i64| match u8::try_from(*address) {
        Ok(address) => Ok(kind(address)),
        Err(_) => {
            let message = format!("there is no pin {address}: EIO addresses are 1 to 20");
            Err(errors::raise(py, &Error::invalid(message)))
        }
    };
    addresses.iter().map(pin).collect()
}

#[pymethods]
impl Core {
    /// Watches the arm and these pins at a rate in Hz.
    fn state(
        &self,
        py: Python<'_>,
        rate: f64,
        inputs: Vec<i64>,
        outputs: Vec<i64>,
        analogs: Vec<i64>,
    ) -> PyResult<StateWatch> {
        let inputs = pins(py, &inputs, Pin::Input)?;
        let outputs = pins(py, &outputs, Pin::Output)?;
        let analogs = pins(py, &analogs, Pin::Analog)?;
        let options = StateOptions::at(rate).pins([inputs, outputs, analogs].concat());
        let arm = self.arm.get(py)?;
        let watch = || {
            let watch = arm.state_with(options.clone());
            watch.map_err(|error| errors::raise(py, &error))
        };
        Ok(StateWatch {
            watches: Local::new((Arc::new(Mutex::new(watch()?)), watch()?)),
        })
    }

    /// Subscribes to events from now on.
    fn events(&self, py: Python<'_>) -> PyResult<Events> {
        let events = self.arm.get(py)?.events();
        Ok(Events {
            events: Local::new(Arc::new(Mutex::new(events))),
        })
    }

    /// Starts a jog, which lasts while keep-alives arrive.
    fn jog(&self, command: &Bound<'_, PyAny>, keep: f64, ratio: Option<f32>) -> PyResult<Call> {
        let py = command.py();
        let direction = JogDirection::try_from(&values::command(command)?);
        let direction = direction.map_err(|error| errors::raise(py, &error))?;
        let mut options = JogOptions::default().keep(seconds(py, "keep", keep)?);
        options.ratio = ratio;
        let arm = self.arm(py)?;
        Ok(Call::start(
            async move { arm.jog_with(direction, options).await },
            |py, jog| {
                let jog = Local::new(Lock::new(Some(jog)));
                Jog { jog }.into_py_any(py)
            },
        ))
    }
}

#[pymethods]
impl StateWatch {
    /// Waits for the next reading.
    fn changed(&self, py: Python<'_>) -> PyResult<Call> {
        let watch = Arc::clone(&self.watches.get(py)?.0);
        Ok(Call::start(
            async move { watch.lock().await.changed().await },
            |py, status| parts(py, &status),
        ))
    }

    /// Latest reading.
    fn latest(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        let latest = self.watches.get(py)?.1.latest();
        latest.map(|status| parts(py, &status)).transpose()
    }
}

/// Converts a state: pose, index, free space, alarms, link, age of the pose in seconds, and three
/// lists of pins with their values.
fn parts(py: Python<'_>, status: &Status) -> PyResult<Py<PyAny>> {
    let levels = |wanted: fn(Pin) -> bool| -> Vec<(u32, u16)> {
        let levels = status.pins.iter().filter(|level| wanted(level.pin));
        let levels = levels.map(|level| (level.pin.address().into(), level.value));
        levels.collect()
    };
    let parts = (
        values::pose(py, &status.pose)?,
        status.current.0,
        status.left_space,
        values::alarms(py, &status.alarms)?,
        link(&status.link),
        status.at.elapsed().as_secs_f64(),
        levels(|pin| matches!(pin, Pin::Input(_))),
        levels(|pin| matches!(pin, Pin::Output(_))),
        levels(|pin| matches!(pin, Pin::Analog(_))),
    );
    parts.into_py_any(py)
}

#[pymethods]
impl Events {
    /// Waits for the next event. Returns its name and parts, or `None` when the connection has
    /// ended.
    fn next(&self, py: Python<'_>) -> PyResult<Call> {
        let events = Arc::clone(self.events.get(py)?);
        Ok(Call::start(
            async move { Ok::<_, magician::Error>(events.lock().await.next().await) },
            |py, event| match event {
                Some(event) => event_parts(py, &event),
                None => Ok(py.None()),
            },
        ))
    }
}

fn event_parts(py: Python<'_>, event: &Event) -> PyResult<Py<PyAny>> {
    match event {
        Event::AlarmRaised { code } => ("AlarmRaised", (u32::from(*code),)).into_py_any(py),
        Event::AlarmCleared { code } => ("AlarmCleared", (u32::from(*code),)).into_py_any(py),
        Event::CommandFinished { first, last } => {
            ("CommandFinished", (first.0, last.0)).into_py_any(py)
        }
        Event::LinkLost { why } => ("LinkLost", (why.to_string(),)).into_py_any(py),
        Event::LinkFound { reset } => ("LinkFound", (*reset,)).into_py_any(py),
        Event::Reset { gone } => {
            let (first, last) = gone.unzip();
            (
                "Reset",
                (first.map(|first| first.0), last.map(|last| last.0)),
            )
                .into_py_any(py)
        }
        Event::Unaccounted { from, to } => ("Unaccounted", (from.0, to.0)).into_py_any(py),
        Event::Missed { events } => ("Missed", (*events,)).into_py_any(py),
        // An event without a Python class.
        other => ("Other", (format!("{other:?}"),)).into_py_any(py),
    }
}

#[pymethods]
impl Jog {
    /// Renews the keep-alive timeout of the jog.
    fn keep(&self, py: Python<'_>) -> PyResult<()> {
        let jog = self.jog.get(py)?.lock();
        let jog = jog.unwrap_or_else(PoisonError::into_inner);
        let kept = match &*jog {
            Some(jog) => jog.keep(),
            None => {
                let message = "the jog was ended";
                Err(Error::new(magician::ErrorCode::Closed, message))
            }
        };
        kept.map_err(|error| errors::raise(py, &error))
    }

    /// Ends the jog, and waits until the arm is at rest.
    fn stop(&self, py: Python<'_>) -> PyResult<Call> {
        let jog = self.jog.get(py)?.lock();
        let jog = jog.unwrap_or_else(PoisonError::into_inner).take();
        Ok(Call::lasting(async move {
            match jog {
                Some(jog) => jog.stop().await,
                None => Ok(()),
            }
        }))
    }
}
