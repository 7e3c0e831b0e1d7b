//! Error messages of Bluetooth, with remedies.

use std::time::Duration;

use crate::{Act, Error, ErrorCode, Message, message};

fn port(message: Message) -> Error {
    Error::new(ErrorCode::PortFailed, message)
}

pub(super) fn no_adapter() -> Error {
    port(message!(
        "this computer has no Bluetooth adapter; plug one in, or use USB or Wi-Fi"
    ))
}

pub(super) fn switched_off() -> Error {
    let error = port(message!("Bluetooth is off; switch it on in the settings"));
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
    port(message!(
        "the system's Bluetooth does not answer within {seconds} s",
        seconds = waited.as_secs()
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
        return port(message!(
            "Bluetooth does not run on this computer ({cause}); install bluez",
            cause = error.to_string()
        ))
        .remedy(
            Act::System("sudo systemctl enable --now bluetooth".into()),
            "starts it",
        );
    }
    if among(&["FileNotFound", "NoServer"]) || (cfg!(target_os = "linux") && among(&["socket"])) {
        return port(message!(
            "the system's D-Bus, which Bluetooth needs, is missing ({cause}); in a container, \
                mount /run/dbus/system_bus_socket",
            cause = error.to_string()
        ));
    }
    if among(&["AccessDenied", "AuthFailed", "PermissionDenied"]) {
        return forbidden(&error);
    }
    if among(&["NotReady"]) {
        return switched_off();
    }
    port(message!(
        "Bluetooth cannot be used: {cause}",
        cause = error.to_string()
    ))
}

fn forbidden(error: &btleplug::Error) -> Error {
    let cause = error.to_string();
    let message = if cfg!(target_os = "linux") {
        message!("no permission to use Bluetooth ({cause})", cause)
    } else if cfg!(target_os = "macos") {
        message!(
            "no permission to use Bluetooth ({cause}); allow it for the program that runs this \
                one: System Settings, Privacy & Security, Bluetooth",
            cause
        )
    } else {
        message!(
            "no permission to use Bluetooth ({cause}); allow it in the privacy settings",
            cause
        )
    };
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
pub(super) fn of_device(wanted: &str, what: &Message, error: btleplug::Error) -> Error {
    let known = format!("{error:?}");
    let guarded = ["Authenti", "NotAuthorized", "NotPermitted", "Insufficient"];
    if guarded.iter().any(|name| known.contains(name)) {
        let message = message!(
            "ble:{wanted} {what}: {cause}; it may need to be paired first",
            wanted,
            what,
            cause = error.to_string()
        );
        return port(message).remedy(Act::System("bluetoothctl pair ADDRESS".into()), "pairs it");
    }
    port(message!(
        "ble:{wanted} {what}: {cause}; is it near, and is no phone or other computer connected to it?",
        wanted,
        what,
        cause = error.to_string()
    ))
}
