//! Search for a device by name or address.

use std::time::Duration;

use btleplug::api::{Central, Peripheral as _, ScanFilter};
use btleplug::platform::{Adapter, Peripheral};
use tokio::runtime::Handle;
use tokio::time::{Instant, sleep};

use super::roles::SERVICE;
use super::{radio, trouble};
use crate::{Error, ErrorCode, Result, message};

/// Duration of a scan. Choice: devices that save power advertise about every two seconds.
const SCAN: Duration = Duration::from_secs(10);
/// Interval at which found devices are examined. Choice.
const LOOK: Duration = Duration::from_millis(200);

/// Device found.
#[derive(Clone, Debug, Default, PartialEq)]
struct Seen {
    name: Option<String>,
    address: String,
    /// Id given by the system, for systems that hide the address.
    id: String,
    /// True if it advertises the service of an arm.
    arm: bool,
    /// True if it is connected or was just found; the system may also list devices from earlier.
    present: bool,
    /// True if it was the last one found for this name.
    before: bool,
}

/// Result of matching a name.
#[derive(Debug, PartialEq)]
enum NameMatch {
    /// Index of the only match.
    One(usize),
    /// No match yet.
    None,
    /// Indices of several matches.
    Several(Vec<usize>),
}

/// Finds the device with this name or address.
pub(super) async fn find(adapter: &Adapter, wanted: &str) -> Result<Peripheral> {
    let (mut devices, mut seen) = look(adapter, wanted).await?;
    let mut meaning = meaning(&seen, wanted, false);
    if meaning == NameMatch::None {
        let _scan = Scan::start(adapter).await?;
        let end = Instant::now() + SCAN;
        while meaning == NameMatch::None && Instant::now() < end {
            sleep(LOOK).await;
            (devices, seen) = look(adapter, wanted).await?;
            meaning = self::meaning(&seen, wanted, false);
        }
    }
    if meaning == NameMatch::None {
        meaning = self::meaning(&seen, wanted, true);
    }
    match meaning {
        NameMatch::One(index) if index < devices.len() => Ok(devices.swap_remove(index)),
        NameMatch::Several(indices) => Err(several(wanted, &seen, &indices)),
        // No device, or an index that the list has lost meanwhile.
        _ => Err(not_found(wanted, &seen)),
    }
}

/// Lists the devices that the system knows.
async fn look(adapter: &Adapter, wanted: &str) -> Result<(Vec<Peripheral>, Vec<Seen>)> {
    let before = radio::remembered(wanted);
    let all = adapter.peripherals().await.map_err(trouble::of_system)?;
    let (mut devices, mut seen) = (Vec::new(), Vec::new());
    for device in all {
        // The device has disappeared meanwhile.
        let Ok(Some(properties)) = device.properties().await else {
            continue;
        };
        let address = device.address().to_string();
        let connected = device.is_connected().await.unwrap_or(false);
        seen.push(Seen {
            arm: (properties.services.iter()).any(|one| one.as_u128() == SERVICE),
            present: connected || properties.rssi.is_some(),
            // Some systems name a nameless device by its address.
            name: (properties.advertisement_name.or(properties.local_name))
                .filter(|name| !same(name, &address)),
            address,
            id: device.id().to_string(),
            before: before.as_ref() == Some(&device.id()),
        });
        devices.push(device);
    }
    Ok((devices, seen))
}

/// Matches a name. Devices that the system only remembers match if `absent` is set. Among several
/// the last one used wins, then the only arm.
fn meaning(seen: &[Seen], wanted: &str, absent: bool) -> NameMatch {
    let fits = |one: &Seen| one.is(wanted) && (absent || one.present);
    let some = |also: &dyn Fn(&Seen) -> bool| -> Vec<usize> {
        let all = seen.iter().enumerate();
        let all = all.filter(|(_, one)| fits(one) && also(one));
        all.map(|(index, _)| index).collect()
    };
    let all = some(&|_| true);
    let narrower = [all.clone(), some(&|one| one.before), some(&|one| one.arm)];
    if all.is_empty() {
        return NameMatch::None;
    }
    let one = narrower.iter().find(|some| some.len() == 1);
    match one.and_then(|some| some.first()) {
        Some(&index) => NameMatch::One(index),
        None => NameMatch::Several(all),
    }
}

impl Seen {
    fn is(&self, wanted: &str) -> bool {
        let name = self.name.as_deref().unwrap_or_default().to_lowercase();
        name == wanted.to_lowercase()
            || self.id.eq_ignore_ascii_case(wanted)
            || same(wanted, &self.address)
    }

    fn describe(&self) -> String {
        let address = match self.address.as_str() {
            "00:00:00:00:00:00" => &self.id,
            address => address,
        };
        let arm = if self.arm { ", an arm" } else { "" };
        match &self.name {
            Some(name) => format!("{name} ({address}{arm})"),
            None => format!("{address} (no name{arm})"),
        }
    }
}

/// True if two addresses are equal, whichever separators they use.
fn same(text: &str, address: &str) -> bool {
    text.replace('-', ":").eq_ignore_ascii_case(address)
}

fn not_found(wanted: &str, seen: &[Seen]) -> Error {
    let mut heard: Vec<&Seen> = seen.iter().filter(|one| one.present).collect();
    heard.sort_by_key(|one| (!one.arm, one.name.is_none(), one.describe()));
    let heard: Vec<String> = heard.into_iter().map(Seen::describe).collect();
    let heard = match heard.as_slice() {
        [] => message!("no devices were found"),
        heard => message!("found: {devices}", devices = heard.join(", ")),
    };
    let message = message!(
        "no Bluetooth device has the name or address {wanted}; {heard}. Is the arm switched on, \
            its Bluetooth module plugged in, and no phone or other computer connected to it?",
        wanted,
        heard
    );
    Error::new(ErrorCode::NoArm, message)
}

fn several(wanted: &str, seen: &[Seen], indices: &[usize]) -> Error {
    let all = indices.iter().filter_map(|&index| seen.get(index));
    let all: Vec<String> = all.map(Seen::describe).collect();
    let message = message!(
        "several Bluetooth devices have the name {wanted}: {devices}; use the address instead, as \
            in ble:AA:BB:CC:DD:EE:FF",
        wanted,
        devices = all.join(", ")
    );
    Error::new(ErrorCode::SeveralArms, message)
}

/// Scan of the adapter for all advertising devices; stops on drop. It is not limited to the
/// service, because a module may advertise that only after connecting.
struct Scan {
    adapter: Adapter,
    runtime: Handle,
}

impl Scan {
    async fn start(adapter: &Adapter) -> Result<Self> {
        let started = adapter.start_scan(ScanFilter::default()).await;
        started.map_err(trouble::of_system)?;
        Ok(Self {
            adapter: adapter.clone(),
            runtime: Handle::current(),
        })
    }
}

impl Drop for Scan {
    fn drop(&mut self) {
        let adapter = self.adapter.clone();
        radio::see_off(&self.runtime, async move {
            let _ = adapter.stop_scan().await;
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(name: &str, address: &str) -> Seen {
        Seen {
            name: Some(name.to_owned()),
            address: address.to_owned(),
            present: true,
            ..Seen::default()
        }
    }

    const A: &str = "C0:FF:EE:00:00:01";
    const B: &str = "C0:FF:EE:00:00:02";

    #[test]
    fn names_and_addresses_are_read_without_regard_to_case() {
        let all = [seen("Pulse", B), seen("Magician", A)];
        for wanted in [
            "Magician",
            "mAGICIAN",
            A,
            "c0:ff:ee:00:00:01",
            "c0-ff-ee-00-00-01",
        ] {
            assert_eq!(meaning(&all, wanted, false), NameMatch::One(1), "{wanted}");
        }
        for wanted in ["Magic", "Magician ", "C0:FF:EE:00:00:03"] {
            assert_eq!(meaning(&all, wanted, false), NameMatch::None, "{wanted}");
        }
    }

    #[test]
    fn what_is_only_remembered_counts_last() {
        let mut all = [seen("Magician", A), seen("Magician", B)];
        all[0].present = false;
        assert_eq!(meaning(&all[..1], "Magician", false), NameMatch::None);
        assert_eq!(meaning(&all[..1], "Magician", true), NameMatch::One(0));
        assert_eq!(meaning(&all, "Magician", false), NameMatch::One(1));
    }

    #[test]
    fn ambiguous_name_prefers_last_used_then_only_arm() {
        let both = [seen("Magician", A), seen("Magician", B)];
        assert_eq!(
            meaning(&both, "Magician", false),
            NameMatch::Several(vec![0, 1])
        );
        let message = several("Magician", &both, &[0, 1]).to_string();
        assert!(message.contains(A) && message.contains(B), "{message}");

        let mut arm = both.clone();
        arm[1].arm = true;
        assert_eq!(meaning(&arm, "Magician", false), NameMatch::One(1));
        arm[0].before = true;
        assert_eq!(meaning(&arm, "Magician", false), NameMatch::One(0));
    }

    #[test]
    fn a_name_that_is_not_there_tells_what_is() {
        let mut all = [seen("Pulse", B), seen("Magician", A), seen("Gone", A)];
        all[1].arm = true;
        all[2].present = false;
        let message = not_found("Dobot", &all).to_string();
        let heard = format!("found: Magician ({A}, an arm), Pulse ({B}).");
        assert!(message.contains("name or address Dobot"), "{message}");
        assert!(message.contains(&heard), "{message}");
        assert!(
            not_found("Dobot", &[])
                .to_string()
                .contains("no devices were found")
        );
    }
}
