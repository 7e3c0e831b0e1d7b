//! Lines to real arms: serial, UDP, TCP.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_protocol::BAUD_RATE;

use super::{Transport, search, serial, tcp, udp};
use crate::connection::Settings;
use crate::ports::{self, Port, Remembered};
use crate::{Error, Result, Target, message};

/// Longest time for a name lookup, and for accepting a connection. Choice.
pub(super) const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// Opens lines to one arm, and remembers the adapter at which it was found.
#[derive(Debug, Default)]
pub(super) struct Lines {
    adapter: Mutex<Option<Remembered>>,
}

impl Lines {
    /// Opens a line; returns its settings, and the attempt in words for error messages.
    pub(super) async fn open(
        &self,
        target: &Target,
    ) -> Result<(Box<dyn Transport>, Settings, &'static str)> {
        match target {
            Target::Udp { host, port } => {
                let socket = udp::open(host, *port).await?;
                Ok((Box::new(socket), Settings::DATAGRAMS, "UDP"))
            }
            Target::Tcp { host, port } => {
                let stream = tcp::connect(host, *port).await?;
                Ok((Box::new(stream), Settings::ORDERED, "TCP"))
            }
            // Serial ports by any name; other targets are handled by the route.
            _ => {
                let settings = Settings {
                    baud: Some(BAUD_RATE),
                    // The vendor's DobotLink and Arduino library do this on real arms (errata E06).
                    reads_beside: true,
                    ..Settings::ORDERED
                };
                Ok((
                    Box::new(self.serial(target).await?),
                    settings,
                    "115200 baud",
                ))
            }
        }
    }

    /// Opens a serial port, and remembers its adapter for a reconnect.
    async fn serial(&self, target: &Target) -> Result<serial::Serial> {
        let adapter = self.remembered().clone();
        let present = match (&adapter, target) {
            // The given name is enough, so a system that cannot list ports does not prevent
            // opening.
            (None, Target::Serial(_)) => ports::ports().unwrap_or_default(),
            // To find an adapter or a serial number the list is essential, so its error counts.
            _ => ports::ports()?,
        };
        let (path, port) = match (target, &adapter) {
            (Target::Arm(serial), _) => search::arm(serial, &in_turn(&present, &adapter)).await?,
            (_, Some(adapter)) => open_at(adapter.find(&present)?)?,
            (Target::Usb { .. }, None) => open_at(search::adapter(target, &present)?)?,
            (target, None) => open_at(target.to_string())?,
        };
        if adapter.is_none() {
            *self.remembered() = Some(Remembered::new(&path, &present));
        }
        tracing::debug!(target = %target, path, "serial port opened");
        Ok(port)
    }

    fn remembered(&self) -> MutexGuard<'_, Option<Remembered>> {
        self.adapter.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns the error for a host that cannot be reached.
pub(super) fn unreachable_host(host: &str, port: u16, error: io::Error) -> Error {
    let message = message!(
        "{host} port {port} cannot be reached: {cause}",
        host,
        port,
        cause = error.to_string()
    );
    Error::port(message, error)
}

fn open_at(path: String) -> Result<(String, serial::Serial)> {
    let port = serial::open(&path)?;
    Ok((path, port))
}

/// Returns the ports of likely arms, the last adapter used first.
fn in_turn(present: &[Port], adapter: &Option<Remembered>) -> Vec<Port> {
    let last = adapter.as_ref().and_then(|one| one.find(present).ok());
    let mut likely: Vec<Port> = (present.iter())
        .filter(|port| port.likely_arm())
        .cloned()
        .collect();
    likely.sort_by_key(|port| last.as_ref() != Some(&port.path));
    likely
}
