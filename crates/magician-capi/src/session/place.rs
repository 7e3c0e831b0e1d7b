//! Resolution of port names: finds the target of the driver for the name that a program passes, or
//! that a variable gives.

use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use std::time::Duration;

use magician::discovery::Search;
use magician::files::WholeFile;
use magician::{Error, Port, Target, Tracer};

/// Variable with the port for programs that name none.
pub(super) const PORT_VARIABLE: &str = "MAGICIAN_PORT";
/// Variable with the path of a trace of all frames.
const TRACE_VARIABLE: &str = "MAGICIAN_TRACE";
/// Time that `SearchDobot` waits for arms on Wi-Fi. A choice: arms on the same network answer well
/// within it, and the caller is blocked meanwhile.
const SEARCH_TIMEOUT: Duration = Duration::from_millis(250);

/// Environment of the process. Tests replace it.
#[derive(Clone, Copy, Debug)]
pub struct Environment {
    /// Returns a variable of the environment.
    pub variable: fn(&str) -> Option<String>,
    /// Lists the serial ports.
    pub ports: fn() -> Vec<Port>,
    /// Finds arms on Wi-Fi that answer within a moment.
    pub network: fn() -> Vec<Ipv4Addr>,
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            variable: |name| {
                // On Windows `set MAGICIAN_PORT=sim && ...` leaves a trailing blank.
                let value = std::env::var(name).ok()?.trim().to_owned();
                Some(value).filter(|value| !value.is_empty())
            },
            ports: || {
                magician::ports().unwrap_or_else(|error| {
                    tracing::warn!("{error}");
                    Vec::new()
                })
            },
            network,
        }
    }
}

fn network() -> Vec<Ipv4Addr> {
    let found = Search::networks().find_blocking(SEARCH_TIMEOUT);
    let found = found.unwrap_or_else(|error| {
        tracing::debug!("{error}");
        Vec::new()
    });
    let addresses = found.into_iter().filter_map(|arm| match arm.address {
        IpAddr::V4(address) => Some(address),
        IpAddr::V6(_) => None,
    });
    addresses.collect()
}

impl Environment {
    /// Resolves a name. Returns `None` if the name is empty and no port was found.
    pub(super) fn resolve(&self, name: &str) -> Option<Result<Target, Error>> {
        let name = name.trim();
        if !name.is_empty() {
            let redirected = (self.variable)(&variable_of(name));
            return Some(parse_target(redirected.as_deref().unwrap_or(name)));
        }
        if let Some(port) = (self.variable)(PORT_VARIABLE) {
            return Some(parse_target(&port));
        }
        let ports = self.arm_ports();
        ports.first().map(|port| Ok(Target::Serial(port.clone())))
    }

    /// Serial ports that may have an arm, likely ones first.
    pub(super) fn arm_ports(&self) -> Vec<String> {
        let ports = (self.ports)().into_iter();
        ports.filter(is_listed).map(|port| port.path).collect()
    }

    /// Opens the trace requested by `MAGICIAN_TRACE`.
    pub(super) fn tracer(&self) -> Option<Tracer> {
        let path = (self.variable)(TRACE_VARIABLE)?;
        // Written in place, not renamed at the end: a program may end without closing the library.
        let file = WholeFile::grow_in_place(Path::new(&path));
        let tracer = file.and_then(Tracer::new);
        tracer
            .inspect_err(|error| {
                tracing::warn!("{TRACE_VARIABLE}={path} cannot be written: {error}")
            })
            .ok()
    }
}

/// Descriptions of adapters that the vendor's library lists.
const DESCRIPTIONS: [&str; 5] = [
    "USB-to-Serial",
    "CH340",
    "CP210",
    "USB2.0-Serial",
    "USB Serial Port",
];

fn is_listed(port: &Port) -> bool {
    let name = port.usb.as_ref().and_then(|usb| usb.name.as_deref());
    let has_listed_name =
        name.is_some_and(|name| DESCRIPTIONS.iter().any(|known| name.contains(known)));
    has_listed_name || port.likely_arm()
}

/// Name of the variable that redirects a port: `MAGICIAN_PORT_COM3`, `MAGICIAN_PORT_TTYUSB0`.
pub(super) fn variable_of(name: &str) -> String {
    let letters = device_name(name).chars().map(|c| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_uppercase()
        } else {
            '_'
        }
    });
    format!("{PORT_VARIABLE}_{}", letters.collect::<String>())
}

/// Name of a port without its prefix, as the vendor's library lists it.
pub(super) fn device_name(path: &str) -> &str {
    let prefixes = ["/dev/", r"\\.\"];
    let stripped = prefixes.iter().find_map(|prefix| path.strip_prefix(prefix));
    stripped.unwrap_or(path)
}

/// Parses an address, any target of the driver, or the bare name of a device.
fn parse_target(name: &str) -> Result<Target, Error> {
    if let Ok(address) = name.parse::<Ipv4Addr>() {
        return format!("udp:{address}").parse();
    }
    name.parse().or_else(|error| {
        let is_device = cfg!(unix) && !name.contains([':', '/', '\0']);
        if is_device {
            Ok(Target::Serial(format!("/dev/{name}")))
        } else {
            Err(error)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician::{SimSpeed, Usb};

    fn environment(variable: fn(&str) -> Option<String>, ports: fn() -> Vec<Port>) -> Environment {
        Environment {
            variable,
            ports,
            network: Vec::new,
        }
    }

    fn port(path: &str, name: &str, (vendor, product): (u16, u16)) -> Port {
        let usb = Usb {
            vendor,
            product,
            name: Some(name.into()),
            ..Usb::default()
        };
        Port {
            path: path.into(),
            usb: Some(usb),
        }
    }

    fn resolve(environment: &Environment, name: &str) -> Target {
        environment.resolve(name).unwrap().unwrap()
    }

    #[test]
    fn names_of_all_kinds_resolve() {
        let plain = environment(|_| None, Vec::new);
        let serial = |path: &str| Target::Serial(path.into());
        let udp = |host: &str| Target::Udp {
            host: host.into(),
            port: 8899,
        };
        assert_eq!(resolve(&plain, "COM3"), serial("COM3"));
        assert_eq!(resolve(&plain, " /dev/ttyUSB0\n"), serial("/dev/ttyUSB0"));
        assert_eq!(resolve(&plain, "192.168.1.5"), udp("192.168.1.5"));
        assert_eq!(resolve(&plain, "udp:arm"), udp("arm"));
        assert_eq!(resolve(&plain, "sim"), Target::Sim(SimSpeed::Max));
        #[cfg(unix)]
        assert_eq!(resolve(&plain, "ttyUSB0"), serial("/dev/ttyUSB0"));
        assert!(plain.resolve("udp:").unwrap().is_err());
        assert!(plain.resolve("").is_none(), "there is no port");
    }

    #[test]
    fn built_in_name_can_be_redirected() {
        let redirected = environment(
            |name| {
                let redirected = ["MAGICIAN_PORT_COM3", "MAGICIAN_PORT_TTYUSB0"].contains(&name);
                redirected.then(|| "sim:2".to_owned())
            },
            Vec::new,
        );
        for name in ["com3", r"\\.\COM3", "/dev/ttyUSB0", "ttyUSB0"] {
            assert_eq!(
                resolve(&redirected, name),
                Target::Sim(SimSpeed::Times(2.0))
            );
        }
        assert_eq!(resolve(&redirected, "COM4"), Target::Serial("COM4".into()));
        assert_eq!(variable_of("192.168.1.5"), "MAGICIAN_PORT_192_168_1_5");
    }

    #[test]
    fn variable_overrides_the_first_port_without_a_name() {
        let ports = || {
            vec![
                port("/dev/ttyS9", "Some other thing", (1, 2)),
                port("/dev/ttyUSB1", "USB Serial Port", (1, 2)),
                port("/dev/ttyUSB2", "", (0x10C4, 0xEA60)),
            ]
        };
        let without = environment(|_| None, ports);
        assert_eq!(resolve(&without, ""), Target::Serial("/dev/ttyUSB1".into()));
        assert_eq!(without.arm_ports(), ["/dev/ttyUSB1", "/dev/ttyUSB2"]);
        let with = environment(|name| (name == PORT_VARIABLE).then(|| "sim".into()), ports);
        assert_eq!(resolve(&with, ""), Target::Sim(SimSpeed::Max));
    }
}
