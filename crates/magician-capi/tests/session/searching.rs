//! `SearchDobot`.

use std::net::Ipv4Addr;

use magician::Port;
use magician_capi::session::{Environment, Registry};

use crate::bench::{isolated_environment, long_timeouts, no_buffer, search};

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
fn ports_are_listed_without_prefix_before_addresses() {
    let environment = Environment {
        ports,
        network: || vec![Ipv4Addr::new(192, 168, 0, 5)],
        ..isolated_environment()
    };
    let registry = Registry::new(environment, long_timeouts());
    assert_eq!(
        search(&registry, 100),
        (3, "ttyUSB0 COM3 192.168.0.5".into())
    );
    assert_eq!(search(&registry, 13), (3, "ttyUSB0 COM3".into()));
    assert_eq!(search(&registry, 12), (3, "ttyUSB0".into()));
    assert_eq!(registry.search(no_buffer(), 100), 3);
}

#[test]
fn port_of_the_environment_is_listed_first_and_once() {
    let environment = Environment {
        variable: |name| (name == "MAGICIAN_PORT").then(|| "COM3".into()),
        ports,
        ..isolated_environment()
    };
    let registry = Registry::new(environment, long_timeouts());
    assert_eq!(search(&registry, 100), (2, "COM3 ttyUSB0".into()));
}

#[test]
fn no_port_gives_an_empty_list() {
    let registry = Registry::new(isolated_environment(), long_timeouts());
    assert_eq!(search(&registry, 100), (0, String::new()));
    assert_eq!(search(&registry, 1), (0, String::new()));
}
