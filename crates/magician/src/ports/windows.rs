//! USB devices behind the ports on Windows, from the registry.
//!
//! Every USB device that was ever connected has a key below `Enum\USB`, which contains the name of
//! its serial port if it has one. The code has run under Wine, and is tested on output in the
//! documented form; it has never run on real Windows. The text output of `reg` can be tested on any
//! system, unlike calls of the registry API; `serialport`, which also lists ports, is licensed
//! under the MPL.

use super::Usb;

/// Registry key of the USB devices.
#[cfg(windows)]
const DEVICES: &str = r"HKLM\SYSTEM\CurrentControlSet\Enum\USB";

/// Returns those of the `present` ports that belong to USB adapters.
#[cfg(windows)]
pub(super) fn adapters(present: &[String]) -> Vec<(String, Usb)> {
    let mut found = parse(&super::said_by(
        "reg",
        &["query", DEVICES, "/s", "/v", "PortName"],
    ));
    // The registry keeps the keys of every adapter that was ever connected.
    found.retain(|adapter| (present.iter()).any(|port| port.eq_ignore_ascii_case(&adapter.port)));
    let describe = |mut adapter: Adapter| {
        let about = super::said_by("reg", &["query", &adapter.key]);
        describe(&mut adapter.usb, &about);
        (adapter.port, adapter.usb)
    };
    found.into_iter().map(describe).collect()
}

/// Device with a port.
#[derive(Debug, PartialEq)]
struct Adapter {
    port: String,
    /// Registry key of the device.
    key: String,
    usb: Usb,
}

/// Parses lines with a key, `HKEY_...\USB\VID_10C4&PID_EA60\0001\Device Parameters`, and the lines
/// with its values below, `    PortName    REG_SZ    COM3`.
fn parse(text: &str) -> Vec<Adapter> {
    let mut found = Vec::new();
    let mut key = "";
    for line in text.lines() {
        if line.starts_with("HKEY_") {
            key = line.trim_end();
        } else if let Some(("PortName", port)) = value(line)
            && let Some(device) = key.strip_suffix(r"\Device Parameters")
            && let Some(usb) = usb(device)
        {
            found.push(Adapter {
                port: port.to_owned(),
                key: device.to_owned(),
                usb,
            });
        }
    }
    found
}

/// Splits a value line into name and text.
fn value(line: &str) -> Option<(&str, &str)> {
    let (name, text) = line.trim().split_once("REG_SZ")?;
    Some((name.trim(), text.trim()))
}

/// Parses the identity of a device from the name of its key. The last part is its serial number, or
/// an id that the system derived from its socket; only the latter contains a `&`.
fn usb(key: &str) -> Option<Usb> {
    let mut parts = key.rsplit('\\');
    let (instance, ids) = (parts.next()?, parts.next()?);
    let field = |name: &str, radix| {
        let text = ids.split('&').find_map(|id| id.strip_prefix(name))?;
        u16::from_str_radix(text, radix).ok()
    };
    let made_up = instance.contains('&');
    let instance = instance.to_owned();
    Some(Usb {
        vendor: field("VID_", 16)?,
        product: field("PID_", 16)?,
        name: None,
        manufacturer: None,
        serial: Some(instance.clone()).filter(|_| !made_up),
        location: Some(instance).filter(|_| made_up),
        interface: field("MI_", 16).and_then(|number| number.try_into().ok()),
    })
}

/// Adds the properties in the values of the device's key.
fn describe(usb: &mut Usb, text: &str) {
    for (name, text) in text.lines().filter_map(value) {
        // `@oem12.inf,%mfg%;Silicon Labs`: the text follows the last semicolon.
        let text = text.rsplit(';').next().unwrap_or_default().to_owned();
        match name {
            "DeviceDesc" => usb.name = Some(text),
            "Mfg" => usb.manufacturer = Some(text),
            "LocationInformation" if usb.location.is_none() => usb.location = Some(text),
            // Other values of the key are of no interest.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = "\r\n\
        HKEY_LOCAL_MACHINE\\SYSTEM\\CurrentControlSet\\Enum\\USB\\VID_10C4&PID_EA60\\0001\\Device Parameters\r\n    \
            PortName    REG_SZ    COM3\r\n\r\n\
        HKEY_LOCAL_MACHINE\\SYSTEM\\CurrentControlSet\\Enum\\USB\\VID_1A86&PID_7523\\5&2c5d0b7&0&3\\Device Parameters\r\n    \
            PortName    REG_SZ    COM12\r\n\r\n\
        HKEY_LOCAL_MACHINE\\SYSTEM\\CurrentControlSet\\Enum\\USB\\VID_10C4&PID_EA70&MI_01\\7&1f&0&0001\\Device Parameters\r\n    \
            PortName    REG_SZ    COM4\r\n\r\n\
        End of search: 3 match(es) found.\r\n";

    #[test]
    fn a_key_says_who_the_device_is() {
        let found = parse(OUTPUT);
        let ports: Vec<&str> = found.iter().map(|one| one.port.as_str()).collect();
        assert_eq!(ports, ["COM3", "COM12", "COM4"]);
        let ids = |one: &Adapter| (one.usb.vendor, one.usb.product, one.usb.interface);
        assert_eq!(
            found.iter().map(ids).collect::<Vec<_>>(),
            [
                (0x10C4, 0xEA60, None),
                (0x1A86, 0x7523, None),
                (0x10C4, 0xEA70, Some(1))
            ]
        );
        assert_eq!(found[0].usb.serial.as_deref(), Some("0001"));
        assert_eq!(found[1].usb.serial, None);
        assert_eq!(found[1].usb.location.as_deref(), Some("5&2c5d0b7&0&3"));
        assert!(found[0].key.ends_with(r"VID_10C4&PID_EA60\0001"));
    }

    #[test]
    fn its_values_name_it() {
        let mut usb = parse(OUTPUT).swap_remove(0).usb;
        describe(
            &mut usb,
            "HKEY_LOCAL_MACHINE\\...\r\n    \
                DeviceDesc    REG_SZ    @oem12.inf,%cp210x.devdesc%;Silicon Labs CP210x USB to UART Bridge\r\n    \
                LocationInformation    REG_SZ    Port_#0003.Hub_#0001\r\n    \
                Mfg    REG_SZ    @oem12.inf,%mfg%;Silicon Labs\r\n    \
                Capabilities    REG_DWORD    0x94\r\n",
        );
        assert_eq!(
            usb.name.as_deref(),
            Some("Silicon Labs CP210x USB to UART Bridge")
        );
        assert_eq!(usb.manufacturer.as_deref(), Some("Silicon Labs"));
        assert_eq!(usb.location.as_deref(), Some("Port_#0003.Hub_#0001"));
    }

    #[test]
    fn what_is_cut_off_or_strange_is_no_port() {
        for end in 0..OUTPUT.len() {
            parse(OUTPUT.get(..end).unwrap_or_default());
        }
        assert_eq!(parse("    PortName    REG_SZ    COM1"), []);
        assert_eq!(
            parse("HKEY_X\\Device Parameters\n PortName REG_SZ COM1"),
            []
        );
        assert_eq!(parse("ERROR: Access is denied."), []);
    }
}
