//! Raw frames of programs written for other libraries (`magician.compat`).

use magician::preflight::Guards;
use magician::protocol::{Ctrl, Row};
use magician::{Arm, Error, ErrorKind, FrameBuf, QueueIndex, Result, Set};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::call::Call;
use crate::core::Core;
use crate::errors;

/// A frame to send, and its treatment.
struct Request {
    id: u8,
    ctrl: Ctrl,
    params: Vec<u8>,
    /// True to wait for room in a full queue, which must be running.
    patient: bool,
}

impl Request {
    /// True if it queues a command in a form known to the driver. The driver accounts for those and
    /// never sends them twice.
    fn is_queued(&self) -> bool {
        let row = Row::with_id(self.id).filter(|row| row.queueable);
        self.ctrl == Ctrl::QUEUED && row.is_some() && Set::decode(self.id, &self.params).is_ok()
    }

    /// Sends the frame. Returns Ctrl and parameters of the reply.
    async fn exchange(&self, arm: &Arm) -> Result<(u8, Vec<u8>)> {
        if !self.is_queued() {
            let reply: FrameBuf = arm.raw(self.id, self.ctrl, &self.params).await?;
            let frame = reply.frame();
            return Ok((frame.ctrl().0, frame.params().to_vec()));
        }
        loop {
            match arm.enqueue_form(self.id, &self.params).await {
                Ok(index) => return Ok((self.ctrl.0, index.0.to_le_bytes().to_vec())),
                Err(error) if error.kind() == ErrorKind::QueueFull && self.patient => {
                    // There is room once the next command has finished. The wait fails if the queue
                    // cannot continue.
                    let ended = arm.queue().current_index().await?;
                    arm.wait(QueueIndex(ended.0.saturating_add(1))).await?;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Refuses a dangerous command unless `allow` names it.
    fn permit(&self, allow: &str) -> Result<()> {
        let row = Row::with_id(self.id).filter(|row| !self.is_read_only(row));
        let Some((row, danger)) = row.and_then(|row| Some((row, row.danger()?))) else {
            return Ok(());
        };
        let named = |name: &str| Row::find(name.trim()).is_ok_and(|found| found.id == row.id);
        if allow
            .split(',')
            .any(|name| name.trim() == "all" || named(name))
        {
            return Ok(());
        }
        let name = row.form_name(self.ctrl);
        let message = format!(
            "it {danger} and was not sent; MAGICIAN_ALLOW={name} in the environment allows it"
        );
        Err(Error::invalid(message).with_command(name))
    }

    fn is_read_only(&self, row: &Row) -> bool {
        // A switch of the firmware is sent as a read with parameters, so Ctrl alone does not tell.
        row.only_looks(self.ctrl) && (row.query.is_some() || self.params.is_empty())
    }
}

#[pymethods]
impl Core {
    /// Starts the queue if it is empty.
    fn start_empty_queue(&self, py: Python<'_>) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::plain(async move {
            arm.queue().start_if_empty().await?;
            Ok(())
        }))
    }

    /// Sends a frame. Returns Ctrl and parameters of the reply.
    fn exchange(
        &self,
        py: Python<'_>,
        id: u8,
        ctrl: u8,
        params: Vec<u8>,
        patient: bool,
        allow: &str,
    ) -> PyResult<Call> {
        let ctrl = Ctrl(ctrl);
        let request = Request {
            id,
            ctrl,
            params,
            patient,
        };
        request
            .permit(allow)
            .map_err(|error| errors::raise(py, &error))?;
        // Programs for those libraries expect every command to be sent. Their interfaces have
        // neither a permission for the laser nor a holder for jogs.
        let arm = self.burning(py, true)?.front_end().passing_jogs();
        let exchange = async move { request.exchange(&arm).await };
        Ok(Call::start(exchange, |py, (ctrl, params)| {
            Ok((ctrl, PyBytes::new(py, &params))
                .into_pyobject(py)?
                .into_any()
                .unbind())
        }))
    }

    /// Waits until a queued command has finished. A refused motion counts as finished; `look`
    /// detects it by its alarm.
    fn finished(&self, py: Python<'_>, index: u64, look: bool) -> PyResult<Call> {
        let arm = self.arm(py)?;
        Ok(Call::plain(async move {
            arm.wait(QueueIndex(index)).await?;
            if look {
                arm.front_end().check_alarms(&[], Guards::default()).await
            } else {
                Ok(())
            }
        }))
    }
}

/// Finds the id of a command by its vendor name or alias.
#[pyfunction]
pub(crate) fn command_id(name: &str) -> Option<u8> {
    Row::find(name).ok().map(|row| row.id)
}
