//! Announces and finds stations on the local network by multicast DNS (DNS-SD).

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use mdns_sd::{ResolvedService, ServiceDaemon, ServiceEvent, ServiceInfo};
use serde::Serialize;

/// DNS-SD service type of a station.
const SERVICE_TYPE: &str = "_magician._tcp.local.";
/// Largest TXT entry, in bytes with its key (RFC 6763 section 6.1).
const MAX_TXT_SIZE: usize = 255;

/// Station found on the network.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(crate) struct FoundStation {
    /// Address for `--station`.
    pub(crate) url: String,
    /// Name of its computer.
    pub(crate) name: String,
    /// Names of its arms, as far as they fit into the announcement.
    pub(crate) arms: Vec<String>,
}

/// Announcement of a station, valid until it is dropped.
pub(crate) struct Announcement {
    daemon: ServiceDaemon,
    name: String,
}

impl Announcement {
    /// Announces a station at these addresses. The announcement is public and holds no secret: only
    /// the service, whether it is encrypted, and the names of the arms.
    pub(crate) fn new(
        addresses: &[SocketAddr],
        encrypted: bool,
        arms: &[String],
    ) -> Result<Self, mdns_sd::Error> {
        let port = addresses.first().map_or(0, SocketAddr::port);
        let host = host_name();
        let properties = properties(encrypted, arms);
        let specific = addresses.iter().map(SocketAddr::ip);
        let specific: Vec<IpAddr> = specific
            .filter(|address| !address.is_unspecified())
            .collect();
        let listens_everywhere = specific.is_empty();
        let domain = format!("{host}.local.");
        let info = ServiceInfo::new(
            SERVICE_TYPE,
            &host,
            &domain,
            &specific[..],
            port,
            &properties[..],
        )?;
        // The station listens at every address, so announce all addresses of the machine, also
        // those that it gets later.
        let info = if listens_everywhere {
            info.enable_addr_auto()
        } else {
            info
        };
        let name = info.get_fullname().to_owned();
        let daemon = ServiceDaemon::new()?;
        daemon.register(info)?;
        Ok(Self { daemon, name })
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        // Withdraws the announcement so that others drop it from their caches. 200 ms is a choice:
        // the end of the program shall not hang on the network.
        if let Ok(status) = self.daemon.unregister(&self.name) {
            let _ = status.recv_timeout(Duration::from_millis(200));
        }
        let _ = self.daemon.shutdown();
    }
}

/// Browses for stations for `duration`.
pub(crate) fn find(duration: Duration) -> Result<Vec<FoundStation>, mdns_sd::Error> {
    let deadline = Instant::now() + duration;
    let daemon = ServiceDaemon::new()?;
    let events = daemon.browse(SERVICE_TYPE)?;
    let mut found = BTreeMap::new();
    while let Ok(event) = events.recv_deadline(deadline) {
        // A station with many addresses is reported more than once; the last report is the most
        // complete.
        if let ServiceEvent::ServiceResolved(service) = event
            && let Some(station) = station(&service)
        {
            found.insert(service.get_fullname().to_owned(), station);
        }
    }
    let _ = daemon.shutdown();
    Ok(found.into_values().collect())
}

/// Returns the TXT entries of an announcement.
fn properties(encrypted: bool, arms: &[String]) -> Vec<(&'static str, String)> {
    let mut names = arms.join(",");
    // Arms that do not fit are left out of the announcement; the station itself lists all.
    while names.len() + "arms=".len() > MAX_TXT_SIZE {
        names = names
            .rsplit_once(',')
            .map_or(String::new(), |(some, _)| some.to_owned());
    }
    vec![
        ("api", "1".to_owned()),
        ("tls", u8::from(encrypted).to_string()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("arms", names),
    ]
}

/// Converts a service into a station; `None` if it has no usable address.
fn station(service: &ResolvedService) -> Option<FoundStation> {
    let addresses = service.get_addresses().iter().map(|at| at.to_ip_addr());
    let text = |key| service.get_property_val_str(key).unwrap_or_default();
    let name = service.get_fullname().strip_suffix(SERVICE_TYPE);
    let name = name.unwrap_or_default().trim_end_matches('.');
    to_station(
        name,
        addresses,
        service.get_port(),
        text("tls"),
        text("arms"),
    )
}

/// Creates the station that is shown to the user. The announcement comes from the network, so
/// control characters are made visible.
fn to_station(
    name: &str,
    addresses: impl Iterator<Item = IpAddr>,
    port: u16,
    tls: &str,
    arms: &str,
) -> Option<FoundStation> {
    let usable = |address: &IpAddr| match address {
        // A loopback address would lead to this computer, not to the announcing one.
        address if address.is_loopback() => false,
        IpAddr::V4(_) => true,
        // A link-local address needs the name of an interface, for which a URL has no place.
        IpAddr::V6(address) => !address.is_unicast_link_local(),
    };
    let address = addresses.filter(usable).min()?;
    let scheme = if tls == "1" { "https" } else { "http" };
    let escaped = |text: &str| magician_protocol::visible(text).to_string();
    let arms = arms.split(',').filter(|arm| !arm.is_empty());
    Some(FoundStation {
        url: format!("{scheme}://{}", SocketAddr::new(address, port)),
        name: escaped(name),
        arms: arms.map(escaped).collect(),
    })
}

/// Returns this computer's name without its domain.
pub(crate) fn host_name() -> String {
    #[cfg(unix)]
    let name = rustix::system::uname()
        .nodename()
        .to_string_lossy()
        .into_owned();
    #[cfg(not(unix))]
    let name = std::env::var("COMPUTERNAME").unwrap_or_default();
    let is_allowed = |c: &char| c.is_ascii_alphanumeric() || *c == '-';
    let first = name.split('.').next().unwrap_or_default();
    let name: String = first.chars().filter(is_allowed).take(63).collect();
    if name.is_empty() {
        "magician".to_owned()
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found_at(addresses: &[&str], tls: &str, arms: &str) -> Option<FoundStation> {
        let addresses = addresses.iter().map(|address| address.parse().unwrap());
        to_station("lab", addresses, 8910, tls, arms)
    }

    #[test]
    fn station_url_has_an_address_that_a_url_can_contain() {
        let both = found_at(&["fe80::1", "192.168.1.5"], "0", "left,right").unwrap();
        assert_eq!(both.url, "http://192.168.1.5:8910");
        assert_eq!(both.arms, ["left", "right"]);
        assert_eq!(
            found_at(&["fd00::5"], "1", "").unwrap().url,
            "https://[fd00::5]:8910"
        );
        assert_eq!(found_at(&["fe80::1"], "0", "arm"), None);
        assert_eq!(found_at(&["127.0.0.1", "::1"], "0", "arm"), None);
        assert_eq!(found_at(&[], "0", "arm"), None);
    }

    #[test]
    fn announced_text_is_escaped() {
        let addresses = ["10.0.0.1".parse().unwrap()].into_iter();
        let found = to_station("\x1b[2Jlab", addresses, 1, "\n", "a\u{7},b").unwrap();
        assert!(!found.name.contains('\x1b') && !found.arms[0].contains('\u{7}'));
    }

    #[test]
    fn announcement_fits_in_a_packet_and_contains_no_secret() {
        let arms: Vec<_> = (0..40)
            .map(|nth| format!("arm-with-a-name-{nth}"))
            .collect();
        let properties = properties(true, &arms);
        let names: Vec<_> = properties.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["api", "tls", "version", "arms"]);
        for (name, value) in &properties {
            assert!(
                name.len() + 1 + value.len() <= MAX_TXT_SIZE,
                "{name}: {value}"
            );
        }
        assert!(properties[3].1.starts_with("arm-with-a-name-0,"));
        assert!(!properties[3].1.ends_with(','));
    }

    #[test]
    fn host_name_is_valid_on_a_network() {
        let name = host_name();
        assert!((1..=63).contains(&name.len()), "{name}");
    }
}
