//! External sensors: switching them on, and interpreting their readings.

use magician_protocol::commands::{
    ColorSensor, GetColorSensor, GetIoAdc, GetIoDi, GetIrSwitch, IoAdc, IoDi, IrSwitch,
    SetColorSensor, SetIrSwitch,
};
use magician_protocol::{Port, SensorVersion, Set};

/// Full scale of an analog input, counts.
pub const ANALOG_COUNTS: u16 = 4095;
/// Volts at [`ANALOG_COUNTS`] (model section 13).
pub const ANALOG_VOLTS: f32 = 3.3;

/// Switches the colour sensor on a port on or off (document 1.15.7, errata E42). Read it by
/// `arm.get_with::<ColorSensor>(&build::color_at(port))`.
#[must_use]
pub fn color_sensor(port: Port, on: bool, version: SensorVersion) -> Set {
    SetColorSensor {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Switches the infrared sensor on a port on or off (document 1.15.8, errata E43). Read it by
/// `arm.get_with::<IrSwitch>(&build::infrared_at(port))`.
#[must_use]
pub fn infrared(port: Port, on: bool, version: SensorVersion) -> Set {
    SetIrSwitch {
        is_enabled: on.into(),
        port,
        version: Some(version),
    }
    .into()
}

/// Query for a colour sensor.
#[must_use]
pub fn color_at(port: Port) -> GetColorSensor {
    GetColorSensor { port: Some(port) }
}

/// Query for an infrared sensor.
#[must_use]
pub fn infrared_at(port: Port) -> GetIrSwitch {
    GetIrSwitch { port: Some(port) }
}

/// Query for a digital input (EIO address 1 to 20): `arm.get_with::<IoDi>(&build::level_at(19))`.
#[must_use]
pub fn level_at(address: u8) -> GetIoDi {
    GetIoDi {
        address: Some(address),
    }
}

/// Query for an analog input (EIO address 1 to 20): `arm.get_with::<IoAdc>(&build::analog_at(12))`.
#[must_use]
pub fn analog_at(address: u8) -> GetIoAdc {
    GetIoAdc {
        address: Some(address),
    }
}

/// A colour that the colour sensor distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Color {
    /// Red is strongest.
    Red,
    /// Green is strongest.
    Green,
    /// Blue is strongest.
    Blue,
}

/// Interpretation of a sensor's reading.
pub trait Sensed {
    /// Type of the interpreted value.
    type Value;

    /// Interprets the reading.
    ///
    /// ```
    /// use magician_host::commands::{ColorSensor, IoAdc};
    /// use magician_host::build::{Color, Sensed};
    ///
    /// assert_eq!(ColorSensor { r: 10, g: 200, b: 12 }.sensed(), Some(Color::Green));
    /// assert_eq!(ColorSensor { r: 0, g: 0, b: 0 }.sensed(), None);
    /// assert!(IoAdc { address: 12, value: 4095 }.sensed() == 3.3);
    /// ```
    fn sensed(&self) -> Self::Value;
}

impl Sensed for ColorSensor {
    type Value = Option<Color>;

    /// The strongest of the three colours. `None` if two are equally strong, and for a sensor that
    /// sees nothing.
    fn sensed(&self) -> Option<Color> {
        let Self { r, g, b } = *self;
        match (r, g, b) {
            _ if r > g && r > b => Some(Color::Red),
            _ if g > r && g > b => Some(Color::Green),
            _ if b > r && b > g => Some(Color::Blue),
            // A tie, or darkness: no colour is right.
            _ => None,
        }
    }
}

impl Sensed for IrSwitch {
    type Value = bool;

    /// True if something is in front of the sensor.
    fn sensed(&self) -> bool {
        self.state.is_on()
    }
}

impl Sensed for IoDi {
    type Value = bool;

    /// True if the input is high.
    fn sensed(&self) -> bool {
        self.level.is_on()
    }
}

impl Sensed for IoAdc {
    type Value = f32;

    /// Voltage, 0 to 3.3 V.
    fn sensed(&self) -> f32 {
        f32::from(self.value) / f32::from(ANALOG_COUNTS) * ANALOG_VOLTS
    }
}
