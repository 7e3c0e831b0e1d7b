//! Tokens that stations of this machine have for commands of the same user.

use magician::stations::{LocalStation, stations};
use magician_station::client::StationAddress;

/// Hosts by which this machine reaches itself.
const HERE: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];
/// Hosts of a station that listens at all addresses.
const EVERYWHERE: [&str; 2] = ["0.0.0.0", "[::]"];

/// The token that the station at this address has for commands of this user. `None` for one of another machine, and for one
/// that does not listen at this machine's own addresses, where alone the token counts.
pub(crate) fn token_of(url: &str) -> Option<String> {
    let address = |url: &str| {
        let address: StationAddress = url.parse().ok()?;
        let (host, port) = address.host.rsplit_once(':')?;
        Some((host.to_owned(), port.to_owned()))
    };
    let (host, port) = address(url)?;
    if !HERE.contains(&&*host) {
        return None;
    }
    let is_it = |station: &LocalStation| {
        let known = address(&station.url);
        known.is_some_and(|(host, known)| {
            known == port && (HERE.contains(&&*host) || EVERYWHERE.contains(&&*host))
        })
    };
    let token = stations().into_iter().find(is_it)?.token;
    Some(token).filter(|token| !token.is_empty())
}
