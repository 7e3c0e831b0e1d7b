//! Dangerous commands are sent only if they were allowed by name.

use magician::Ctrl;
use magician::commands::{DeviceSn, ResetPose};
use magician::protocol::{Flag, Text};
use magician_capi::call;
use magician_capi::session::{Environment, Registry};

use crate::bench::{
    connect_v1, fault, isolated_environment, long_timeouts, registry, run, with_text,
};

fn serial() -> DeviceSn {
    DeviceSn {
        device_sn: Text::new("DT0").unwrap(),
    }
}

fn set_serial(registry: &Registry) -> i32 {
    run(registry, "SetDeviceSN", 0, |arm| call::set(arm, &serial()))
}

fn reset_pose(registry: &Registry) -> i32 {
    let reset = ResetPose {
        manual: Flag::OFF,
        rear_arm_angle: 0.0,
        front_arm_angle: 0.0,
    };
    run(registry, "ResetPose", 0, |arm| call::set(arm, &reset))
}

#[test]
fn dangerous_commands_are_refused_until_allowed() {
    let registry = registry();
    connect_v1(&registry, "sim");
    assert_eq!(set_serial(&registry), 3);
    assert!(
        fault().contains("MAGICIAN_ALLOW=SetDeviceSN"),
        "{}",
        fault()
    );
    let arm = registry.find(magician_capi::Family::V1, 0).unwrap();
    let before = arm.get::<DeviceSn>().unwrap();
    assert_ne!(before, serial(), "nothing was sent, and reading is free");
    assert_eq!(with_text("SetDeviceSN", |names| registry.allow(names)), 0);
    assert_eq!(set_serial(&registry), 0);
    assert_eq!(arm.get::<DeviceSn>().unwrap(), serial());
    assert_eq!(reset_pose(&registry), 3, "it was not named");
    assert_eq!(with_text("all", |names| registry.allow(names)), 0);
    assert_eq!(reset_pose(&registry), 0);
}

#[test]
fn unknown_name_is_reported() {
    let registry = registry();
    connect_v1(&registry, "sim");
    assert_eq!(
        with_text("SetDeviceSNN, ResetPose", |names| registry.allow(names)),
        3
    );
    assert!(fault().contains("SetDeviceSNN"), "{}", fault());
    assert_eq!(reset_pose(&registry), 0, "the other one counts");
    assert_eq!(set_serial(&registry), 3);
    assert_eq!(with_text("", |names| registry.allow(names)), 0);
}

#[test]
fn environment_allows_dangerous_commands() {
    let variable =
        |name: &str| (name == "MAGICIAN_ALLOW").then(|| "setdevicesn,UpdateFirmware".into());
    let environment = Environment {
        variable,
        ..isolated_environment()
    };
    let registry = Registry::new(environment, long_timeouts());
    connect_v1(&registry, "sim");
    assert_eq!(set_serial(&registry), 0);
    assert_eq!(reset_pose(&registry), 3);
}

#[test]
fn raw_frames_need_the_same_permission() {
    let registry = registry();
    connect_v1(&registry, "sim");
    let send_raw = |ctrl, params: &[u8]| {
        let arm = registry.find(magician_capi::Family::V1, 0).unwrap();
        arm.raw(160, ctrl, params).map(drop)
    };
    assert_eq!(
        send_raw(Ctrl::GET, &[1]).unwrap_err().code as i32,
        3,
        "a read that switches"
    );
    assert_eq!(send_raw(Ctrl::SET, &[1]).unwrap_err().code as i32, 3);
}

#[test]
fn every_guarded_function_can_be_allowed_by_its_name() {
    let guarded = magician_capi::FUNCTIONS
        .iter()
        .filter(|function| function.kind == magician_capi::Kind::Guarded);
    let mut count = 0;
    for function in guarded {
        let allowed = with_text(function.name, |names| registry().allow(names));
        assert_eq!(allowed, 0, "{}", function.name);
        count += 1;
    }
    assert!(count > 5);
}
