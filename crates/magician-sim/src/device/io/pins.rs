//! The pins of the connectors: what each was told, what it puts out and what it reads (model
//! section 13).

use magician_protocol::{Flag, IoFunction};

use crate::profile::{PINS, PinFunctions, pin_index};
use crate::{ArmInstant, World};

/// Frequencies that a pulse-width output has, Hz (document 1.15.3).
const FREQUENCIES: [f64; 2] = [10.0, 1e6];
/// The analog reading at 3.3 V.
const FULL_SCALE: u16 = 4095;

/// One of the 20 EIO pins at an instant (model section 13).
///
/// What was set stays set and reads back whatever the pin does; it shows on the pin only while the
/// pin has the function that puts it out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PinState {
    /// EIO address, 1 to 20.
    pub address: u8,
    /// The function that it was multiplexed to.
    pub function: IoFunction,
    /// Whether the pin has that function; one that it lacks is stored and has no effect.
    pub able: bool,
    /// The level that was set for it as a digital output.
    pub level: bool,
    /// The frequency that was set for it as a pulse-width output, Hz, as it came.
    pub frequency: f32,
    /// The duty cycle that was set for it as a pulse-width output, percent, as it came.
    pub duty_cycle: f32,
    /// What it puts out.
    pub signal: Signal,
    /// What GetIODI reads: low unless the pin is a digital input.
    pub input: bool,
    /// What GetIOADC reads, 0 to 4095 for 0 to 3.3 V: 0 unless the pin is an analog input.
    pub analog: u16,
}

/// What a pin puts out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// Nothing: it is an input, has no function, or lacks the one that it was given.
    Undriven,
    /// A digital output, high or low.
    Level(bool),
    /// A pulse-width output.
    Pulses {
        /// Pulses a second, 10 to 1,000,000.
        frequency: f64,
        /// Share of the time that it is high, 0 to 100 percent.
        duty_cycle: f64,
    },
}

impl Signal {
    /// How much of the time the pin is high, 0 to 100 percent; `None` when it puts out nothing.
    #[must_use]
    pub fn share(self) -> Option<f64> {
        match self {
            Self::Undriven => None,
            Self::Level(high) => Some(if high { 100.0 } else { 0.0 }),
            Self::Pulses { duty_cycle, .. } => Some(duty_cycle),
        }
    }
}

/// What one pin was told.
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
            _ => Signal::Undriven,
        }
    }

    /// Values out of range count as the nearest in range; without a number there are no pulses.
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

/// The pins, by address less one.
#[derive(Clone, Debug)]
pub(crate) struct Pins {
    pins: [Pin; PINS],
    /// What each can do.
    abilities: [PinFunctions; PINS],
    /// What a get without an address asks for (errata E39).
    last_address: u8,
}

impl Pins {
    pub(crate) fn new(abilities: [PinFunctions; PINS]) -> Self {
        Self {
            pins: [Pin::NEW; PINS],
            abilities,
            last_address: 1,
        }
    }

    /// The pin of an address, `None` when there is none; it is now the one addressed last.
    pub(crate) fn addressed(&mut self, address: u8) -> Option<&mut Pin> {
        let pin = self.pins.get_mut(pin_index(address)?)?;
        self.last_address = address;
        Some(pin)
    }

    /// Address and pin of a get; an address that there is not reads as a pin that was told nothing.
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
        IoFunction::Unknown(_) => false,
    }
}

/// What they do.
impl Pins {
    /// What a pin can do; nothing where there is none.
    pub(crate) fn abilities_of(&self, address: u8) -> PinFunctions {
        pin_index(address)
            .and_then(|at| self.abilities.get(at))
            .copied()
            .unwrap_or_default()
    }

    /// What a pin puts out.
    pub(crate) fn signal(&self, address: u8) -> Signal {
        self.at(address).signal(self.abilities_of(address))
    }

    /// The function of a pin, if it has it.
    fn function(&self, address: u8) -> IoFunction {
        let function = self.at(address).function;
        if can_do(self.abilities_of(address), function) {
            function
        } else {
            IoFunction::None
        }
    }

    /// What a digital input reads: without a connection what its resistor pulls it to. A pin that
    /// is none reads low.
    pub(crate) fn digital(&self, address: u8, world: &World, now: ArmInstant) -> bool {
        let floating = match self.function(address) {
            IoFunction::DigitalInput | IoFunction::DigitalInputPullDown => false,
            IoFunction::DigitalInputPullUp => true,
            _ => return false,
        };
        let analog = || Some(world.analog(now, address)? > FULL_SCALE / 2);
        world
            .digital(now, address)
            .or_else(analog)
            .unwrap_or(floating)
    }

    /// What an analog input reads: 0 without a connection. A pin that is none reads 0.
    pub(crate) fn analog(&self, address: u8, world: &World, now: ArmInstant) -> u16 {
        if self.function(address) != IoFunction::AnalogInput {
            return 0;
        }
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
