//! Bluetooth LE: one service of the document's Table 1, with two characteristics that carry bytes,
//! one in each direction.
//!
//! The properties of the characteristics decide which of them accepts writes, not the words of the
//! document (errata E50). A frame is split into as many writes as the link requires, and
//! notifications form a byte stream with no regard to frames, as on a serial line. The radio link
//! keeps the order and retransmits losses, so it is treated as an ordered line with a high latency.

mod link;
mod radio;
mod roles;
mod search;
mod trouble;

use std::sync::Arc;
use std::time::Duration;

use btleplug::api::{CharPropFlags, Peripheral as _, WriteType};
use btleplug::platform::{Adapter, Peripheral};
use tokio::runtime::Handle;
use tokio::time::timeout;

use crate::connection::Settings;
use crate::{Result, message};
use link::Port;

pub(crate) use link::Link;

/// Settings of a serial line with longer timeouts: an answer may take several connection intervals
/// of up to about 50 ms each, and more if the radio retransmits.
pub(super) const SETTINGS: Settings = Settings {
    initial_timeout: 1_000_000,
    floor: 300_000,
    ceiling: 4_000_000,
    ..Settings::ORDERED
};

/// Longest time for a device to accept a connection and list its services. Choice.
const CONNECT: Duration = Duration::from_secs(20);
/// Connection attempts: a first connection often breaks off at once on the air.
const ATTEMPTS: usize = 2;
/// Longest time for a device to list its characteristics and start notifications. Choice.
const PREPARE: Duration = Duration::from_secs(10);

/// Finds a device by its name or address, connects to it, and opens a line.
pub(super) async fn open(wanted: &str) -> Result<Link> {
    let adapter = radio::adapter().await?;
    let device = search::find(&adapter, wanted).await?;
    // A device connected by another program must stay connected when we leave.
    let found = device.is_connected().await.unwrap_or(false);
    let opening = Opening {
        wanted,
        device: Some(device.clone()),
        ours: !found,
    };
    opening.connect(&device).await?;
    let link = opening.prepare(&adapter, &device).await?;
    // Only after success: a name must not stick to a device that cannot be used.
    radio::remember(wanted, device.id());
    opening.keep();
    Ok(link)
}

/// Device that is disconnected again unless it becomes a line.
struct Opening<'a> {
    wanted: &'a str,
    device: Option<Peripheral>,
    /// True if this program connected it.
    ours: bool,
}

impl Opening<'_> {
    async fn connect(&self, device: &Peripheral) -> Result<()> {
        let connecting = async {
            let mut result = device.connect().await;
            for _ in 1..ATTEMPTS {
                if let Err(error) = &result {
                    tracing::debug!(%error, "ble:{}: reconnected", self.wanted);
                    result = device.connect().await;
                }
            }
            result
        };
        let connected = timeout(CONNECT, connecting).await;
        let connected = connected.unwrap_or(Err(btleplug::Error::TimedOut(CONNECT)));
        connected.map_err(|error| {
            trouble::of_device(self.wanted, &message!("cannot be connected"), error)
        })
    }

    /// Discovers its services and subscribes to notifications.
    async fn prepare(&self, adapter: &Adapter, device: &Peripheral) -> Result<Link> {
        let preparing = async {
            let failed = |error| {
                trouble::of_device(self.wanted, &message!("does not list its services"), error)
            };
            device.discover_services().await.map_err(failed)?;
            let (writes, notifies) = roles::settle(self.wanted, &device.services())?;
            let port = Port {
                device: device.clone(),
                kind: kind(writes.properties),
                writes,
                chunk: chunk(device.mtu()),
            };
            tracing::debug!(
                writes = %port.writes.uuid,
                kind = ?port.kind,
                chunk = port.chunk,
                notifies = %notifies.uuid,
                "ble:{}",
                self.wanted
            );
            let failed = |error| {
                trouble::of_device(self.wanted, &message!("does not send notifications"), error)
            };
            Link::over(adapter, Arc::new(port), notifies, self.ours)
                .await
                .map_err(failed)
        };
        let prepared = timeout(PREPARE, preparing).await;
        prepared.unwrap_or_else(|_| {
            let late = btleplug::Error::TimedOut(PREPARE);
            Err(trouble::of_device(
                self.wanted,
                &message!("cannot be used"),
                late,
            ))
        })
    }

    fn keep(mut self) {
        self.device = None;
    }
}

impl Drop for Opening<'_> {
    fn drop(&mut self) {
        let Some(device) = self.device.take().filter(|_| self.ours) else {
            return;
        };
        // Outside a runtime nothing can disconnect it; the system does so when the process ends.
        if let Ok(runtime) = Handle::try_current() {
            radio::see_off(&runtime, async move {
                let _ = device.disconnect().await;
            });
        }
    }
}

/// Returns the kind of write: without response if allowed. A write with response costs a round trip
/// over the air per 20 bytes, and a stop would wait for it. A response protects a device from being
/// flooded, which cannot happen if every request is answered before the next; other losses are
/// noticed by the missing answer.
fn kind(properties: CharPropFlags) -> WriteType {
    if properties.contains(CharPropFlags::WRITE_WITHOUT_RESPONSE) {
        WriteType::WithoutResponse
    } else {
        WriteType::WithResponse
    }
}

/// Returns the bytes per write: a packet minus its header of three bytes. The bounds are those of
/// the Bluetooth Core Specification for the packet of a new link, and for a value.
fn chunk(mtu: u16) -> usize {
    // Clamped, because the value comes unchecked from the system's Bluetooth stack.
    usize::from(mtu).saturating_sub(3).clamp(20, 512)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_without_response_is_chosen_where_it_is_allowed() {
        let both = CharPropFlags::WRITE | CharPropFlags::WRITE_WITHOUT_RESPONSE;
        assert_eq!(kind(both), WriteType::WithoutResponse);
        assert_eq!(kind(CharPropFlags::WRITE), WriteType::WithResponse);
    }

    #[test]
    fn writes_fit_the_packet() {
        for (mtu, bytes) in [(0, 20), (23, 20), (24, 21), (185, 182), (u16::MAX, 512)] {
            assert_eq!(chunk(mtu), bytes, "{mtu}");
        }
    }
}
