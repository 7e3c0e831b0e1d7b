//! Error messages of Bluetooth, with remedies.

use std::time::Duration;

use crate::{Act, Error, ErrorCode};

fn port(message: impl Into<String>) -> Error {
    Error::new(ErrorCode::PortFailed, message.into())
}

pub(super) fn no_adapter() -> Error {
    port("this computer has no Bluetooth adapter; plug one in, or use USB or Wi-Fi")
}

pub(super) fn switched_off() -> Error {
    let error = port("Bluetooth is off; switch it on in the settings");
    if cfg!(target_os = "linux") {
        error.remedy(
            Act::System("rfkill unblock bluetooth && bluetoothctl power on".into()),
            "switches it on too",
        )
    } else {
        error
    }
}

pub(super) fn silent(waited: Duration) -> Error {
    port(format!(
        "the system's Bluetooth does not answer within {} s",
        waited.as_secs()
    ))
}

/// Returns the error for a Bluetooth system that cannot be used.
pub(super) fn of_system(error: btleplug::Error) -> Error {
    // Only the debug output contains the name of the D-Bus error.
    let known = format!("{error:?}");
    let among = |names: &[&str]| names.iter().any(|name| known.contains(name));
    if matches!(error, btleplug::Error::NoAdapterAvailable) {
        return no_adapter();
    }
    if among(&["ServiceUnknown", "NameHasNoOwner", "Spawn."]) {
        return port(format!(
            "Bluetooth does not run on this computer ({error}); install bluez"
        ))
        .remedy(
            Act::System("sudo systemctl enable --now bluetooth".into()),
            "starts it",
        );
    }
    if among(&["FileNotFound", "NoServer"]) || (cfg!(target_os = "linux") && among(&["socket"])) {
        return port(format!(
            "the system's D-Bus, which Bluetooth needs, is missing ({error}); in a container, \
                mount /run/dbus/system_bus_socket"
        ));
    }
    if among(&["AccessDenied", "AuthFailed", "PermissionDenied"]) {
        return forbidden(&error);
    }
    if among(&["NotReady"]) {
        return switched_off();
    }
    port(format!("Bluetooth cannot be used: {error}"))
}

fn forbidden(error: &btleplug::Error) -> Error {
    let permit = if cfg!(target_os = "linux") {
        ""
    } else if cfg!(target_os = "macos") {
        "; allow it for the program that runs this one: System Settings, Privacy & Security, \
            Bluetooth"
    } else {
        "; allow it in the privacy settings"
    };
    let message = format!("no permission to use Bluetooth ({error}){permit}");
    let error = Error::new(ErrorCode::PortForbidden, message);
    if cfg!(target_os = "linux") {
        error.remedy(
            Act::System("sudo usermod -aG bluetooth $USER".into()),
            "lets you use it from the next login on",
        )
    } else {
        error
    }
}

/// Returns the error for a device that cannot be used.
pub(super) fn of_device(wanted: &str, what: &str, error: btleplug::Error) -> Error {
    let known = format!("{error:?}");
    let guarded = ["Authenti", "NotAuthorized", "NotPermitted", "Insufficient"];
    if guarded.iter().any(|name| known.contains(name)) {
        let message = format!("ble:{wanted} {what}: {error}; it may need to be paired first");
        return port(message).remedy(Act::System("bluetoothctl pair ADDRESS".into()), "pairs it");
    }
    port(format!(
        "ble:{wanted} {what}: {error}; is it near, and is no phone or other computer connected to it?"
    ))
}
