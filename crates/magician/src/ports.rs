use std::fmt;
use std::path::Path;

use crate::{Error, ErrorKind, Result};

/// A serial port of this computer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Port {
    /// What to open: `/dev/ttyUSB0`, `COM3`.
    pub path: String,
    /// What is known of the USB device behind it.
    pub usb: Option<Usb>,
}

/// A USB device with a serial port.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usb {
    /// Vendor id.
    pub vendor: u16,
    /// Product id.
    pub product: u16,
    /// Product text.
    pub name: Option<String>,
    /// Manufacturer text.
    pub manufacturer: Option<String>,
    /// Serial number of the adapter, not of the arm.
    pub serial: Option<String>,
}

/// The adapters found in Magicians: CP210x, and CH340 in some.
const ADAPTERS: [(u16, u16); 2] = [(0x10C4, 0xEA60), (0x1A86, 0x7523)];

impl Port {
    /// Whether the adapter is one that Magicians have. Other devices have them too.
    #[must_use]
    pub fn likely_arm(&self) -> bool {
        let usb = self.usb.as_ref();
        usb.is_some_and(|usb| ADAPTERS.contains(&(usb.vendor, usb.product)))
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path)?;
        let Some(usb) = &self.usb else { return Ok(()) };
        write!(f, " (USB {:04x}:{:04x}", usb.vendor, usb.product)?;
        if let Some(name) = &usb.name {
            write!(f, " {name}")?;
        }
        f.write_str(if self.likely_arm() {
            ", likely an arm)"
        } else {
            ")"
        })
    }
}

/// The serial ports of this computer, likely arms first.
///
/// # Errors
/// [`ErrorKind::Port`] when the system does not tell.
pub fn ports() -> Result<Vec<Port>> {
    let paths = serial2::SerialPort::available_ports().map_err(|error| {
        let message = format!("the serial ports could not be listed: {error}");
        Error::new(ErrorKind::Port, message).with_source(error)
    })?;
    let mut ports: Vec<Port> = paths
        .iter()
        .map(|path| Port {
            path: path.to_string_lossy().into_owned(),
            usb: usb_of(path),
        })
        .collect();
    ports.sort_by_key(|port| (!port.likely_arm(), port.path.clone()));
    Ok(ports)
}

/// Ports in a sentence.
pub(crate) fn list<'a>(ports: impl IntoIterator<Item = &'a Port>) -> String {
    let all: Vec<String> = ports.into_iter().map(Port::to_string).collect();
    match all.as_slice() {
        [] => "this computer has no serial port".to_owned(),
        all => format!("serial ports here: {}", all.join(", ")),
    }
}

/// What sysfs says about the device behind a port.
#[cfg(target_os = "linux")]
fn usb_of(path: &Path) -> Option<Usb> {
    let name = path.canonicalize().ok()?.file_name()?.to_owned();
    let device = Path::new("/sys/class/tty").join(name).join("device");
    let device = device.canonicalize().ok()?;
    let usb = device
        .ancestors()
        .find(|dir| dir.join("idVendor").exists())?;
    let text = |file: &str| {
        let text = std::fs::read_to_string(usb.join(file)).ok()?;
        Some(text.trim().to_owned()).filter(|text| !text.is_empty())
    };
    let number = |file: &str| u16::from_str_radix(&text(file)?, 16).ok();
    Some(Usb {
        vendor: number("idVendor")?,
        product: number("idProduct")?,
        name: text("product"),
        manufacturer: text("manufacturer"),
        serial: text("serial"),
    })
}

#[cfg(not(target_os = "linux"))]
fn usb_of(_: &Path) -> Option<Usb> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

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
