//! Serial ports of this computer and the USB adapters behind them.
//!
//! The properties of an adapter come from sysfs on Linux, from `ioreg` on macOS and from
//! `reg query` on Windows. Linux is tested on folders with the structure of sysfs, Windows under
//! Wine with a registry in the documented form; macOS is type-checked, and its parser tested on
//! text in the documented form.

use std::fmt;
use std::path::Path;

use magician_protocol::visible;

use crate::{Error, Message, Result, message};

mod adapters;
#[cfg(any(target_os = "macos", test))]
mod macos;
mod same;
mod sysfs;
#[cfg(any(windows, test))]
mod windows;

pub use adapters::{Adapter, unbound_adapters};
pub(crate) use same::Remembered;

/// Serial port of this computer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Port {
    /// Name to open: `/dev/ttyUSB0`, `COM3`.
    pub path: String,
    /// USB device behind the port, if known.
    pub usb: Option<Usb>,
}

/// USB device with a serial port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usb {
    /// Vendor id.
    pub vendor: u16,
    /// Product id.
    pub product: u16,
    /// Product name.
    pub name: Option<String>,
    /// Manufacturer name.
    pub manufacturer: Option<String>,
    /// Serial number of the adapter, not of the arm.
    pub serial: Option<String>,
    /// Socket that it is plugged into, as named by the system: `1-1.4` on Linux.
    pub location: Option<String>,
    /// Interface number, for adapters with several ports.
    pub interface: Option<u8>,
}

/// Kind of USB serial adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    pub(crate) vendor: u16,
    pub(crate) product: u16,
    pub(crate) chip: &'static str,
    /// Linux kernel module that provides the port.
    pub(crate) module: &'static str,
    /// True if arms contain it; otherwise cables may.
    pub(crate) in_arms: bool,
}

const fn kind(vendor: u16, product: u16, chip: &'static str, module: &'static str) -> Kind {
    Kind {
        vendor,
        product,
        chip,
        module,
        in_arms: true,
    }
}

/// All adapters of arms and of cables used with them. Tests compare the rules in
/// `packaging/70-magician.rules` and the documentation with this list.
const ADAPTERS: [Kind; 5] = [
    kind(0x10C4, 0xEA60, "CP210x", "cp210x"),
    kind(0x1A86, 0x7523, "CH340", "ch341"),
    // A CDC device, so it has a port even without a vendor driver.
    kind(0x1A86, 0x55D4, "CH9102", "cdc_acm"),
    Kind {
        in_arms: false,
        ..kind(0x1A86, 0x5523, "CH341", "ch341")
    },
    Kind {
        in_arms: false,
        ..kind(0x0403, 0x6001, "FT232R", "ftdi_sio")
    },
];

/// Returns the udev rules that give the logged-in user access to the adapters of arms.
pub(crate) fn udev_rules() -> impl Iterator<Item = String> {
    let in_arms = ADAPTERS.iter().filter(|kind| kind.in_arms);
    in_arms.map(|Kind { vendor, product, .. }| {
        format!(
            r#"SUBSYSTEM=="tty", ATTRS{{idVendor}}=="{vendor:04x}", ATTRS{{idProduct}}=="{product:04x}", TAG+="uaccess""#
        )
    })
}

impl Usb {
    /// Returns the kind of adapter, if known.
    fn kind(&self) -> Option<&'static Kind> {
        let is_it = |kind: &&Kind| (kind.vendor, kind.product) == (self.vendor, self.product);
        ADAPTERS.iter().find(is_it)
    }
}

impl Port {
    /// True if Magicians have this kind of adapter. Other devices may have it too.
    #[must_use]
    pub fn likely_arm(&self) -> bool {
        let usb = self.usb.as_ref();
        usb.and_then(Usb::kind).is_some_and(|kind| kind.in_arms)
    }

    /// True if a path leads to this port, also through symbolic links.
    fn is_at(&self, path: &str) -> bool {
        // Both are resolved: links such as `/dev/serial/by-id/..` lead to the same device.
        let canonical = |path: &str| Path::new(path).canonicalize().ok();
        self.path == path
            || cfg!(windows) && self.path.eq_ignore_ascii_case(path)
            || canonical(path).is_some_and(|path| canonical(&self.path) == Some(path))
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path)?;
        let Some(usb) = &self.usb else { return Ok(()) };
        write!(f, " (USB {:04x}:{:04x}", usb.vendor, usb.product)?;
        if let Some(serial) = &usb.serial {
            write!(f, ":{}", visible(serial))?;
        }
        if let Some(name) = &usb.name {
            write!(f, " {}", visible(name))?;
        }
        f.write_str(if self.likely_arm() {
            ", likely an arm)"
        } else {
            ")"
        })
    }
}

/// Lists the serial ports of this computer, likely arms first.
///
/// The USB adapters behind them are known on Linux (from sysfs), macOS (from `ioreg`) and Windows
/// (from `reg query`). docs/guide/PLATFORMS.md says which of these have been tested: Linux, and Windows
/// under Wine.
///
/// The list is empty in a build without the feature `lines`.
///
/// # Errors
/// [`ErrorKind::Port`](crate::ErrorKind::Port) if the system does not list them.
pub fn ports() -> Result<Vec<Port>> {
    #[cfg(feature = "lines")]
    let paths = serial2::SerialPort::available_ports().map_err(|error| {
        let message = message!(
            "the serial ports could not be listed: {cause}",
            cause = error.to_string()
        );
        Error::port(message, error)
    })?;
    #[cfg(not(feature = "lines"))]
    let paths: Vec<std::path::PathBuf> = Vec::new();
    let paths = paths.iter().map(|path| path.to_string_lossy().into_owned());
    let mut ports = described(paths.filter(|path| !is_double(path)).collect());
    // Likely arms first, then by name, so that lists are stable between calls.
    ports.sort_by_key(|port| (!port.likely_arm(), port.path.clone()));
    Ok(ports)
}

/// True for the second entry of a port on macOS; opening `tty.` waits for a carrier.
fn is_double(path: &str) -> bool {
    cfg!(target_os = "macos") && path.contains("/tty.")
}

#[cfg(target_os = "linux")]
fn described(paths: Vec<String>) -> Vec<Port> {
    let port = |path: String| Port {
        // Per port, not per device: on-board ports have no USB device, and stay in the list without
        // one.
        usb: sysfs::usb(Path::new("/sys/class/tty"), Path::new(&path)),
        path,
    };
    paths.into_iter().map(port).collect()
}

#[cfg(target_os = "macos")]
fn described(paths: Vec<String>) -> Vec<Port> {
    let known = macos::adapters();
    with(paths, |path| known.iter().find(|(at, _)| at == path))
}

#[cfg(windows)]
fn described(paths: Vec<String>) -> Vec<Port> {
    // Only present ports are described: each costs a `reg` process.
    let known = windows::adapters(&paths);
    with(paths, |path| {
        known.iter().find(|(at, _)| at.eq_ignore_ascii_case(path))
    })
}

#[cfg(any(target_os = "macos", windows))]
fn with<'a>(paths: Vec<String>, find: impl Fn(&str) -> Option<&'a (String, Usb)>) -> Vec<Port> {
    let port = |path: String| Port {
        usb: find(&path).map(|(_, usb)| usb.clone()),
        path,
    };
    paths.into_iter().map(port).collect()
}

#[cfg(not(any(target_os = "linux", target_os = "macos", windows)))]
fn described(paths: Vec<String>) -> Vec<Port> {
    let port = |path| Port { path, usb: None };
    paths.into_iter().map(port).collect()
}

/// Returns the output of a system program; empty if it fails.
#[cfg(any(target_os = "macos", windows))]
fn said_by(program: &str, arguments: &[&str]) -> String {
    // A missing program only costs the description of the ports, never their list.
    match std::process::Command::new(program).args(arguments).output() {
        Ok(output) => String::from_utf8_lossy(&output.stdout).into_owned(),
        Err(error) => {
            tracing::debug!(program, %error, "the serial ports are unknown");
            String::new()
        }
    }
}

/// Describes ports as a phrase.
pub(crate) fn list<'a>(ports: impl IntoIterator<Item = &'a Port>) -> Message {
    let all: Vec<String> = ports.into_iter().map(Port::to_string).collect();
    match all.as_slice() {
        [] => message!("this computer has no serial port"),
        all => message!("serial ports here: {ports}", ports = all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_is_known_by_each_of_its_adapters() {
        let port = |vendor, product| Port {
            path: "/dev/ttyACM0".into(),
            usb: Some(Usb {
                vendor,
                product,
                ..Usb::default()
            }),
        };
        for (vendor, product) in [(0x10C4, 0xEA60), (0x1A86, 0x7523), (0x1A86, 0x55D4)] {
            assert!(
                port(vendor, product).likely_arm(),
                "{vendor:04x}:{product:04x}"
            );
        }
        assert!(!port(0x0403, 0x6001).likely_arm(), "any cable may have it");
    }

    #[test]
    fn a_port_says_what_it_is() {
        let usb = Usb {
            vendor: 0x1A86,
            product: 0x7523,
            name: Some("USB Serial".into()),
            ..Usb::default()
        };
        let port = Port {
            path: "/dev/ttyUSB3".into(),
            usb: Some(usb),
        };
        assert!(port.likely_arm());
        assert_eq!(
            port.to_string(),
            "/dev/ttyUSB3 (USB 1a86:7523 USB Serial, likely an arm)"
        );
        assert_eq!(list([]), "this computer has no serial port");
    }
}
