//! Address of a station, and optionally of one of its arms.

use std::str::FromStr;

use http::Uri;

/// Default port, with or without encryption.
const DEFAULT_PORT: u16 = 8910;

/// Address `http://HOST:PORT` or `http://HOST:PORT/ARM`; `https` for encrypted connections.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StationAddress {
    /// Host and port.
    pub host: String,
    /// Name of the arm. `None` if the address has none.
    pub arm: Option<String>,
    /// True if connections are encrypted.
    pub encrypted: bool,
}

impl StationAddress {
    /// Returns the host without the port.
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
        // `HOST:` with an empty or invalid port is a typing error, not the default.
        let named = authority.as_str() != authority.host();
        let port = match authority.port_u16() {
            None if named => return Err(wrong()),
            port => port.unwrap_or(DEFAULT_PORT),
        };
        let arm = url.path().trim_matches('/');
        // No credentials, queries or further path: they would be ignored silently.
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
    fn common_address_forms_are_accepted() {
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
