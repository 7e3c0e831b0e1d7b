//! The fence of an arm applies to the vendor's interface: commands across it are refused.

use std::sync::OnceLock;

use magician::commands::{Pose, PtpCmd};
use magician::protocol::PtpMode;
use magician_capi::call;
use magician_capi::session::{Environment, Registry};
use tempfile::TempDir;

use crate::bench::{connect_v1, fault, isolated_environment, long_timeouts, run};

static SETTINGS: OnceLock<TempDir> = OnceLock::new();

/// Path of a settings file with a fence: `good.toml`, or `bad.toml` with a misspelt key.
fn settings(name: &str) -> Option<String> {
    let directory = SETTINGS.get_or_init(|| {
        let directory = tempfile::tempdir().unwrap();
        let text = "[arms.white]\nport = 'sim'\n[arms.white.fence]\nfloor = -60\n";
        std::fs::write(directory.path().join("good.toml"), text).unwrap();
        let text = text.replace("floor", "flour");
        std::fs::write(directory.path().join("bad.toml"), text).unwrap();
        directory
    });
    Some(directory.path().join(name).to_str()?.to_owned())
}

fn registry(variable: fn(&str) -> Option<String>) -> Registry {
    let environment = Environment {
        variable,
        ..isolated_environment()
    };
    Registry::new(environment, long_timeouts())
}

fn go(registry: &Registry, z: f32) -> i32 {
    let command = PtpCmd {
        ptp_mode: PtpMode::MovlXyz,
        x: 220.0,
        y: 0.0,
        z,
        r: 0.0,
    };
    run(registry, "SetPTPCmd", 0, |arm| call::set(arm, &command))
}

#[test]
fn a_motion_across_the_fence_is_refused_with_its_values() {
    let registry = registry(|name| (name == "MAGICIAN_CONFIG").then(|| settings("good.toml"))?);
    connect_v1(&registry, "sim");
    assert_eq!(go(&registry, -50.0), 0);
    assert_eq!(go(&registry, -71.2), 3, "{}", fault());
    let said = "the tool tip would be at z -71.2 mm, the fence's floor is -60.0 mm";
    assert!(fault().contains(said), "{}", fault());
    let arm = registry.find(magician_capi::Family::V1, 0).unwrap();
    assert!(arm.get::<Pose>().unwrap().z >= -60.0);
}

#[test]
fn unreadable_settings_prevent_connecting() {
    let registry = registry(|name| (name == "MAGICIAN_CONFIG").then(|| settings("bad.toml"))?);
    assert_ne!(connect_v1(&registry, "sim").code, 0);
    assert!(fault().contains("bad.toml:4:1"), "{}", fault());
}
