//! Recognition of a serial port after a replug: the same adapter under any name.
//!
//! The device name is not enough, because a system gives it to the next adapter that is plugged in.
//! A serial number identifies an adapter if it is unique among those present and not a default of
//! the maker; otherwise the USB socket does. If neither is conclusive, finding fails instead of
//! guessing.

use super::{Port, Usb, list};
use crate::{Error, ErrorCode, Result, message};

/// Port that was open, to be found again after a replug: the same adapter under any name, never
/// another one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Remembered {
    path: String,
    usb: Option<Usb>,
    /// True if its serial number is unique.
    telling: bool,
}

impl Remembered {
    /// Remembers the port at a path, among those present while it is open.
    pub(crate) fn new(path: &str, present: &[Port]) -> Self {
        let usb = present.iter().find(|port| port.is_at(path));
        let usb = usb.and_then(|port| port.usb.clone());
        let telling = usb.as_ref().is_some_and(|usb| {
            let same = |port: &&Port| port.usb.as_ref().is_some_and(|other| is_kin(usb, other));
            let twins = (present.iter().filter(same)).filter(|port| {
                port.usb.as_ref().and_then(|other| other.serial.as_ref()) == usb.serial.as_ref()
            });
            usb.serial
                .as_deref()
                .is_some_and(|serial| !is_of_all(serial))
                && twins.count() == 1
        });
        Self {
            path: path.to_owned(),
            usb,
            telling,
        }
    }

    /// Returns the current path.
    ///
    /// # Errors
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if it is absent, or cannot be distinguished from
    /// another one.
    pub(crate) fn find(&self, present: &[Port]) -> Result<String> {
        let Some(usb) = &self.usb else {
            // Not a USB device, so the name is all that identifies it.
            return Ok(self.path.clone());
        };
        let kin = |port: &&Port| port.usb.as_ref().is_some_and(|other| is_kin(usb, other));
        let kin: Vec<&Port> = present.iter().filter(kin).collect();
        let of = |port: &&Port| port.usb.clone().unwrap_or_default();
        let same_socket = |port: &&Port| of(port).location == usb.location;
        let same_serial = |port: &&Port| of(port).serial == usb.serial;
        let mut same: Vec<&Port> = kin.iter().copied().filter(same_serial).collect();
        if !self.telling || same.len() > 1 {
            // Two with this serial number, or none that counts: the socket decides.
            match usb.location {
                Some(_) => same.retain(same_socket),
                None => same.retain(|port| port.is_at(&self.path)),
            }
        }
        match (same.as_slice(), kin.is_empty()) {
            ([port], _) => Ok(port.path.clone()),
            (_, true) => Err(self.gone(present)),
            // Adapters of the same make are here, and none can be identified as ours.
            _ => Err(self.another(&kin)),
        }
    }

    fn gone(&self, present: &[Port]) -> Error {
        let message = message!(
            "the adapter of {path} is not plugged in ({found}); plug it in again",
            path = self.path,
            found = list(present)
        );
        Error::new(ErrorCode::NoPort, message)
    }

    fn another(&self, kin: &[&Port]) -> Error {
        let message = message!(
            "the adapter of {path} is not in its socket, and cannot be told from these: {found}; \
                plug it into the same socket again, or connect to its new port",
            path = self.path,
            found = list(kin.iter().copied())
        );
        Error::new(ErrorCode::AnotherArm, message)
    }
}

/// True if two adapters are of the same make, with the same port number.
fn is_kin(one: &Usb, other: &Usb) -> bool {
    let make = |usb: &Usb| (usb.vendor, usb.product, usb.interface);
    make(one) == make(other)
}

/// True if a serial number is the maker's default: 0001 in the CP210x, for example.
fn is_of_all(serial: &str) -> bool {
    serial.trim_start_matches('0').len() <= 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    fn port(path: &str, serial: Option<&str>, location: &str) -> Port {
        let usb = Usb {
            vendor: 0x10C4,
            product: 0xEA60,
            serial: serial.map(Into::into),
            location: Some(location.into()),
            ..Usb::default()
        };
        Port {
            path: path.into(),
            usb: Some(usb),
        }
    }

    fn found(before: &[Port], path: &str, now: &[Port]) -> Option<String> {
        match Remembered::new(path, before).find(now) {
            Ok(path) => Some(path),
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::Port);
                assert!(error.to_string().contains("plug it in"), "{error}");
                None
            }
        }
    }

    #[test]
    fn a_serial_number_is_followed_to_any_name_and_socket() {
        let before = [port("/dev/ttyUSB0", Some("A7"), "1-1")];
        let other = port("/dev/ttyUSB0", Some("B8"), "1-1");
        let moved = port("/dev/ttyUSB1", Some("A7"), "1-2");
        let now = [other.clone(), moved];
        assert_eq!(
            found(&before, "/dev/ttyUSB0", &now).as_deref(),
            Some("/dev/ttyUSB1")
        );
        // Another adapter has its name and its socket.
        assert_eq!(found(&before, "/dev/ttyUSB0", &[other]), None);
        assert_eq!(found(&before, "/dev/ttyUSB0", &[]), None);
    }

    #[test]
    fn without_a_serial_number_of_its_own_the_socket_tells() {
        for serial in [None, Some("0001"), Some("0")] {
            let before = [port("/dev/ttyUSB0", serial, "1-1")];
            let renamed = port("/dev/ttyUSB3", serial, "1-1");
            let elsewhere = port("/dev/ttyUSB0", serial, "1-2");
            assert_eq!(
                found(&before, "/dev/ttyUSB0", &[elsewhere.clone(), renamed]).as_deref(),
                Some("/dev/ttyUSB3")
            );
            assert_eq!(
                found(&before, "/dev/ttyUSB0", &[elsewhere]),
                None,
                "{serial:?}"
            );
        }
    }

    #[test]
    fn a_serial_number_that_two_had_tells_nothing() {
        let twins = [
            port("/dev/ttyUSB0", Some("A7"), "1-1"),
            port("/dev/ttyUSB1", Some("A7"), "1-2"),
        ];
        assert_eq!(found(&twins, "/dev/ttyUSB0", &twins[1..]), None);
        assert_eq!(
            found(&twins, "/dev/ttyUSB1", &twins).as_deref(),
            Some("/dev/ttyUSB1")
        );
        // The twin came later: the socket decides while one of the two is in it.
        let alone = &twins[..1];
        assert_eq!(
            found(alone, "/dev/ttyUSB0", &twins).as_deref(),
            Some("/dev/ttyUSB0")
        );
    }

    #[test]
    fn the_ports_of_one_adapter_are_not_mixed_up() {
        let with = |interface, path| {
            let mut port = port(path, Some("A7"), "1-1");
            port.usb.as_mut().unwrap().interface = Some(interface);
            port
        };
        let before = [with(0, "/dev/ttyUSB0"), with(1, "/dev/ttyUSB1")];
        let now = [with(1, "/dev/ttyUSB0"), with(0, "/dev/ttyUSB1")];
        assert_eq!(
            found(&before, "/dev/ttyUSB1", &now).as_deref(),
            Some("/dev/ttyUSB0")
        );
    }

    #[test]
    fn what_is_not_usb_has_only_its_name() {
        let plain = Port {
            path: "/dev/ttyS0".into(),
            usb: None,
        };
        assert_eq!(
            found(&[plain], "/dev/ttyS0", &[]).as_deref(),
            Some("/dev/ttyS0")
        );
        assert_eq!(found(&[], "./arm", &[]).as_deref(), Some("./arm"));
    }
}
