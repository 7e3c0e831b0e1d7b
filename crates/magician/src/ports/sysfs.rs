//! USB devices in sysfs, and the device behind a port. Tested on folders with its structure.

use std::path::Path;

use super::Usb;

/// Returns the USB device of a port. `class` is `/sys/class/tty`: the port's entry there leads
/// through its USB interface (`1-1.4:1.0`) to its USB device (`1-1.4`).
#[cfg(target_os = "linux")]
pub(super) fn usb(class: &Path, port: &Path) -> Option<Usb> {
    // The name of a symbolic link has no entry in sysfs.
    let port = port.canonicalize().unwrap_or_else(|_| port.to_owned());
    let device = class.join(port.file_name()?).join("device");
    let device = device.canonicalize().ok()?;
    let usb = device
        .ancestors()
        .find(|dir| dir.join("idVendor").exists())?;
    let interface = device
        .ancestors()
        .find_map(|dir| text(&dir.join("bInterfaceNumber")));
    Some(Usb {
        interface: interface.and_then(|number| u8::from_str_radix(&number, 16).ok()),
        ..self::device(usb)?
    })
}

/// Returns the USB device of a folder, if it belongs to one.
pub(super) fn device(folder: &Path) -> Option<Usb> {
    let text = |file: &str| text(&folder.join(file));
    let number = |file: &str| u16::from_str_radix(&text(file)?, 16).ok();
    Some(Usb {
        vendor: number("idVendor")?,
        product: number("idProduct")?,
        name: text("product"),
        manufacturer: text("manufacturer"),
        serial: text("serial"),
        location: (folder.file_name()).map(|name| name.to_string_lossy().into_owned()),
        interface: None,
    })
}

fn text(file: &Path) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::fs::{create_dir_all, write};
    use std::os::unix::fs::symlink;

    #[test]
    fn reads_the_device_the_interface_and_the_socket() {
        let root = tempfile::tempdir().unwrap();
        let device = root.path().join("devices/pci0000:00/usb1/1-1/1-1.4");
        let port = device.join("1-1.4:1.0/ttyUSB0");
        create_dir_all(port.join("tty/ttyUSB0")).unwrap();
        for (file, text) in [
            ("idVendor", "10c4\n"),
            ("idProduct", "ea60\n"),
            ("serial", "0001\n"),
            ("product", "CP2102 USB to UART Bridge Controller\n"),
            ("manufacturer", "\n"),
            ("1-1.4:1.0/bInterfaceNumber", "00\n"),
        ] {
            write(device.join(file), text).unwrap();
        }
        symlink(&port, port.join("tty/ttyUSB0/device")).unwrap();
        let class = root.path().join("class");
        create_dir_all(&class).unwrap();
        symlink(port.join("tty/ttyUSB0"), class.join("ttyUSB0")).unwrap();
        let usb = usb(&class, Path::new("/dev/ttyUSB0"));
        assert_eq!(
            usb,
            Some(Usb {
                vendor: 0x10C4,
                product: 0xEA60,
                name: Some("CP2102 USB to UART Bridge Controller".into()),
                manufacturer: None,
                serial: Some("0001".into()),
                location: Some("1-1.4".into()),
                interface: Some(0),
            })
        );
        assert_eq!(super::usb(&class, Path::new("/dev/ttyS0")), None);
    }
}
