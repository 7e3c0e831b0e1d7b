//! `ports`: lists serial ports, stations and arms on Wi-Fi.

use std::time::Duration;

use clap::Args;
use magician::discovery::{DiscoveredArm, Search};
use serde::Serialize;

use crate::columns::{Columns, note};
use crate::context::Context;
use crate::failure::Failure;
use crate::mdns::{self, FoundStation};
use magician::stations::stations;

/// Default time for arms on Wi-Fi and stations to answer. A choice.
const DEFAULT_SEARCH_TIME: Duration = Duration::from_secs(1);

/// List serial ports, stations, and arms on Wi-Fi
///
/// A port can be named by its path, by the ids of its USB adapter (`--port usb:10c4:ea60`, with
/// `:SERIAL` if there are several), or by the serial number of the arm behind it (`--port arm:SERIAL`).
#[derive(Args, Debug)]
pub(crate) struct Ports {
    /// Also search the local networks for arms, or query one host, which may be in another network
    #[arg(long, value_name = "HOST", num_args = 0..=1)]
    wifi: Option<Option<String>>,
    /// List only the ports and stations of this computer, without searching the network
    #[arg(long, conflicts_with = "wifi")]
    local: bool,
}

#[derive(Serialize)]
struct List {
    ports: Vec<Entry>,
    stations: Vec<FoundStation>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wifi: Option<Vec<WifiArm>>,
}

#[derive(Serialize)]
struct WifiArm {
    /// Value for `--port`.
    port: String,
    address: String,
    mac: String,
    name: String,
    version: Option<String>,
}

impl From<DiscoveredArm> for WifiArm {
    fn from(found: DiscoveredArm) -> Self {
        Self {
            port: found.target().to_string(),
            address: found.address.to_string(),
            mac: found.mac,
            name: found.name,
            version: found.version,
        }
    }
}

#[derive(Serialize)]
struct Entry {
    path: String,
    likely_arm: bool,
    usb: Option<Usb>,
}

#[derive(Serialize)]
struct Usb {
    vendor: u16,
    product: u16,
    name: Option<String>,
    manufacturer: Option<String>,
    serial: Option<String>,
    location: Option<String>,
    interface: Option<u8>,
}

impl From<magician::Port> for Entry {
    fn from(port: magician::Port) -> Self {
        Self {
            likely_arm: port.likely_arm(),
            path: port.path,
            usb: port.usb.map(|usb| Usb {
                vendor: usb.vendor,
                product: usb.product,
                name: usb.name,
                manufacturer: usb.manufacturer,
                serial: usb.serial,
                location: usb.location,
                interface: usb.interface,
            }),
        }
    }
}

impl Ports {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let ports: Vec<Entry> = magician::ports()?.into_iter().map(Entry::from).collect();
        let patience = context.global.timeout.unwrap_or(DEFAULT_SEARCH_TIME);
        // A query of one host does not ask for others.
        let asks = !self.local && !matches!(self.wifi, Some(Some(_)));
        let elsewhere = asks.then(|| std::thread::spawn(move || mdns::find(patience)));
        let wifi = match &self.wifi {
            None => None,
            Some(host) => Some(on_wifi(host.as_deref(), context)?),
        };
        let elsewhere = elsewhere.and_then(|search| search.join().ok());
        // Without a network there are no stations on it.
        let elsewhere = elsewhere.and_then(Result::ok).unwrap_or_default();
        let stations = all_stations(elsewhere);
        let list = List {
            ports,
            stations,
            wifi,
        };
        context.show(&list, |out| {
            let mut columns = Columns::default();
            for port in &list.ports {
                columns.row([port.path.as_str(), likely(port), &device(port)]);
            }
            for station in &list.stations {
                let arms = station.arms.join(", ");
                let about = format!("on {}: {arms}", station.name);
                columns.row([station.url.as_str(), "a station", &about]);
            }
            for arm in list.wifi.iter().flatten() {
                columns.row([arm.port.as_str(), "an arm", &module(arm)]);
            }
            columns.write(out)?;
            let on_usb = list.ports.iter().any(|port| port.likely_arm);
            match &list.wifi {
                Some(arms) if arms.is_empty() => note(NO_WIFI_ARM, out),
                None if !on_usb && list.stations.is_empty() => {
                    note(&no_arm_advice(list.ports.is_empty()), out)
                }
                _ => Ok(()),
            }
        })
    }
}

/// Merges the stations of this computer with those found on the network.
fn all_stations(elsewhere: Vec<FoundStation>) -> Vec<FoundStation> {
    let mut all: Vec<_> = stations()
        .into_iter()
        .map(|here| FoundStation {
            url: here.url.trim_end_matches('/').to_owned(),
            name: "this computer".to_owned(),
            arms: here.arms,
        })
        .collect();
    for found in elsewhere {
        if all.iter().all(|known| known.url != found.url) {
            all.push(found);
        }
    }
    all
}

/// Searches for arms on Wi-Fi.
fn on_wifi(host: Option<&str>, context: &Context) -> Result<Vec<WifiArm>, Failure> {
    let search = host.map_or_else(Search::networks, Search::host);
    let patience = context.global.timeout.unwrap_or(DEFAULT_SEARCH_TIME);
    let found = search.find_blocking(patience)?;
    Ok(found.into_iter().map(WifiArm::from).collect())
}

const NO_WIFI_ARM: &str = "no arm replied on Wi-Fi; is its module plugged in and its light \
    green? Networks behind a router are not searched: `magician ports --wifi HOST` queries one \
    address there";

/// Returns the advice for a user without an arm.
fn no_arm_advice(no_ports: bool) -> String {
    let found = if no_ports {
        "no serial ports"
    } else {
        "none of these looks like an arm"
    };
    format!(
        "{found}; is it switched on and plugged in? `magician ports --wifi` searches for an arm on \
            Wi-Fi, --port sim is a virtual arm"
    )
}

fn likely(port: &Entry) -> &'static str {
    if port.likely_arm { "likely an arm" } else { "" }
}

fn device(port: &Entry) -> String {
    let Some(usb) = &port.usb else {
        return "not USB".to_owned();
    };
    let name = usb.name.as_deref().unwrap_or_default();
    // On Windows the adapter's name usually begins with its manufacturer.
    let maker = usb.manufacturer.as_deref().unwrap_or_default();
    let maker = if name.starts_with(maker) { "" } else { maker };
    let serial = usb.serial.iter().map(|serial| format!(":{serial}"));
    let serial: String = serial.collect();
    let ids = format!("{:04x}:{:04x}{serial}", usb.vendor, usb.product);
    let words = [&ids, maker, name];
    words
        .into_iter()
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

fn module(arm: &WifiArm) -> String {
    let version = arm.version.as_deref().unwrap_or_default();
    let text = format!("{} {version} {}", arm.name, arm.mac);
    text.trim().to_owned()
}
