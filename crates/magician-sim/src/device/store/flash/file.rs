//! The text form of the flash.

use std::sync::Arc;

use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Flag, Frame, FrameBuf, Layout, Request, Set};
use serde::{Deserialize, Serialize};

use super::{Flash, FlashError};
use crate::device::store::program::Program;
use crate::profile::{MAX_NAME, MAX_SERIAL, MAX_STORED_COMMANDS};

/// Format version: the only one written and accepted.
const VERSION: u32 = 1;

/// The version alone. It is read first, so that a newer file is reported by its version and not by
/// an unknown key.
#[derive(Deserialize)]
struct Versioned {
    version: u32,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct File {
    version: u32,
    name: Words,
    serial: Words,
    wifi: Wifi,
    calibration: Calibration,
    program: Lines,
}

/// Text as sent by hosts, which need not be UTF-8.
#[derive(Deserialize, Serialize)]
#[serde(untagged)]
enum Words {
    Text(String),
    Bytes(Vec<u8>),
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Wifi {
    ssid: Words,
    password: Words,
    /// The flag byte as it was sent.
    dhcp: u8,
    address: [u8; 4],
    netmask: [u8; 4],
    gateway: [u8; 4],
    dns: [u8; 4],
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Calibration {
    rear_arm_error: f32,
    front_arm_error: f32,
    rear_arm_coefficient: f32,
    front_arm_coefficient: f32,
    base_error: f32,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Lines {
    loops: u32,
    /// Queued frames in hex.
    lines: Vec<String>,
}

impl Words {
    fn of(bytes: &[u8]) -> Self {
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::Text(text.to_owned()),
            Err(_) => Self::Bytes(bytes.to_vec()),
        }
    }

    /// Decodes the text into a layout that consists of text only.
    fn read<L: Layout>(&self, name: &str, most: usize) -> Result<L, FlashError> {
        let bytes = match self {
            Self::Text(text) => text.as_bytes(),
            Self::Bytes(bytes) => bytes,
        };
        let wrong = || FlashError::Value {
            name: name.to_owned(),
            rule: "text without NUL that the arm can keep",
        };
        // NUL ends a text on the wire (E17), so a stored one cannot contain it.
        if bytes.len() > most || bytes.contains(&0) {
            return Err(wrong());
        }
        L::decode(bytes).map_err(|_| wrong())
    }
}

impl Flash {
    /// Writes the flash as text, for [`from_toml`](Self::from_toml).
    #[must_use]
    pub fn to_toml(&self) -> String {
        let lines = self.program.lines.iter().filter_map(line_to_hex).collect();
        // Version first: a reader must recognise a newer file before anything else.
        let file = File {
            version: VERSION,
            name: Words::of(self.name.device_name.as_bytes()),
            serial: Words::of(self.serial.device_sn.as_bytes()),
            wifi: Wifi {
                ssid: Words::of(self.wifi_ssid.ssid.as_bytes()),
                password: Words::of(self.wifi_password.password.as_bytes()),
                dhcp: self.wifi_address.dhcp.0,
                address: self.wifi_address.addr,
                netmask: self.wifi_netmask.addr,
                gateway: self.wifi_gateway.addr,
                dns: self.wifi_dns.addr,
            },
            calibration: Calibration {
                rear_arm_error: self.angle_error.rear_arm_angle_error,
                front_arm_error: self.angle_error.front_arm_angle_error,
                rear_arm_coefficient: self.angle_coef.rear_arm_angle_coef,
                front_arm_coefficient: self.angle_coef.front_arm_angle_coef,
                base_error: self.base_error.base_decoder_error,
            },
            program: Lines {
                loops: self.program.loops,
                lines,
            },
        };
        let text = toml::to_string_pretty(&file).expect("numbers and text are TOML");
        format!("# What a virtual Dobot Magician keeps without power.\n{text}")
    }

    /// Parses a flash file. Every key must be present; unknown keys are errors.
    ///
    /// # Errors
    /// [`FlashError`] if the text is not a valid flash file.
    pub fn from_toml(text: &str) -> Result<Self, FlashError> {
        let syntax = |error: toml::de::Error| FlashError::syntax(text, &error);
        let Versioned { version } = toml::from_str(text).map_err(syntax)?;
        if version != VERSION {
            return Err(FlashError::Version(version));
        }
        let File {
            version: _,
            name,
            serial,
            wifi,
            calibration,
            program,
        } = toml::from_str(text).map_err(syntax)?;
        Ok(Self {
            serial: serial.read("serial", MAX_SERIAL)?,
            name: name.read("name", MAX_NAME)?,
            wifi_ssid: wifi.ssid.read("wifi.ssid", usize::MAX)?,
            wifi_password: wifi.password.read("wifi.password", usize::MAX)?,
            wifi_address: WifiIpAddress {
                dhcp: Flag(wifi.dhcp),
                addr: wifi.address,
            },
            wifi_netmask: WifiNetmask { addr: wifi.netmask },
            wifi_gateway: WifiGateway { addr: wifi.gateway },
            wifi_dns: WifiDns { addr: wifi.dns },
            angle_error: AngleSensorStaticError {
                rear_arm_angle_error: calibration.rear_arm_error,
                front_arm_angle_error: calibration.front_arm_error,
            },
            angle_coef: AngleSensorCoef {
                rear_arm_angle_coef: calibration.rear_arm_coefficient,
                front_arm_angle_coef: calibration.front_arm_coefficient,
            },
            base_error: BaseDecoderStaticError {
                base_decoder_error: calibration.base_error,
            },
            program: program.read()?,
        })
    }
}

impl Lines {
    fn read(&self) -> Result<Program, FlashError> {
        if self.lines.len() > MAX_STORED_COMMANDS {
            return Err(FlashError::Value {
                name: "program.lines".to_owned(),
                rule: "at most 65536 commands",
            });
        }
        let read = |(at, hex): (usize, &String)| {
            line_of_hex(hex).ok_or_else(|| FlashError::Value {
                name: format!("line {} of program.lines", at + 1),
                rule: "a queued command as a frame in hex",
            })
        };
        let lines: Result<Vec<Set>, _> = self.lines.iter().enumerate().map(read).collect();
        Ok(Program {
            loops: self.loops,
            lines: Arc::new(lines?),
        })
    }
}

/// Formats a line as the frame that queued it. A decoded command always fits a frame.
fn line_to_hex(set: &Set) -> Option<String> {
    let frame = FrameBuf::set(set, Ctrl::QUEUED).ok()?;
    let bytes: Vec<String> = (frame.bytes().iter())
        .map(|byte| format!("{byte:02X}"))
        .collect();
    Some(bytes.join(" "))
}

fn line_of_hex(hex: &str) -> Option<Set> {
    let bytes: Option<Vec<u8>> = hex
        .split_ascii_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).ok())
        .collect();
    let bytes = bytes?;
    let frame = Frame::new(&bytes)?;
    // The controller's own decoder: a file may contain only commands that a host could queue.
    match Request::decode(&frame) {
        Ok(Request::Queue(set)) => Some(set),
        _ => None,
    }
}
