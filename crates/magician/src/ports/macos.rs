//! USB devices behind the ports on macOS, from the I/O registry.
//!
//! `ioreg` prints every USB device with its descendants, which include the names of its ports. The
//! code is type-checked, and tested on output in the documented form; it has never run on a Mac.
//! Libraries that query the registry directly link to Apple's frameworks, and a library that reads
//! `ioreg -a` (`plist`) brings an XML parser and a calendar. The parser below is shorter than code
//! to walk their trees.

use super::Usb;

/// Returns the ports of USB adapters.
#[cfg(target_os = "macos")]
pub(super) fn adapters() -> Vec<(String, Usb)> {
    let all = ["-r", "-c", "IOUSBHostDevice", "-l", "-w", "0"];
    parse(&super::said_by("/usr/sbin/ioreg", &all))
}

/// Registry entry with its indentation.
#[derive(Default)]
struct Node {
    column: usize,
    vendor: Option<u16>,
    product: Option<u16>,
    name: Option<String>,
    manufacturer: Option<String>,
    serial: Option<String>,
    location: Option<String>,
    interface: Option<u8>,
}

/// Parses `+-o NAME  <class ...>` lines, whose indentation shows the depth, and the `"key" = value`
/// lines below them.
fn parse(text: &str) -> Vec<(String, Usb)> {
    let mut found: Vec<(String, Usb)> = Vec::new();
    let mut path: Vec<Node> = Vec::new();
    for line in text.lines() {
        if let Some(column) = line.find("+-o ") {
            // A line further left ends the branch of every deeper node.
            path.retain(|node| node.column < column);
            path.push(Node {
                column,
                ..Node::default()
            });
            continue;
        }
        let line = line.trim_start_matches([' ', '|']);
        let Some((key, value)) = line.split_once(" = ") else {
            continue;
        };
        let Some(node) = path.last_mut() else {
            continue;
        };
        match key.trim_matches('"') {
            "idVendor" => node.vendor = number(value),
            "idProduct" => node.product = number(value),
            "bInterfaceNumber" => node.interface = number(value),
            "USB Product Name" | "kUSBProductString" => node.name = quoted(value),
            "USB Vendor Name" | "kUSBVendorString" => node.manufacturer = quoted(value),
            "USB Serial Number" | "kUSBSerialNumberString" => node.serial = quoted(value),
            "locationID" => {
                let location: Option<u32> = number(value);
                node.location = location.map(|location| format!("{location:08x}"));
            }
            "IOCalloutDevice" => {
                let port = quoted(value);
                let known = |port: &String| found.iter().any(|(at, _)| at == port);
                // A device behind a hub is printed below the hub, and once more on its own.
                if let (Some(port), Some(usb)) = (port.filter(|port| !known(port)), usb(&path)) {
                    found.push((port, usb));
                }
            }
            // The registry has dozens of other properties.
            _ => {}
        }
    }
    found
}

/// Returns the closest USB device above a port.
fn usb(path: &[Node]) -> Option<Usb> {
    let at = path.iter().rposition(|node| {
        node.vendor.is_some() && node.location.is_some() && node.interface.is_none()
    });
    let (device, below) = path.get(at?..)?.split_first()?;
    Some(Usb {
        vendor: device.vendor?,
        product: device.product?,
        name: device.name.clone(),
        manufacturer: device.manufacturer.clone(),
        serial: device.serial.clone(),
        location: device.location.clone(),
        interface: below.iter().find_map(|node| node.interface),
    })
}

fn number<T: TryFrom<u64>>(value: &str) -> Option<T> {
    value.trim().parse::<u64>().ok()?.try_into().ok()
}

fn quoted(value: &str) -> Option<String> {
    let text = value.trim().strip_prefix('"')?.strip_suffix('"')?.trim();
    Some(text.to_owned()).filter(|text| !text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hub with an adapter, which is listed below the hub and on its own.
    const OUTPUT: &str = r#"+-o USB2.0 Hub@14100000  <class IOUSBHostDevice, id 0x100001201, registered, matched, active, busy 0 (3 ms), retain 25>
  | {
  |   "idProduct" = 1544
  |   "locationID" = 336592896
  |   "idVendor" = 1507
  | }
  |
  +-o CP2102 USB to UART Bridge Controller@14140000  <class IOUSBHostDevice, id 0x100001210, registered, matched, active, busy 0 (5 ms), retain 22>
    | {
    |   "idProduct" = 60000
    |   "IOPowerManagement" = {"PowerOverrideOn"=Yes,"DevicePowerState"=2}
    |   "USB Product Name" = "CP2102 USB to UART Bridge Controller"
    |   "locationID" = 336855040
    |   "USB Vendor Name" = "Silicon Labs            "
    |   "idVendor" = 4292
    |   "kUSBSerialNumberString" = "0001"
    | }
    |
    +-o IOUSBHostInterface@0  <class IOUSBHostInterface, id 0x100001215, registered, matched, active, busy 0 (2 ms), retain 8>
      | {
      |   "idProduct" = 60000
      |   "locationID" = 336855040
      |   "bInterfaceNumber" = 0
      |   "idVendor" = 4292
      | }
      |
      +-o AppleUSBSLCOM  <class AppleUSBSLCOM, id 0x100001218, registered, matched, active, busy 0 (1 ms), retain 6>
        +-o IOSerialBSDClient  <class IOSerialBSDClient, id 0x10000121a, registered, matched, active, busy 0 (0 ms), retain 5>
            {
              "IOClass" = "IOSerialBSDClient"
              "IODialinDevice" = "/dev/tty.usbserial-0001"
              "IOCalloutDevice" = "/dev/cu.usbserial-0001"
            }

+-o CP2102 USB to UART Bridge Controller@14140000  <class IOUSBHostDevice, id 0x100001210, registered, matched, active, busy 0 (5 ms), retain 22>
  | {
  |   "idProduct" = 60000
  |   "locationID" = 336855040
  |   "idVendor" = 4292
  | }
  |
  +-o AppleUSBSLCOM  <class AppleUSBSLCOM, id 0x100001218, registered, matched, active, busy 0 (1 ms), retain 6>
    +-o IOSerialBSDClient  <class IOSerialBSDClient, id 0x10000121a, registered, matched, active, busy 0 (0 ms), retain 5>
        {
          "IOCalloutDevice" = "/dev/cu.usbserial-0001"
        }

+-o Keyboard@14200000  <class IOUSBHostDevice, id 0x100001301, registered, matched, active, busy 0 (3 ms), retain 25>
    {
      "idVendor" = 1452
    }
"#;

    #[test]
    fn a_port_belongs_to_the_device_above_it() {
        let usb = Usb {
            vendor: 0x10C4,
            product: 0xEA60,
            name: Some("CP2102 USB to UART Bridge Controller".into()),
            manufacturer: Some("Silicon Labs".into()),
            serial: Some("0001".into()),
            location: Some("14140000".into()),
            interface: Some(0),
        };
        assert_eq!(parse(OUTPUT), [("/dev/cu.usbserial-0001".to_owned(), usb)]);
    }

    #[test]
    fn what_is_cut_off_or_strange_is_no_port() {
        for end in 0..OUTPUT.len() {
            parse(OUTPUT.get(..end).unwrap_or_default());
        }
        assert_eq!(parse("\"IOCalloutDevice\" = \"/dev/cu.x\""), []);
        assert_eq!(
            parse("+-o x\n \"idVendor\" = 99999\n \"IOCalloutDevice\" = \"y\""),
            []
        );
    }
}
