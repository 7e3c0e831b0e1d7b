//! Connecting, disconnecting and reconnecting.

use magician::commands::{DeviceName, QueuedCmdStopExec};
use magician::protocol::Text;
use magician_capi::session::{Environment, Registry};
use magician_capi::{Family, call};

use crate::bench::{
    connect_v1, connect_without_buffers, fault, home, isolated_environment, long_timeouts,
    no_buffer, no_text, pose, registry, run,
};

#[test]
fn without_a_name_and_without_a_port_nothing_is_found() {
    let registry = registry();
    let said = connect_v1(&registry, "");
    assert_eq!((said.code, said.firmware.as_str()), (1, ""));
    assert!(fault().contains("MAGICIAN_PORT"), "{}", fault());
    let null = registry.connect_v1(no_text(), 115_200, no_buffer(), no_buffer());
    assert_eq!(null, 1);
    let (code, bytes) = pose(&registry);
    assert_eq!((code, bytes[0]), (2, crate::bench::UNTOUCHED));
}

#[test]
fn unopenable_port_is_reported_as_occupied() {
    let registry = registry();
    for name in [
        "COM250",
        "/dev/tty-of-no-arm",
        "udp:",
        "tcp:h",
        "arm:",
        "\u{1}",
    ] {
        assert_eq!(connect_v1(&registry, name).code, 2, "{name}");
        assert!(fault().starts_with("ConnectDobot: "), "{}", fault());
    }
    connect_v1(&registry, "COM250");
    assert!(fault().contains("MAGICIAN_PORT_COM250=PORT"), "{}", fault());
}

#[test]
fn a_virtual_arm_is_named_by_the_environment() {
    let of = |variable| {
        let environment = Environment {
            variable,
            ..isolated_environment()
        };
        Registry::new(environment, long_timeouts())
    };
    let everywhere = of(|name| (name == "MAGICIAN_PORT").then(|| "sim".into()));
    let said = connect_v1(&everywhere, "");
    assert_eq!((said.code, said.firmware.as_str()), (0, "DobotSerial"));
    assert_eq!(said.version, "0.0.0");
    assert_eq!(pose(&everywhere).0, 0);
    let sent = of(|name| (name == "MAGICIAN_PORT_COM3").then(|| "sim".into()));
    assert_eq!(connect_without_buffers(&sent, "COM3"), 0);
    assert_eq!(connect_without_buffers(&sent, "COM4"), 2);
}

#[test]
fn reconnecting_finds_the_arm_unchanged() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let name = DeviceName {
        device_name: Text::new("left alone").unwrap(),
    };
    run(&registry, "SetDeviceName", 0, |arm| call::set(arm, &name));
    run(&registry, "SetQueuedCmdStopExec", 0, |arm| {
        call::set(arm, &QueuedCmdStopExec {})
    });
    assert_eq!(home(&registry), (0, 2));
    for index in 3..6 {
        assert_eq!(registry.disconnect(0), 0);
        assert_eq!(pose(&registry).0, 2, "nobody is connected");
        assert_eq!(connect_v1(&registry, "sim").code, 0);
        let arm = registry.find(Family::V1, 0).unwrap();
        assert_eq!(arm.get::<DeviceName>().unwrap(), name);
        assert_eq!(home(&registry), (0, index), "the queue kept what it had");
    }
}

#[test]
fn second_connection_replaces_the_first() {
    let registry = registry();
    connect_v1(&registry, "sim");
    assert_eq!(home(&registry).0, 0);
    let before = registry.find(Family::V1, 0).unwrap();
    assert_eq!(connect_v1(&registry, "sim").code, 0);
    assert_eq!(home(&registry), (0, 3), "it is the same arm");
    let released = before.get::<DeviceName>().unwrap_err();
    assert_eq!(released.code as i32, 0, "{released}");
}

#[test]
fn disconnecting_never_fails() {
    let registry = registry();
    for id in [0, 0, -1, 99] {
        assert_eq!(registry.disconnect(id), 0);
    }
    connect_v1(&registry, "sim");
    assert_eq!(registry.disconnect(0), 0);
    assert_eq!(registry.disconnect(0), 0);
}

#[test]
fn new_virtual_arm_executes_its_queue() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let (code, index) = home(&registry);
    assert_eq!((code, index), (0, 2));
    let arm = registry.find(Family::V1, 0).unwrap();
    let finished = |arm: &magician_capi::session::Session| {
        let read = arm.get::<magician::commands::QueuedCmdCurrentIndex>();
        read.unwrap().queued_cmd_current_index
    };
    while finished(&arm) < index {
        std::thread::yield_now();
    }
}

#[test]
fn traffic_is_traced() {
    static PATH: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trace.pcapng");
    PATH.set(path.to_str().unwrap().to_owned()).unwrap();
    let variable = |name: &str| PATH.get().filter(|_| name == "MAGICIAN_TRACE").cloned();
    let environment = Environment {
        variable,
        ..isolated_environment()
    };
    let registry = Registry::new(environment, long_timeouts());
    connect_v1(&registry, "sim");
    pose(&registry);
    registry.disconnect(0);
    let trace = std::fs::read(path).unwrap();
    let get_pose = [0xAA, 0xAA, 2, 10, 0, 0xF6];
    assert!(trace.windows(6).any(|bytes| bytes == get_pose));
}
