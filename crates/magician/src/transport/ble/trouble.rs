//! What can be wrong with Bluetooth, and what to do about it.

use std::time::Duration;

use crate::{Error, ErrorKind};

fn port(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::Port, message)
}

pub(super) fn no_adapter() -> Error {
    port("this computer has no Bluetooth adapter; plug one in, or use USB or Wi-Fi")
}

pub(super) fn switched_off() -> Error {
    let how = if cfg!(target_os = "linux") {
        "switch it on in the settings, or with `rfkill unblock bluetooth` and `bluetoothctl power on`"
    } else {
        "switch it on in the settings"
    };
    port(format!("Bluetooth is off; {how}"))
}

pub(super) fn silent(waited: Duration) -> Error {
    port(format!(
        "the system's Bluetooth does not answer within {} s",
        waited.as_secs()
    ))
}

/// Bluetooth itself cannot be used.
pub(super) fn of_system(error: btleplug::Error) -> Error {
    // The name of the error on D-Bus is only in what it says to developers.
    let known = format!("{error:?}");
    let among = |names: &[&str]| names.iter().any(|name| known.contains(name));
    if matches!(error, btleplug::Error::NoAdapterAvailable) {
        return no_adapter();
    }
    if among(&["ServiceUnknown", "NameHasNoOwner", "Spawn."]) {
        return port(format!(
            "Bluetooth does not run on this computer ({error}); install `bluez` and start it: `sudo systemctl enable --now \
             bluetooth`"
        ));
    }
    if among(&["FileNotFound", "NoServer"]) || (cfg!(target_os = "linux") && among(&["socket"])) {
        return port(format!(
            "the system's D-Bus, through which Bluetooth is reached, is not there ({error}); in a container, pass \
             /run/dbus/system_bus_socket in"
        ));
    }
    if among(&["AccessDenied", "AuthFailed", "PermissionDenied"]) {
        return port(format!(
            "no permission to use Bluetooth ({error}); {PERMIT}"
        ));
    }
    if among(&["NotReady"]) {
        return switched_off();
    }
    port(format!("Bluetooth cannot be used: {error}"))
}

const PERMIT: &str = if cfg!(target_os = "linux") {
    "join its group with `sudo usermod -aG bluetooth $USER` and log in again"
} else if cfg!(target_os = "macos") {
    "allow it for the program that this runs in: System Settings, Privacy & Security, Bluetooth"
} else {
    "allow it in the privacy settings"
};

/// One device cannot be used.
pub(super) fn of_device(wanted: &str, what: &str, error: btleplug::Error) -> Error {
    let known = format!("{error:?}");
    let guarded = ["Authenti", "NotAuthorized", "NotPermitted", "Insufficient"];
    let hint = if guarded.iter().any(|name| known.contains(name)) {
        "; it may want to be paired first, in the settings or with `bluetoothctl pair ADDRESS`"
    } else {
        "; is it near, and is no phone or other computer connected to it?"
    };
    port(format!("ble:{wanted} {what}: {error}{hint}"))
}
