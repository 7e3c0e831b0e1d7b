//! What a station says of an arm on the bus of its site, as JSON. Nothing of it is secret, and nothing
//! of it is proved but by the certificates of the site.

use std::net::{IpAddr, SocketAddr};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{ArmNews, StationId};

/// Bytes of a message, at most: a roster of 10,000 arms, and some.
pub const LARGEST: usize = 2 * 1024 * 1024;
/// Bytes of a state message, at most; usual ones have about a thousand. A hub keeps one of each arm, so
/// this bounds what a stranger with many arms makes it keep.
const LARGEST_STATE: usize = 32 * 1024;
/// Addresses of a station that are tried, at most.
const ADDRESSES: usize = 8;

/// State of an arm, as its station puts it on the bus.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct StateMessage {
    /// The station.
    pub station: StationId,
    /// Addresses of its listener for the site; empty without a certificate.
    #[serde(default)]
    pub at: Vec<SocketAddr>,
    /// [`ArmNews::port`].
    pub port: String,
    /// [`ArmNews::is_virtual`].
    #[serde(rename = "virtual")]
    pub is_virtual: bool,
    /// [`ArmNews::state`].
    pub state: Value,
}

impl StateMessage {
    /// The message of these bytes, with the addresses that can be tried; `None` if it is none, or larger
    /// than any state is.
    #[must_use]
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        if bytes.len() > LARGEST_STATE {
            return None;
        }
        let mut message: Self = serde_json::from_slice(bytes).ok()?;
        message.at.retain(is_of_one_machine);
        message.at.truncate(ADDRESSES);
        Some(message)
    }

    /// The news of it, from a station on this machine.
    #[must_use]
    pub fn news(self, machine: &str) -> ArmNews {
        ArmNews {
            machine: machine.to_owned(),
            port: self.port,
            is_virtual: self.is_virtual,
            state: self.state,
        }
    }
}

/// False for addresses at which no station listens, and at which this machine or many might answer.
fn is_of_one_machine(at: &SocketAddr) -> bool {
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
    fn message_is_read_as_it_is_written() {
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
    fn message_of_a_stranger_is_bounded() {
        let addresses: Vec<_> = (0..100).map(|at| format!("10.0.0.{at}:1")).collect();
        let mut text = json!({
            "station": "0000000000000007", "at": addresses, "port": "", "virtual": false, "state": null,
        });
        let read = |text: &Value| StateMessage::parse(text.to_string().as_bytes());
        assert_eq!(read(&text).unwrap().at.len(), ADDRESSES);
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
        text["state"] = json!("x".repeat(LARGEST_STATE));
        assert_eq!(read(&text), None);
        text["state"] = json!("x".repeat(LARGEST_STATE / 2));
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
