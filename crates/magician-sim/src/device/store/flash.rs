//! The controller's flash: data that survives a loss of power (model sections 6 and 12).

use magician_protocol::commands::*;
use magician_protocol::{Flag, Text};

use super::program::Program;
use crate::Profile;
use crate::document::{self, DocumentError};
use crate::profile::WifiDefaults;

mod file;

/// Data that a controller keeps without power and through a reset: name and serial number, Wi-Fi
/// settings, calibration of the sensors, and the program for the base key.
///
/// A host has to set everything else anew (model section 6). As text it is TOML with a version. NaN
/// and infinity are kept as such, not bit for bit.
///
/// ```
/// use magician_sim::{Controller, Flash, Profile, World};
///
/// let before = Controller::default();
/// let text = before.flash().to_toml();
/// let flash = Flash::from_toml(&text)?;
/// let after = Controller::with_flash(Profile::default(), World::default(), flash);
/// assert_eq!(after.flash(), before.flash());
/// # Ok::<(), magician_sim::FlashError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Flash {
    pub(crate) serial: DeviceSn,
    pub(crate) name: DeviceName,
    pub(crate) wifi_ssid: WifiSsid,
    pub(crate) wifi_password: WifiPassword,
    pub(crate) wifi_address: WifiIpAddress,
    pub(crate) wifi_netmask: WifiNetmask,
    pub(crate) wifi_gateway: WifiGateway,
    pub(crate) wifi_dns: WifiDns,
    pub(crate) angle_error: AngleSensorStaticError,
    pub(crate) angle_coef: AngleSensorCoef,
    pub(crate) base_error: BaseDecoderStaticError,
    pub(crate) program: Program,
}

/// Reason why a text is not a valid flash file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FlashError {
    /// Not valid TOML, a missing value, or an unknown key.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Description of the error.
        message: String,
    },
    /// Not a text file.
    #[error("{0}")]
    Document(#[from] DocumentError),
    /// Written by another version of this software.
    #[error("its version is {0}, only version 1 is known")]
    Version(u32),
    /// A value is out of range.
    #[error("{name} must be {rule}")]
    Value {
        /// Key in the file.
        name: String,
        /// Rule that the value breaks.
        rule: &'static str,
    },
}

impl FlashError {
    fn syntax(text: &str, error: &toml::de::Error) -> Self {
        let (line, column, message) = document::locate(text, error);
        Self::Syntax {
            line,
            column,
            message,
        }
    }
}

fn text(from: &str) -> Text {
    Text::new(from).unwrap_or_default()
}

impl Flash {
    /// Returns the flash of a new arm with this profile.
    #[must_use]
    pub fn new(profile: &Profile) -> Self {
        let WifiDefaults {
            ssid,
            password,
            dhcp,
            address,
            netmask,
            gateway,
            dns,
        } = &profile.defaults.wifi;
        Self {
            serial: DeviceSn {
                device_sn: text(&profile.identity.serial),
            },
            name: DeviceName {
                device_name: text(&profile.identity.name),
            },
            wifi_ssid: WifiSsid { ssid: text(ssid) },
            wifi_password: WifiPassword {
                password: text(password),
            },
            wifi_address: WifiIpAddress {
                dhcp: Flag::from(*dhcp),
                addr: *address,
            },
            wifi_netmask: WifiNetmask { addr: *netmask },
            wifi_gateway: WifiGateway { addr: *gateway },
            wifi_dns: WifiDns { addr: *dns },
            angle_error: AngleSensorStaticError {
                rear_arm_angle_error: 0.0,
                front_arm_angle_error: 0.0,
            },
            // A coefficient of 1 and errors of 0 leave the sensors as they are.
            angle_coef: AngleSensorCoef {
                rear_arm_angle_coef: 1.0,
                front_arm_angle_coef: 1.0,
            },
            base_error: BaseDecoderStaticError {
                base_decoder_error: 0.0,
            },
            program: Program::default(),
        }
    }

    /// Number of commands of the stored program, and number of its passes.
    #[must_use]
    pub fn program(&self) -> (usize, u32) {
        (self.program.lines.len(), self.program.loops)
    }
}
