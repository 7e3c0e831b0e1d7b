//! Sections of a profile that do not concern motion, with the values of firmware 3.6.14.
//! `pattern.txt` gives the source of each value.

use magician_motion::{ArmModel, ToolBias};
use serde::{Deserialize, Serialize};

use super::{PINS, tool};

/// Handling of behaviour that is unknown in the real arm ([`fidelity`](crate::fidelity)).
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FidelityRules {
    /// True if a command that relies on a choice without a source is answered but not carried out.
    pub strict: bool,
}

/// Identity of the arm (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Identity {
    /// Firmware version.
    pub version: [u8; 3],
    /// Name, at most 64 bytes.
    pub name: String,
    /// Serial number, at most 23 bytes.
    pub serial: String,
    /// Seed of the three words of GetDeviceID.
    pub device_id_seed: u64,
}

/// State of the controller at power-up (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PowerUp {
    /// Joints reported before homing, deg.
    pub joints: [f64; 4],
    /// Tool bias kept from before power-up, mm; in the file, the name of a tool or `[x, y, z]`.
    ///
    /// A tool given by the scenario takes precedence.
    #[serde(deserialize_with = "tool::read", serialize_with = "tool::write")]
    pub tool: ToolBias,
    /// True if alarm 0x00 is active.
    pub reset_alarm: bool,
    /// True if the queue runs without a start.
    pub queue_started: bool,
}

/// Behaviour of the command queue (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct QueueRules {
    /// Number of places, including that of the running command; 1 to 1024.
    pub depth: usize,
    /// Index of the first command, at least 1.
    pub first_index: u64,
    /// True if an alarm above 0x07 holds the queue.
    pub alarms_hold: bool,
    /// True if Clear ends the running motion where it is.
    pub clear_ends_motion: bool,
}

/// Stops (model section 14).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Stopping {
    /// Factor on the acceleration in force when ForceStop brakes; above 0.
    pub force_factor: f64,
}

/// Hand teaching (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct HandTeaching {
    /// Interval between points taught while the unlock key is held, s; above 0.
    pub period: f64,
}

/// Wi-Fi module (model section 15).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wifi {
    /// Time to join the network, from power-up or from leaving the command mode, s.
    pub association: f64,
}

/// Programs stored in the flash, which the arm runs without a host (model section 12).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Offline {
    /// Most commands of a program, 1 to 65536.
    pub capacity: usize,
}

/// Suction cup and gripper (model section 15a).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tools {
    /// Time from the command until the suction cup holds or lets go, s.
    pub vacuum_delay: f64,
    /// Time from the command until the gripper is closed or open, s.
    pub gripper_delay: f64,
}

/// Pins of the connectors (model section 13).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pins {
    /// True if a function that the pin lacks is refused; else it is stored without effect.
    pub strict: bool,
    /// Functions of each of the 20 addresses.
    pub pins: Vec<PinFunctions>,
}

/// Functions of one pin; in the file, words out of `DO`, `PWM`, `DI` and `ADC`.
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

/// Lost-step threshold, deg.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs)]
pub struct LostStepDefaults {
    pub threshold: f32,
}

/// Settings of the Wi-Fi module.
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
            // The vendor's help shows this version; the document describes three bytes (model
            // section 15).
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
            // Active after every power-up until it is cleared (model section 11).
            reset_alarm: true,
            // Queued commands do not run before the first start (E47).
            queue_started: false,
        }
    }
}

impl Default for QueueRules {
    fn default() -> Self {
        Self {
            // Four host libraries assume 32; the document does not say (model section 14).
            depth: 32,
            // The lowest index in a captured session; the vendor's host takes a target of 0 for an
            // error.
            first_index: 2,
            // Seen on real arms; the vendor's simulator ignores alarms (model section 4).
            alarms_hold: true,
            // The vendor's simulator does this. It was never observed on an arm, so the host does
            // not rely on it.
            clear_ends_motion: true,
        }
    }
}

impl Default for Stopping {
    fn default() -> Self {
        // The vendor's simulator brakes with twice the PTP acceleration (model section 14).
        Self { force_factor: 2.0 }
    }
}

impl Default for HandTeaching {
    fn default() -> Self {
        // A choice: the document has the periodic mode, but not its period (model section 12).
        Self { period: 0.5 }
    }
}

impl Default for Wifi {
    fn default() -> Self {
        // "Some seconds" until the green lamp (model section 15); the number is a choice.
        Self { association: 5.0 }
    }
}

impl Default for Offline {
    fn default() -> Self {
        // A choice: no source gives the size of the flash.
        Self { capacity: 4096 }
    }
}

impl Default for Tools {
    fn default() -> Self {
        Self {
            // Choices (model section 15a): no source gives either time.
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

// The combinations of functions in the pin table (model section 13).
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

/// Functions of EIO 1 to 20 (model section 13).
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
