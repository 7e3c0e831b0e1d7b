//! State messages on the bus of a site, as JSON.
//!
//! They are public and unauthenticated: any host on the network can read and forge them. Nothing in
//! a message proves its sender, only a certificate of the site does. So parsing bounds all sizes.

use std::net::{IpAddr, SocketAddr};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{ArmReport, StationId};

/// Largest message, bytes: a roster of 10,000 arms with room to spare.
pub const MAX_MESSAGE_SIZE: usize = 2 * 1024 * 1024;
/// Largest state message, bytes. Usual ones have about a thousand. A hub keeps one for each arm, so
/// this bounds the memory that a hostile host with many arms can make it use.
const MAX_STATE_SIZE: usize = 32 * 1024;
/// Most addresses of a station that are tried. A machine rarely has more; the bound limits how many
/// connections a forged message can cause.
const MAX_ADDRESSES: usize = 8;

/// State of an arm as published by its station.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StateMessage {
    /// Id of the station.
    pub station: StationId,
    /// Addresses of the station's listener for the site. Empty if it has no certificate.
    #[serde(default)]
    pub at: Vec<SocketAddr>,
    /// [`ArmReport::port`].
    pub port: String,
    /// [`ArmReport::is_virtual`].
    #[serde(rename = "virtual")]
    pub is_virtual: bool,
    /// [`ArmReport::state`].
    pub state: Value,
}

impl StateMessage {
    /// Parses a message and drops the addresses that cannot be dialled. Returns `None` if it is
    /// malformed or too large.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        if bytes.len() > MAX_STATE_SIZE {
            return None;
        }
        let mut message: Self = serde_json::from_slice(bytes).ok()?;
        message.at.retain(is_unicast);
        message.at.truncate(MAX_ADDRESSES);
        Some(message)
    }

    /// Converts the message to the report of a station on `machine`.
    #[must_use]
    pub fn report(self, machine: &str) -> ArmReport {
        ArmReport {
            machine: machine.to_owned(),
            port: self.port,
            is_virtual: self.is_virtual,
            state: self.state,
        }
    }
}

/// True for a unicast address with a port. Unspecified, broadcast and multicast addresses would
/// lead to this machine or to many.
fn is_unicast(at: &SocketAddr) -> bool {
    let ip = at.ip();
    let is_of_many = match ip.to_canonical() {
        IpAddr::V4(ip) => ip.is_broadcast() || ip.is_multicast(),
        IpAddr::V6(ip) => ip.is_multicast(),
    };
    at.port() != 0 && !ip.to_canonical().is_unspecified() && !is_of_many
}

impl Serialize for StationId {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for StationId {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        Self::named(&text).ok_or_else(|| serde::de::Error::custom("no id of a station"))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn message_round_trips() {
        let message = StateMessage {
            station: StationId(7),
            at: vec!["192.168.1.5:41234".parse().unwrap()],
            port: "sim".to_owned(),
            is_virtual: true,
            state: json!({"x": 1}),
        };
        let text = json!({
            "station": "0000000000000007", "at": ["192.168.1.5:41234"], "port": "sim",
            "virtual": true, "state": {"x": 1},
        });
        assert_eq!(serde_json::to_value(&message).unwrap(), text);
        let bytes = text.to_string();
        assert_eq!(StateMessage::parse(bytes.as_bytes()), Some(message));
    }

    #[test]
    fn foreign_message_is_bounded() {
        let addresses: Vec<_> = (0..100).map(|at| format!("10.0.0.{at}:1")).collect();
        let mut text = json!({
            "station": "0000000000000007", "at": addresses, "port": "", "virtual": false, "state": null,
        });
        let read = |text: &Value| StateMessage::parse(text.to_string().as_bytes());
        assert_eq!(read(&text).unwrap().at.len(), MAX_ADDRESSES);
        text["at"] = json!([
            "0.0.0.0:80",
            "[::]:80",
            "[::ffff:0.0.0.0]:80",
            "224.0.0.1:80",
            "[ff02::1]:80",
            "255.255.255.255:80",
            "10.0.0.1:0",
            "10.0.0.1:1",
        ]);
        assert_eq!(read(&text).unwrap().at, ["10.0.0.1:1".parse().unwrap()]);
        text["state"] = json!("x".repeat(MAX_STATE_SIZE));
        assert_eq!(read(&text), None);
        text["state"] = json!("x".repeat(MAX_STATE_SIZE / 2));
        assert!(read(&text).is_some());
        for (name, wrong) in [
            ("at", json!(["bench-1:80"])),
            ("station", json!(7)),
            ("station", json!("7")),
            ("port", json!(null)),
        ] {
            let good = std::mem::replace(&mut text[name], wrong);
            assert_eq!(read(&text), None, "{name}");
            text[name] = good;
        }
    }
}
