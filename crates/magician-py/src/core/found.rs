//! Search for arms at serial ports and on networks.

use std::time::Duration;

use magician::discovery::{DiscoveredArm, Search};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::seconds;
use crate::call::Call;
use crate::{errors, runtime};

/// Serial ports of this computer: path, vendor, product, name, manufacturer, serial number,
/// location, true if likely an arm.
#[pyfunction]
pub(crate) fn ports(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let ports = py.detach(magician::ports);
    let ports = ports.map_err(|error| errors::raise(py, &error))?;
    let ports = ports.into_iter().map(|port| {
        let likely_arm = port.likely_arm();
        let known = port.usb.is_some();
        let usb = port.usb.unwrap_or_default();
        (
            port.path,
            known.then_some(usb.vendor),
            known.then_some(usb.product),
            usb.name,
            usb.manufacturer,
            usb.serial,
            usb.location,
            likely_arm,
        )
    });
    PyTuple::new(py, ports.collect::<Vec<_>>())?.into_py_any(py)
}

/// Discovers arms on the networks or at these hosts: target, address, reported address, MAC
/// address, name, version.
#[pyfunction]
pub(crate) fn discover(py: Python<'_>, hosts: Vec<String>, within: f64) -> PyResult<Call> {
    let within: Duration = seconds(py, "within", within)?;
    runtime::ready(py)?;
    let mut hosts = hosts.into_iter();
    let search = match hosts.next() {
        None => Search::networks(),
        Some(first) => hosts.fold(Search::host(first), Search::and),
    };
    Ok(Call::start(
        async move { search.find(within).await },
        |py, found| {
            let found = found.iter().map(parts).collect::<Vec<_>>();
            PyTuple::new(py, found)?.into_py_any(py)
        },
    ))
}

type ArmParts = (String, String, String, String, String, Option<String>);

fn parts(found: &DiscoveredArm) -> ArmParts {
    (
        found.target().to_string(),
        found.address.to_string(),
        found.reported.to_string(),
        found.mac.clone(),
        found.name.clone(),
        found.version.clone(),
    )
}
