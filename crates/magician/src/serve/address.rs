//! Addresses of endpoints.

use std::net::{IpAddr, SocketAddr, ToSocketAddrs};

use super::ServeError;

/// Resolves `HOST[:PORT]`; an IPv6 host with a port needs brackets.
pub(super) fn resolve(text: &str, port: Option<u16>) -> Result<SocketAddr, ServeError> {
    let wrong = |reason| ServeError::Address {
        address: text.to_owned(),
        reason,
    };
    let (host, port) = split(text, port).map_err(wrong)?;
    let mut found = (host, port)
        .to_socket_addrs()
        .map_err(|source| ServeError::at(text, "find the host", source))?;
    found.next().ok_or_else(|| wrong("the host has no address"))
}

fn split(text: &str, default: Option<u16>) -> Result<(&str, u16), &'static str> {
    let missing = "a port is missing: HOST:PORT";
    let bare = text.trim_start_matches('[').trim_end_matches(']');
    let colon = text.rfind(':').filter(|at| !text[*at..].contains(']'));
    let (host, port) = match colon {
        Some(at) if bare.parse::<IpAddr>().is_err() => {
            let port = text[at + 1..].parse();
            let port = port.map_err(|_| "the port is not a number from 0 to 65535")?;
            (&text[..at], port)
        }
        // An IPv6 address without brackets has no room for a port.
        _ => (text, default.ok_or(missing)?),
    };
    let host = host
        .strip_prefix('[')
        .and_then(|host| host.strip_suffix(']'))
        .unwrap_or(host);
    if host.is_empty() {
        return Err("a host is missing: HOST:PORT");
    }
    Ok((host, port))
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn hosts_with_and_without_a_port() {
        for (text, host, port) in [
            ("127.0.0.1", "127.0.0.1", 8899),
            ("127.0.0.1:0", "127.0.0.1", 0),
            ("arm.local:9000", "arm.local", 9000),
            ("::1", "::1", 8899),
            ("[::1]", "::1", 8899),
            ("[::1]:9000", "::1", 9000),
        ] {
            assert_eq!(split(text, Some(8899)), Ok((host, port)), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert!(split("localhost", None).unwrap_err().contains("port"));
        assert!(split("localhost:x", None).unwrap_err().contains("number"));
        assert!(
            split("localhost:70000", None)
                .unwrap_err()
                .contains("65535")
        );
        assert!(split(":8899", None).unwrap_err().contains("host"));
        assert!(split("", Some(1)).unwrap_err().contains("host"));
    }
}
