//! The parts of a profile that are no matter of motion, with the built-in values: firmware 3.6.14. The pattern
//! (`pattern.rs`) says where each comes from.

use magician_motion::{ArmModel, ToolBias};
use serde::{Deserialize, Serialize};

use super::{PINS, tool};

/// What to do where the real arm's behaviour is unknown ([`fidelity`](crate::fidelity)).
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FidelityRules {
    /// Whether what rests on a choice alone is refused: answered, and not carried out.
    pub strict: bool,
}

/// The identity that the arm reports (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Identity {
    /// Firmware version.
    pub version: [u8; 3],
    /// Name, at most 64 bytes.
    pub name: String,
    /// Serial number, at most 23 bytes.
    pub serial: String,
    /// The three words of GetDeviceID are drawn from it.
    pub device_id_seed: u64,
}

/// How the controller wakes (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PowerUp {
    /// The joints it reports before homing, deg.
    pub joints: [f64; 4],
    /// The tool bias that was chosen before and is kept, mm; in the file, the name of a tool or `[x, y, z]`. A scenario
    /// that says what tool is on the arm goes before it.
    #[serde(deserialize_with = "tool::read", serialize_with = "tool::write")]
    pub tool: ToolBias,
    /// Whether alarm 0x00 stands.
    pub reset_alarm: bool,
    /// Whether the queue runs without a start.
    pub queue_started: bool,
}

/// How the command queue behaves (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct QueueRules {
    /// Places, the running command's included; 1 to 1024.
    pub depth: usize,
    /// The index of the first command, at least 1.
    pub first_index: u64,
    /// Whether an alarm above 0x07 holds the queue.
    pub alarms_hold: bool,
    /// Whether Clear ends the running motion where it is.
    pub clear_ends_motion: bool,
}

/// Stopping (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stopping {
    /// ForceStop brakes with this many times the acceleration in force; above 0.
    pub force_factor: f64,
}

/// Hand teaching (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct HandTeaching {
    /// From point to point while the unlock key is held and points are taught periodically, s; above 0.
    pub period: f64,
}

/// The Wi-Fi module (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wifi {
    /// From power-up, or from when it leaves its command mode, until it has joined its network, s.
    pub association: f64,
}

/// Programs in the flash, which the arm runs without a host (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Offline {
    /// Commands that a program may have, 1 to 65536.
    pub capacity: usize,
}

/// Suction cup and gripper (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tools {
    /// From the command until the suction cup holds or lets go, s.
    pub vacuum_delay: f64,
    /// From the command until the gripper is closed or open, s.
    pub gripper_delay: f64,
}

/// The pins of the connectors (model section 13).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pins {
    /// Whether a function that the pin lacks is refused; else it is stored and has no effect.
    pub strict: bool,
    /// What each of the 20 addresses can do.
    pub pins: Vec<PinFunctions>,
}

/// What one pin can do: in the file, words out of `DO`, `PWM`, `DI` and `ADC`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub struct PinFunctions {
    /// Digital output.
    pub digital_output: bool,
    /// Pulse-width output.
    pub pwm: bool,
    /// Digital input.
    pub digital_input: bool,
    /// Analog input.
    pub analog_input: bool,
}

impl TryFrom<String> for PinFunctions {
    type Error = String;

    fn try_from(words: String) -> Result<Self, String> {
        let mut pin = Self::default();
        for word in words.split_whitespace() {
            match word {
                "DO" => pin.digital_output = true,
                "PWM" => pin.pwm = true,
                "DI" => pin.digital_input = true,
                "ADC" => pin.analog_input = true,
                other => return Err(format!("a pin is DO, PWM, DI or ADC, not {other}")),
            }
        }
        Ok(pin)
    }
}

/// The lost-step threshold, deg.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct LostStepDefaults {
    pub threshold: f32,
}

/// The settings of the Wi-Fi module.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct WifiDefaults {
    pub ssid: String,
    pub password: String,
    pub dhcp: bool,
    pub address: [u8; 4],
    pub netmask: [u8; 4],
    pub gateway: [u8; 4],
    pub dns: [u8; 4],
}

impl Default for Identity {
    fn default() -> Self {
        Self {
            version: [3, 6, 14],
            name: "Dobot 2.0".to_owned(),
            serial: "00000001".to_owned(),
            device_id_seed: 1,
        }
    }
}

impl Default for PowerUp {
    fn default() -> Self {
        Self {
            joints: ArmModel::MAGICIAN.power_up.joints.to_array(),
            tool: ArmModel::MAGICIAN.geometry.tool,
            reset_alarm: true,
            queue_started: false,
        }
    }
}

impl Default for QueueRules {
    fn default() -> Self {
        Self {
            depth: 32,
            first_index: 2,
            alarms_hold: true,
            clear_ends_motion: true,
        }
    }
}

impl Default for Stopping {
    fn default() -> Self {
        Self { force_factor: 2.0 }
    }
}

impl Default for HandTeaching {
    fn default() -> Self {
        Self { period: 0.5 }
    }
}

impl Default for Wifi {
    fn default() -> Self {
        Self { association: 5.0 }
    }
}

impl Default for Offline {
    fn default() -> Self {
        Self { capacity: 4096 }
    }
}

impl Default for Tools {
    fn default() -> Self {
        Self {
            vacuum_delay: 0.3,
            gripper_delay: 0.5,
        }
    }
}

impl Default for Pins {
    fn default() -> Self {
        Self {
            strict: false,
            pins: FUNCTIONS.to_vec(),
        }
    }
}

const OUTPUT: PinFunctions = PinFunctions {
    digital_output: true,
    pwm: false,
    digital_input: false,
    analog_input: false,
};
const PULSES: PinFunctions = PinFunctions {
    pwm: true,
    ..OUTPUT
};
const INPUT: PinFunctions = PinFunctions {
    digital_output: false,
    digital_input: true,
    ..OUTPUT
};
const ANALOG: PinFunctions = PinFunctions {
    digital_input: true,
    analog_input: true,
    ..OUTPUT
};
const PULSES_OR_INPUT: PinFunctions = PinFunctions {
    digital_input: true,
    ..PULSES
};

/// What EIO 1 to 20 can do (model section 13).
const FUNCTIONS: [PinFunctions; PINS] = [
    ANALOG,
    OUTPUT,
    OUTPUT,
    PULSES,
    INPUT,
    PULSES,
    INPUT,
    PULSES,
    ANALOG,
    OUTPUT,
    PULSES,
    INPUT,
    OUTPUT,
    PULSES_OR_INPUT,
    ANALOG,
    OUTPUT,
    OUTPUT,
    OUTPUT,
    INPUT,
    INPUT,
];

impl Default for LostStepDefaults {
    fn default() -> Self {
        Self { threshold: 5.0 }
    }
}

impl Default for WifiDefaults {
    fn default() -> Self {
        Self {
            ssid: String::new(),
            password: String::new(),
            dhcp: true,
            address: [0; 4],
            netmask: [0; 4],
            gateway: [0; 4],
            dns: [0; 4],
        }
    }
}

impl From<PinFunctions> for String {
    fn from(pin: PinFunctions) -> Self {
        let words = [
            (pin.digital_output, "DO"),
            (pin.pwm, "PWM"),
            (pin.digital_input, "DI"),
            (pin.analog_input, "ADC"),
        ];
        let words: Vec<&str> = words
            .iter()
            .filter(|(can, _)| *can)
            .map(|(_, word)| *word)
            .collect();
        words.join(" ")
    }
}
