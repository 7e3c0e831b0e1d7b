//! Where a station is, and which of its arms is meant.

use std::str::FromStr;

/// `http://HOST:PORT`, or `http://HOST:PORT/ARM`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationAddress {
    /// Host and port.
    pub host: String,
    /// The arm that is named.
    pub arm: Option<String>,
}

impl FromStr for StationAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let rest = match text.split_once("://") {
            Some(("http" | "ws", rest)) => rest,
            Some(("https" | "wss", _)) => {
                return Err(format!(
                    "{text}: encrypted connections are not supported yet"
                ));
            }
            Some(_) => return Err(format!("{text}: expected http://HOST:PORT")),
            None => text,
        };
        let (host, arm) = rest.split_once('/').unwrap_or((rest, ""));
        let arm = arm.trim_end_matches('/');
        if host.is_empty() || arm.contains(['/', '?', '#']) || host.contains(['@', '?', '#', ' ']) {
            return Err(format!(
                "{text}: expected http://HOST:PORT or http://HOST:PORT/ARM"
            ));
        }
        // A port is the station's own unless one is named; the colons of an IPv6 address are within brackets.
        let named = host
            .rsplit_once(':')
            .is_some_and(|(_, port)| !port.contains(']'));
        Ok(Self {
            host: if named {
                host.to_owned()
            } else {
                format!("{host}:8910")
            },
            arm: (!arm.is_empty()).then(|| arm.to_owned()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_taken_as_people_write_them() {
        for (text, host, arm) in [
            ("http://127.0.0.1:8910", "127.0.0.1:8910", None),
            ("http://localhost:8910/", "localhost:8910", None),
            ("http://lab.local/left", "lab.local:8910", Some("left")),
            ("ws://[::1]:9000/a/", "[::1]:9000", Some("a")),
            ("[::1]", "[::1]:8910", None),
        ] {
            let address: StationAddress = text.parse().unwrap();
            assert_eq!(
                (address.host.as_str(), address.arm.as_deref()),
                (host, arm),
                "{text}"
            );
        }
        for wrong in [
            "",
            "https://x",
            "ftp://x",
            "http://",
            "http://a/b/c",
            "http://me@host",
            "http://h?token=x",
        ] {
            assert!(wrong.parse::<StationAddress>().is_err(), "{wrong}");
        }
    }
}
