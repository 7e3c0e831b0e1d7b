//! Pins of the connectors: settings, output signals and input values (model section 13).

use magician_protocol::{Flag, IoFunction};

use crate::profile::{PINS, PinFunctions, pin_index};
use crate::{ArmInstant, World};

/// Lowest and highest PWM frequency, Hz (document 1.15.3).
const FREQUENCIES: [f64; 2] = [10.0, 1e6];
/// Analog value at 3.3 V.
const FULL_SCALE: u16 = 4095;

/// State of an EIO pin at an instant (model section 13).
///
/// Settings are stored and read back regardless of the pin's function. A setting takes effect only
/// while the pin has the function that uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PinState {
    /// EIO address, 1 to 20.
    pub address: u8,
    /// Function that the pin is multiplexed to.
    pub function: IoFunction,
    /// True if the pin has that function. A function that it lacks is stored without effect.
    pub able: bool,
    /// Level set for a digital output.
    pub level: bool,
    /// Frequency set for a PWM output, Hz, as sent.
    pub frequency: f32,
    /// Duty cycle set for a PWM output, percent, as sent.
    pub duty_cycle: f32,
    /// Signal that the pin puts out.
    pub signal: Signal,
    /// Value of GetIODI: low unless the pin is a digital input.
    pub input: bool,
    /// Value of GetIOADC, 0 to 4095 for 0 to 3.3 V: 0 unless the pin is an analog input.
    pub analog: u16,
}

/// Output signal of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// No signal: the pin is an input, has no function, or lacks its function.
    Undriven,
    /// A digital output, high or low.
    Level(bool),
    /// A PWM output.
    Pulses {
        /// Frequency, Hz, 10 to 1,000,000.
        frequency: f64,
        /// Duty cycle, 0 to 100 percent.
        duty_cycle: f64,
    },
}

impl Signal {
    /// Share of the time that the pin is high, 0 to 100 percent; `None` if it puts out nothing.
    #[must_use]
    pub fn share(self) -> Option<f64> {
        match self {
            Self::Undriven => None,
            Self::Level(high) => Some(if high { 100.0 } else { 0.0 }),
            Self::Pulses { duty_cycle, .. } => Some(duty_cycle),
        }
    }
}

/// Settings of one pin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pin {
    pub(crate) function: IoFunction,
    pub(crate) level: Flag,
    pub(crate) frequency: f32,
    pub(crate) duty_cycle: f32,
}

impl Pin {
    const NEW: Self = Self {
        function: IoFunction::None,
        level: Flag::OFF,
        frequency: 0.0,
        duty_cycle: 0.0,
    };

    fn signal(&self, able: PinFunctions) -> Signal {
        match self.function {
            IoFunction::DigitalOutput if able.digital_output => Signal::Level(self.level.is_on()),
            IoFunction::Pwm if able.pwm => self.pulses(),
            // Inputs, no function, and functions that this pin lacks.
            _ => Signal::Undriven,
        }
    }

    /// PWM signal, clamped to its ranges; NaN gives no pulses.
    fn pulses(&self) -> Signal {
        if self.frequency.is_nan() || self.duty_cycle.is_nan() {
            return Signal::Level(false);
        }
        let [least, most] = FREQUENCIES;
        Signal::Pulses {
            frequency: f64::from(self.frequency).clamp(least, most),
            duty_cycle: f64::from(self.duty_cycle).clamp(0.0, 100.0),
        }
    }
}

/// The pins, indexed by address less one.
#[derive(Clone, Debug)]
pub(crate) struct Pins {
    pins: [Pin; PINS],
    /// Functions that each pin has.
    abilities: [PinFunctions; PINS],
    /// Address that a get without one refers to (errata E39).
    last_address: u8,
}

impl Pins {
    pub(crate) fn new(abilities: [PinFunctions; PINS]) -> Self {
        Self {
            pins: [Pin::NEW; PINS],
            abilities,
            // Pin 1 at first (E39).
            last_address: 1,
        }
    }

    /// Returns the pin of an address and makes it the one addressed last. `None` if there is no
    /// such pin.
    pub(crate) fn addressed(&mut self, address: u8) -> Option<&mut Pin> {
        let pin = self.pins.get_mut(pin_index(address)?)?;
        self.last_address = address;
        Some(pin)
    }

    /// Returns address and pin of a get. A missing address reads as an unset pin.
    pub(crate) fn asked(&mut self, address: Option<u8>) -> (u8, Pin) {
        let address = address.unwrap_or(self.last_address);
        (
            address,
            self.addressed(address).copied().unwrap_or(Pin::NEW),
        )
    }

    fn at(&self, address: u8) -> Pin {
        pin_index(address)
            .and_then(|at| self.pins.get(at))
            .copied()
            .unwrap_or(Pin::NEW)
    }
}

pub(crate) fn can_do(pin: PinFunctions, function: IoFunction) -> bool {
    match function {
        IoFunction::None => true,
        IoFunction::DigitalOutput => pin.digital_output,
        IoFunction::Pwm => pin.pwm,
        IoFunction::DigitalInput
        | IoFunction::DigitalInputPullUp
        | IoFunction::DigitalInputPullDown => pin.digital_input,
        IoFunction::AnalogInput => pin.analog_input,
        // A function number that no source names.
        IoFunction::Unknown(_) => false,
    }
}

/// Functions and values.
impl Pins {
    /// Functions that a pin has; none if there is no such pin.
    pub(crate) fn abilities_of(&self, address: u8) -> PinFunctions {
        pin_index(address)
            .and_then(|at| self.abilities.get(at))
            .copied()
            .unwrap_or_default()
    }

    /// Output signal of a pin.
    pub(crate) fn signal(&self, address: u8) -> Signal {
        self.at(address).signal(self.abilities_of(address))
    }

    /// Function of a pin, `None` if the pin lacks it.
    fn function(&self, address: u8) -> IoFunction {
        let function = self.at(address).function;
        if can_do(self.abilities_of(address), function) {
            function
        } else {
            IoFunction::None
        }
    }

    /// Value of a digital input. Without a connection the pin reads the level of its pull resistor;
    /// a pin without this function reads low.
    pub(crate) fn digital(&self, address: u8, world: &World, now: ArmInstant) -> bool {
        let floating = match self.function(address) {
            IoFunction::DigitalInput | IoFunction::DigitalInputPullDown => false,
            IoFunction::DigitalInputPullUp => true,
            // Not a digital input.
            _ => return false,
        };
        // An analog voltage on a digital input switches at half of the supply.
        let analog = || Some(world.analog(now, address)? > FULL_SCALE / 2);
        world
            .digital(now, address)
            .or_else(analog)
            .unwrap_or(floating)
    }

    /// Value of an analog input: 0 without a connection, and for a pin without this function.
    pub(crate) fn analog(&self, address: u8, world: &World, now: ArmInstant) -> u16 {
        if self.function(address) != IoFunction::AnalogInput {
            return 0;
        }
        // A digital level reads as one of the ends of the range.
        let level = || {
            let high = world.digital(now, address)?;
            Some(if high { FULL_SCALE } else { 0 })
        };
        world
            .analog(now, address)
            .or_else(level)
            .map_or(0, |value| value.min(FULL_SCALE))
    }

    pub(crate) fn state(&self, address: u8, world: &World, now: ArmInstant) -> PinState {
        let Pin {
            function,
            level,
            frequency,
            duty_cycle,
        } = self.at(address);
        PinState {
            address,
            function,
            able: can_do(self.abilities_of(address), function),
            level: level.is_on(),
            frequency,
            duty_cycle,
            signal: self.signal(address),
            input: self.digital(address, world, now),
            analog: self.analog(address, world, now),
        }
    }
}
