//! Where a station is, and which of its arms is meant.

use std::str::FromStr;

use http::Uri;

/// The port of a station where none is named, with encryption or without.
const PORT: u16 = 8910;

/// `http://HOST:PORT`, or `http://HOST:PORT/ARM`; `https` where connections are encrypted.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationAddress {
    /// Host and port.
    pub host: String,
    /// The arm that is named.
    pub arm: Option<String>,
    /// Whether connections are encrypted.
    pub encrypted: bool,
}

impl StationAddress {
    /// The host alone.
    pub(super) fn name(&self) -> &str {
        self.host
            .rsplit_once(':')
            .map_or(&self.host, |(name, _)| name)
    }
}

impl FromStr for StationAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = || format!("{text}: expected http://HOST:PORT or http://HOST:PORT/ARM");
        let url = if text.contains("://") {
            text.to_owned()
        } else {
            format!("http://{text}")
        };
        let url: Uri = url.parse().map_err(|_| wrong())?;
        let encrypted = match url.scheme_str() {
            Some("http" | "ws") => false,
            Some("https" | "wss") => true,
            _ => return Err(wrong()),
        };
        let authority = url.authority().ok_or_else(wrong)?;
        let named = authority.as_str() != authority.host();
        let port = match authority.port_u16() {
            None if named => return Err(wrong()),
            port => port.unwrap_or(PORT),
        };
        let arm = url.path().trim_matches('/');
        let strange = text.contains(['@', '?', '#']) || arm.contains('/');
        if authority.host().is_empty() || strange {
            return Err(wrong());
        }
        Ok(Self {
            host: format!("{}:{port}", authority.host()),
            arm: (!arm.is_empty()).then(|| arm.to_owned()),
            encrypted,
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
        let address: StationAddress = "https://lab.local/left".parse().unwrap();
        assert!(address.encrypted && address.name() == "lab.local");
        let address: StationAddress = "wss://[::1]:443".parse().unwrap();
        assert!(address.encrypted && address.name() == "[::1]");
        for wrong in [
            "",
            "http://a:99999",
            "http://a b",
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
