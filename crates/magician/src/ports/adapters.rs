//! USB adapters that are plugged in without a port, because their driver is missing.

use std::path::Path;

use super::{Kind, Usb, sysfs};

/// USB serial adapter of a known kind, without a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Properties of the USB device.
    pub usb: Usb,
    /// Name of the chip.
    pub chip: &'static str,
    /// Linux kernel module that provides the port.
    pub module: &'static str,
}

/// Returns the adapters of arms and their cables that are plugged in without a port, because a
/// driver is missing. Linux only; empty elsewhere.
#[must_use]
pub fn unbound_adapters() -> Vec<Adapter> {
    unbound_below(Path::new("/sys/bus/usb/devices"))
}

/// Searches a folder with the structure of sysfs.
fn unbound_below(folder: &Path) -> Vec<Adapter> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<_> = entries.map(|entry| entry.path()).collect();
    found.sort();
    let adapters = found.iter().filter_map(|device| adapter(device));
    adapters.collect()
}

/// Returns the device in a folder, if it is an adapter without a port.
fn adapter(device: &Path) -> Option<Adapter> {
    let usb = sysfs::device(device)?;
    let Kind { chip, module, .. } = *usb.kind()?;
    (!has_port(device)).then_some(Adapter { usb, chip, module })
}

/// True if an interface of the device (`1-1:1.0` in `1-1`) has created a terminal.
fn has_port(device: &Path) -> bool {
    let names = |dir: &Path| {
        let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect::<Vec<_>>()
    };
    // The kernel names them `ttyUSB0` or `ttyACM0`, by driver.
    let is_terminal = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("tty")
    };
    let interfaces = names(device).into_iter().filter(|path| path.is_dir());
    interfaces.into_iter().any(|interface| {
        let inside = names(&interface);
        inside.iter().any(|path| is_terminal(path))
    })
}

#[cfg(test)]
mod tests {
    use super::super::{ADAPTERS, udev_rules};
    use super::*;

    fn plug(folder: &Path, name: &str, vendor: &str, product: &str) -> std::path::PathBuf {
        let device = folder.join(name);
        std::fs::create_dir_all(device.join(format!("{name}:1.0"))).unwrap();
        std::fs::write(device.join("idVendor"), format!("{vendor}\n")).unwrap();
        std::fs::write(device.join("idProduct"), format!("{product}\n")).unwrap();
        device
    }

    #[test]
    fn an_adapter_without_a_port_is_found_with_its_module() {
        let folder = tempfile::tempdir().unwrap();
        plug(folder.path(), "usb1", "1d6b", "0002");
        plug(folder.path(), "1-1", "1a86", "7523");
        let bound = plug(folder.path(), "1-2", "10c4", "ea60");
        std::fs::create_dir_all(bound.join("1-2:1.0/ttyUSB0")).unwrap();
        let found = unbound_below(folder.path());
        let found: Vec<_> = found.iter().map(|adapter| adapter.module).collect();
        assert_eq!(found, ["ch341"]);
        assert_eq!(unbound_below(Path::new("/no/such/folder")), []);
    }

    /// Reads a page or file of the repository.
    fn page(name: &str) -> String {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        std::fs::read_to_string(root.join(name)).unwrap()
    }

    #[test]
    fn rules_and_pages_name_each_adapter_of_arms() {
        let rules = page("packaging/70-magician.rules");
        let rules = rules.lines().filter(|line| !line.starts_with('#'));
        assert!(rules.eq(udev_rules()));
        let (troubles, start) = (
            page("docs/guide/TROUBLESHOOTING.md"),
            page("docs/guide/START.md"),
        );
        for kind in ADAPTERS.iter().filter(|kind| kind.in_arms) {
            let ids = format!("{:04x}:{:04x}", kind.vendor, kind.product);
            assert!(troubles.contains(&ids), "{ids}");
            let chip = kind.chip;
            assert!(start.contains(chip) && troubles.contains(chip), "{chip}");
        }
    }
}
