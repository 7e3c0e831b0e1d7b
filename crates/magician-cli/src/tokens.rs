//! Tokens that stations on this machine publish for commands of the same user.

use magician::stations::{LocalStation, stations};
use magician_station::client::StationAddress;

/// Names of this machine's loopback interface.
const LOOPBACK_HOSTS: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];
/// Wildcard addresses, which include the loopback interface.
const WILDCARD_HOSTS: [&str; 2] = ["0.0.0.0", "[::]"];

/// Returns the token of the station at this address for commands of this user. `None` if the
/// station is on another machine or does not listen on the loopback interface: the token is
/// accepted only there.
pub(crate) fn token_of(url: &str) -> Option<String> {
    let address = |url: &str| {
        let address: StationAddress = url.parse().ok()?;
        let (host, port) = address.host.rsplit_once(':')?;
        Some((host.to_owned(), port.to_owned()))
    };
    let (host, port) = address(url)?;
    if !LOOPBACK_HOSTS.contains(&&*host) {
        return None;
    }
    let is_it = |station: &LocalStation| {
        let known = address(&station.url);
        known.is_some_and(|(host, known)| {
            known == port && (LOOPBACK_HOSTS.contains(&&*host) || WILDCARD_HOSTS.contains(&&*host))
        })
    };
    let token = stations().into_iter().find(is_it)?.token;
    Some(token).filter(|token| !token.is_empty())
}
