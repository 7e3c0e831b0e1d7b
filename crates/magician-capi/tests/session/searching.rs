//! `SearchDobot`.

use std::net::Ipv4Addr;

use magician::Port;
use magician_capi::session::{Registry, Surroundings};

use crate::bench::{alone, no_buffer, patient, search};

fn ports() -> Vec<Port> {
    let port = |path: &str, name: &str| Port {
        path: path.into(),
        usb: Some(magician::Usb {
            name: Some(name.into()),
            ..magician::Usb::default()
        }),
    };
    vec![
        port("/dev/ttyUSB0", "CP2102 USB to UART Bridge Controller"),
        port("/dev/ttyACM0", "A mouse"),
        port("COM3", "USB-SERIAL CH340 (COM3)"),
    ]
}

#[test]
fn ports_come_bare_and_addresses_after_them() {
    let surroundings = Surroundings {
        ports,
        network: || vec![Ipv4Addr::new(192, 168, 0, 5)],
        ..alone()
    };
    let registry = Registry::new(surroundings, patient());
    assert_eq!(
        search(&registry, 100),
        (3, "ttyUSB0 COM3 192.168.0.5".into())
    );
    assert_eq!(search(&registry, 13), (3, "ttyUSB0 COM3".into()));
    assert_eq!(search(&registry, 12), (3, "ttyUSB0".into()));
    assert_eq!(registry.search(no_buffer(), 100), 3);
}

#[test]
fn what_the_environment_names_comes_first_and_once() {
    let surroundings = Surroundings {
        variable: |name| (name == "MAGICIAN_PORT").then(|| "COM3".into()),
        ports,
        ..alone()
    };
    let registry = Registry::new(surroundings, patient());
    assert_eq!(search(&registry, 100), (2, "COM3 ttyUSB0".into()));
}

#[test]
fn nothing_is_an_empty_list() {
    let registry = Registry::new(alone(), patient());
    assert_eq!(search(&registry, 100), (0, String::new()));
    assert_eq!(search(&registry, 1), (0, String::new()));
}
